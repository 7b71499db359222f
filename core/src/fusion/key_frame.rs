//! Key frame: the scene of the last pair that was added, and how far the scene has moved since then (`ESTIMATOR.md`,
//! section 14). Errors of matches stay with the scene, outliers included. So a pair counts by how far the scene has
//! moved: a standing vehicle adds one pair, and a creeping one adds information with the distance that it travels.

use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;
use crate::thresholds::{
    COPIED_SHARE, FAR_STEPS, KEY_STEPS, REMEMBERED, REMEMBERED_STEPS_PER_PX, SAME_SHARE, SAME_STEPS,
};

/// Motion of the scene in the images since the key frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Moved {
    /// Motion, in steps of a quarter of a pixel, at most [`FAR_STEPS`].
    steps: u16,
    /// Whether nearly all matches have the same coordinates in whole steps: a copy of the key frame.
    is_copy: bool,
}

impl Moved {
    /// Another scene.
    pub(super) const FAR: Self = Self { steps: FAR_STEPS, is_copy: false };

    /// Returns whether the pair adds no information, because the scene has hardly moved.
    pub(super) fn is_repeated(self) -> bool {
        self.steps <= SAME_STEPS
    }

    /// Returns whether the pair is a copy of the key frame.
    pub(super) fn is_copy(self) -> bool {
        self.is_copy
    }

    /// Returns the share of the information of a pair that is new, above 0 to 1, for a pair that is not repeated: the
    /// motion over [`KEY_STEPS`].
    pub(super) fn share<T: Scalar>(self) -> T {
        (T::count(self.steps.into()) / T::count(KEY_STEPS.into())).min(T::ONE)
    }

    /// Returns the factor, at least 1, by which the gradients of successive pairs scatter more than their shares say,
    /// in variance: errors that stay with the scene up to a motion of [`FAR_STEPS`] are alike in these pairs.
    pub(super) fn scatter<T: Scalar>(self) -> T {
        T::count(FAR_STEPS.into()) / T::count(self.steps.max(KEY_STEPS).into())
    }
}

/// Sampled correspondences of the last pair that was added. RAM: 6 bytes per sample.
#[derive(Debug, Clone)]
pub(super) struct KeyFrame {
    remembered: Sampled,
}

/// Samples. The length has 8 bits, so that the slice has a valid size even if a fault has overwritten the length.
type Sampled = heapless::Vec<[u16; 3], REMEMBERED, u8>;

impl KeyFrame {
    pub(super) const NONE: Self = Self { remembered: heapless::Vec::new() };

    /// Returns whether the length is within the capacity.
    pub(super) fn is_within(&self) -> bool {
        self.remembered.len() <= REMEMBERED
    }

    /// Returns how far the scene of a batch has moved since the key frame: the least distance within which more than
    /// [`SAME_SHARE`] of the remembered correspondences are found again. Beyond the motion of a scene at rest, those
    /// that another scene would contain by chance do not count: as many as are found at displaced places.
    #[inline(never)]
    pub(super) fn compare<T: Scalar>(&self, pairs: &[RayPair<T>], focal: T) -> Moved {
        let scale = focal * T::lit(REMEMBERED_STEPS_PER_PX);
        let (found, copied) = self.find(pairs, scale, [0; 2]);
        let part = |share| (T::lit(share) * count::<T>(self.remembered.len())).to_u16();
        let (mut least, mut within) = (part(SAME_SHARE), 0);
        let is_copy = copied > part(COPIED_SHARE);
        let at_rest = usize::from(SAME_STEPS) + 1;
        for (at_distance, steps) in found.iter().zip(0..).take(at_rest) {
            within += u16::from(*at_distance);
            if within > least {
                return Moved { steps, is_copy };
            }
        }
        let (by_chance, _) = self.find(pairs, scale, DISPLACED);
        for ((at_distance, chance), steps) in found.iter().zip(by_chance).zip(0..).skip(at_rest) {
            within += u16::from(*at_distance);
            least += u16::from(chance);
            if within > least {
                return Moved { steps, is_copy };
            }
        }
        Moved { steps: FAR_STEPS, is_copy }
    }

    /// Makes the batch of a pair that was added the key frame.
    #[inline(never)]
    pub(super) fn remember<T: Scalar>(&mut self, pairs: &[RayPair<T>], focal: T) {
        let scale = focal * T::lit(REMEMBERED_STEPS_PER_PX);
        self.remembered.clear();
        let stride = pairs.len().div_ceil(REMEMBERED).max(1);
        for pair in pairs.iter().step_by(stride) {
            // With this stride the samples fit the capacity.
            let _ = self.remembered.push(coordinates(pair, scale));
        }
    }

