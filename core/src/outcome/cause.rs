//! The likeliest mistake in rig file or matcher, as pairs and matches show it.

use crate::batch::Batch;
use crate::error::Rejection;
use crate::scalar::Scalar;
use crate::thresholds::{CAUSE_SHARE, MIN_AGREED};

/// A mistake that keeps pairs from agreeing, or their matches from supporting a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Cause {
    /// The points are behind the cameras.
    Reversed,
    /// Disparities run along the columns, and nothing shows that u and v are exchanged.
    Upright,
    /// Disparities run along the columns, some pixels were refused, and all accepted matches are within the square that
    /// an image and its transpose have in common.
    Transposed,
    /// Most matches have the same motion between the images, and nothing shows depth.
    SameImage,
    /// Most matches are refused, usually because a pixel is outside the images of the cameras.
    SmallerImages,
    /// The matches of all pairs fill the upper left quarter of the left image and nothing else.
    LargerImages,
    /// Most matches are refused, usually because a pixel has no ray: it is more than 85 degrees off the optical axis,
    /// or the lens model is not invertible there.
    FocalLength,
    /// Pairs show an error of the lens models that is too large for any calibration.
    Lens,
    /// The matches agree on nothing.
    Mismatches,
    /// Nearly all rows of left and right are equal, so the matcher has not measured them.
    RowsNotMeasured,
    /// Pairs fit well alone, and not each other.
    Moments,
}

// 0 is free for the absence of a cause.
codes! {
    Cause {
        Reversed = 1, Upright = 2, Transposed = 3, SameImage = 4, SmallerImages = 5, LargerImages = 6,
        FocalLength = 7, Lens = 8, Mismatches = 9, RowsNotMeasured = 10,
        Moments = 11,
    }
}
texts! {
    Cause {
        Reversed = "left and right exchanged, t of the other sign, one image mirrored, or both upside down",
        Upright = "cameras one above the other, or t of the factory extrinsics turned",
        Transposed = "u and v exchanged",
        SameImage = "the same image on both sides",
        SmallerImages = "cameras of smaller images, or pixels from another origin than the upper left",
        LargerImages = "cameras of larger images, or matches in one quarter of the image only",
        FocalLength = "focal length or lens of another unit or image, such as mm",
        Lens = "another lens, or points that are undistorted already",
        Mismatches = "matches that agree on nothing",
        RowsNotMeasured = "rows not measured: the matcher searches along rows",
        Moments = "left and right of different moments, a moving mount, or a rolling shutter",
    }
}

/// Counts of the mistakes that pairs have shown since the estimate was last locked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Causes {
    /// Pairs that showed each cause, in the order of the codes.
    pairs: [u8; 11],
}

impl Causes {
    pub(crate) const NONE: Self = Self { pairs: [0; 11] };

    /// Counts a pair that shows a cause. All counts are halved when one reaches its largest value, so old pairs fade.
    pub(crate) fn add(&mut self, cause: Cause) {
        let index = usize::from(cause.code()).wrapping_sub(1);
        if let Some(count) = self.pairs.get_mut(index) {
            *count = count.saturating_add(1);
            if *count == u8::MAX {
                self.pairs = self.pairs.map(|count| count / 2);
            }
        }
    }

    /// Forgets the causes, because a pair has locked the estimate. [`Cause::Moments`] stays: pairs of different moments
    /// agree now and then.
    pub(crate) fn forget(&mut self) {
        let [others @ .., _] = &mut self.pairs;
        *others = [0; 10];
    }

    /// Notes whether the estimate fits a pair that was solved. A pair that it misses shows [`Cause::Moments`], and each
    /// pair that it fits removes one of these.
    pub(crate) fn compare(&mut self, agrees: bool) {
        let [.., moments] = &mut self.pairs;
        if agrees {
            *moments = moments.saturating_sub(1);
        } else {
            self.add(Cause::Moments);
        }
    }