    /// Returns the number of remembered correspondences that a batch contains at each distance, in steps below
    /// [`FAR_STEPS`], and the number whose coordinates are the same in whole steps.
    ///
    /// * `scale`: coordinate steps per unit at unit depth.
    /// * `[right, down]`: displacement of the remembered correspondences, in steps.
    #[inline(never)]
    fn find<T: Scalar>(
        &self,
        pairs: &[RayPair<T>],
        scale: T,
        [right, down]: [u16; 2],
    ) -> ([u8; DISTANCES], u16) {
        let mut found = [0; DISTANCES];
        let (mut distances, mut copied) = ([FAR_STEPS; REMEMBERED], 0_u32);
        let [columns, rows] = [(0, right), (1, down)].map(|(axis, by)| {
            let along = |old: &[u16; 3]| old.get(axis).map_or(0, |x| x.saturating_add(by));
            Buckets::of(self.remembered.iter().map(along))
        });
        for pair in pairs {
            let mut left = columns.near(steps(pair.left.x, scale)) & !copied;
            if left == 0 {
                continue;
            }
            left &= rows.near(steps(pair.left.y, scale));
            if left == 0 {
                continue;
            }
            let [column, row, other] = coordinates(pair, scale);
            let new = [
                column.saturating_sub(right),
                row.saturating_sub(down),
                other.saturating_sub(right),
            ];
            while left != 0 {
                let place = left.trailing_zeros();
                left &= left - 1;
                let Ok(at) = usize::try_from(place) else { continue };
                let places = (self.remembered.get(at), distances.get_mut(at));
                let (Some(old), Some(distance)) = places else { continue };
                let apart = new.iter().zip(old).map(|(a, b)| a.abs_diff(*b));
                let apart = apart.fold(0, u16::max);
                if apart == 0 {
                    copied |= 1_u32.checked_shl(place).unwrap_or(0);
                }
                if apart < FAR_STEPS {
                    // A pixel near the border of a wide-angle lens is larger.
                    let apart = (T::count(apart.into()) / pair.scale()).to_u16();
                    *distance = (*distance).min(apart);
                }
            }
        }
        for distance in distances {
            if let Some(count) = found.get_mut(usize::from(distance)) {
                *count += 1;
            }
        }
        (found, u16::try_from(copied.count_ones()).unwrap_or(u16::MAX))
    }

    pub(super) fn clear(&mut self) {
        self.remembered.clear();
    }
}

/// Displacement at which correspondences are found by chance only: right and down, in steps. It is beyond
/// [`FAR_STEPS`], and the two numbers have no common divisor, because of regular patterns.
const DISPLACED: [u16; 2] = [211, 149];

/// Number of distances that are counted apart.
const DISTANCES: usize = 64;
const _: () = assert!(FAR_STEPS <= 64, "each distance below it is counted");

/// Remembered correspondences by one coordinate, in 32 buckets that repeat. Each bucket is a set with one bit per
/// correspondence.
struct Buckets([u32; 32]);

/// Width of a bucket as a power of 2, steps.
const BUCKET_BITS: u32 = FAR_STEPS.ilog2() + 1;

impl Buckets {
    #[inline(never)]
    fn of(remembered: impl Iterator<Item = u16>) -> Self {
        let mut buckets = Self([0; 32]);
        for (steps, place) in remembered.zip(0_u32..) {
            // Enters both ends of the interval of distances below `FAR_STEPS`, which is narrower than a bucket.
            let most = FAR_STEPS - 1;
            for end in [steps.saturating_sub(most), steps.saturating_add(most)] {
                if let Some(bucket) = buckets.0.get_mut(Self::of_coordinate(end)) {
                    *bucket |= 1_u32.checked_shl(place).unwrap_or(0);
                }
            }
        }
        buckets
    }

    /// Returns the remembered correspondences that may be within the tolerance of a coordinate.
    fn near(&self, steps: u16) -> u32 {
        self.0.get(Self::of_coordinate(steps)).copied().unwrap_or(0)
    }

    fn of_coordinate(steps: u16) -> usize {
        usize::from((steps >> BUCKET_BITS) & 31)
    }
}

/// Returns left column, left row and right column in quantisation steps ([`steps`]). The right row is omitted, because
/// it nearly equals the left row.
fn coordinates<T: Scalar>(pair: &RayPair<T>, scale: T) -> [u16; 3] {
    let ([a, b], [c, _]) = (pair.left(), pair.right());
    [steps(a, scale), steps(b, scale), steps(c, scale)]
}

/// Returns a coordinate of a ray at unit depth, in quantisation steps plus 32,768, so that no image has a negative
/// number.
///
/// * `scale`: steps per unit at unit depth.
fn steps<T: Scalar>(x: T, scale: T) -> u16 {
    (x * scale + T::lit(32_768.0)).to_u16()
}

fn count<T: Scalar>(n: usize) -> T {
    T::count(u32::try_from(n).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests;