    /// Returns the likeliest cause, from the fourth pair on. A cause is possible if more than one in [`CAUSE_SHARE`]
    /// pairs shows it. [`Cause::Upright`] and [`Cause::Transposed`] win over all other causes, because pairs with one
    /// of these mistakes may also fit with the points behind the cameras. [`Cause::Mismatches`] loses against all other
    /// causes, because any mistake also causes pairs without agreement. Otherwise the number of pairs decides.
    pub(crate) fn likeliest(&self) -> Option<Cause> {
        let pairs: u32 = self.pairs.iter().map(|count| u32::from(*count)).sum();
        let enough = |(_, count): &(Cause, u8)| u32::from(*count) * CAUSE_SHARE > pairs;
        let turned = |cause| matches!(cause, Cause::Upright | Cause::Transposed);
        let rank = |(cause, count): (Cause, u8)| (turned(cause), cause != Cause::Mismatches, count);
        let found = Cause::ALL.into_iter().zip(self.pairs).filter(enough);
        let found = found.max_by_key(|of| rank(*of)).map(|(cause, _)| cause);
        found.filter(|_| pairs > u32::from(MIN_AGREED))
    }
}

impl Cause {
    /// All causes, in the order of their codes.
    pub const ALL: [Self; 11] = [
        Self::Reversed,
        Self::Upright,
        Self::Transposed,
        Self::SameImage,
        Self::SmallerImages,
        Self::LargerImages,
        Self::FocalLength,
        Self::Lens,
        Self::Mismatches,
        Self::RowsNotMeasured,
        Self::Moments,
    ];

    /// Returns the setup mistake that the pixels of a batch show. Either most matches since the last [`Batch::clear`]
    /// were refused for a pixel; or all matches so far fill the upper left quarter of the left image and nothing else.
    pub(crate) fn of_pixels<T: Scalar, const N: usize>(batch: &Batch<T, N>) -> Option<Self> {
        if batch.refused_by_pixel() > batch.offered() / 2 {
            let most_without_ray = batch.without_ray() > batch.refused_by_pixel() / 2;
            Some(if most_without_ray { Self::FocalLength } else { Self::SmallerImages })
        } else {
            batch.seen().fills_a_corner().then_some(Self::LargerImages)
        }
    }

    /// Returns the setup mistake that an unsolved pair shows; `None` if the matches are not at fault.
    ///
    /// * `why`: reason for the failure; `size`: width and height of the left image, px.
    pub(crate) fn of_unsolved<T: Scalar, const N: usize>(
        batch: &Batch<T, N>,
        why: Rejection,
        size: [u16; 2],
    ) -> Option<Self> {
        if let Some(cause) = Self::of_pixels(batch) {
            return Some(cause);
        }
        // All accepted matches are in the square that an image and its transpose have in common.
        let transposed = batch.refused() > 0 && batch.seen().is_of_the_square(size);
        let cause = match why {
            Rejection::Behind => Self::Reversed,
            Rejection::Columns if transposed => Self::Transposed,
            Rejection::Columns => Self::Upright,
            Rejection::NoConsensus | Rejection::Unobservable => Self::Mismatches,
            Rejection::NoDepth => Self::SameImage,
            Rejection::RowsNotMeasured => Self::RowsNotMeasured,
            _ => return None,
        };
        Some(if batch.is_moved_alike() { Self::SameImage } else { cause })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(pairs: &[(Cause, u8)]) -> Option<Cause> {
        let mut causes = Causes::NONE;
        for (cause, count) in pairs {
            (0..*count).for_each(|_| causes.add(*cause));
        }
        causes.likeliest()
    }

    #[test]
    fn the_likeliest_cause_is_named_from_the_fourth_pair_on() {
        assert_eq!([3, 4].map(|n| after(&[(Cause::Lens, n)])), [None, Some(Cause::Lens)]);
        assert_eq!(after(&[(Cause::Lens, 2), (Cause::Reversed, 3)]), Some(Cause::Reversed));
        assert_eq!(after(&[(Cause::Upright, 2), (Cause::Reversed, 9)]), Some(Cause::Upright));
    }

    #[test]
    fn chance_names_no_cause_and_few_pairs_can_name_one() {
        let named = |n| after(&[(Cause::Mismatches, 20), (Cause::Upright, n)]).unwrap();
        let [chance, few, more] = [1, 2, 3].map(named);
        assert_eq!([chance, few, more], [Cause::Mismatches, Cause::Mismatches, Cause::Upright]);
    }

    #[test]
    fn counts_never_overflow_and_old_pairs_fade() {
        let mut causes = Causes::NONE;
        (0..1000).for_each(|_| causes.add(Cause::Reversed));
        (0..300).for_each(|_| causes.add(Cause::SameImage));
        assert_eq!(causes.likeliest(), Some(Cause::SameImage));
    }

    #[test]
    fn all_causes_are_in_the_order_of_their_codes() {
        assert!(Cause::ALL.iter().zip(1..).all(|(cause, code)| cause.code() == code));
    }
}
