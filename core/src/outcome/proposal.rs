//! The estimate over all pairs, with its deviations and the reasons against it.

use core::fmt;

use nalgebra::{ComplexField, Matrix5, Vector5};

use crate::algebra::information::{StandardDeviations, largest_direction};
use crate::algebra::lens_prior::LensPrior;
use crate::algebra::symmetric5::Symmetric5;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::LensCorrection;
use crate::outcome::cause::Cause;
use crate::outcome::lens_estimate::{Finding, LensEstimate};
use crate::outcome::reasons::{Reason, Reasons};
use crate::outcome::vibration::Vibration;
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{MAX_CONFIRMED_YAW_RAD, SIGNIFICANT};

/// The estimate over all pairs so far.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Proposal<T: Scalar> {
    /// The best `R`, `t`.
    pub extrinsics: Extrinsics<T>,
    /// Correction of the cameras that the extrinsics belong to. Only [`crate::LensTracking::Compensate`] corrects
    /// cameras.
    pub correction: LensCorrection<T>,
    /// The extrinsics that [`crate::Calibrator::apply`] puts into use: the best `R`, `t`, or the `t` in use with the
    /// best `R` for it. The `t` in use is kept in three cases: the baseline is not observed; it is observed, but still
    /// uncertain, and the `t` in use does not differ from it significantly; or image halves disagree with exact lens
    /// models ([`Reason::ImageHalves`]). In the first two cases the best `R`, `t` are applied nevertheless if pairs
    /// determine the baseline with the lens models as given, there are three or more, and their row offsets are clearly
    /// smaller. If no `R` fits the `t` in use, this is the calibration in use.
    pub applicable: Extrinsics<T>,
    /// Correction of the cameras that `applicable` belongs to.
    pub applicable_correction: LensCorrection<T>,
    /// Number of pairs in the estimate; pairs of a repeated scene count once.
    pub pairs: u32,
    /// Standard deviations of the error, with the lens models as given. They follow from the information, and are
    /// increased by drift, by vibration, if the pairs scatter more than the information predicts, and if image halves
    /// disagree.
    pub sd: StandardDeviations<T>,
    /// Covariance of the five unknowns with the lens models as given, rad^2, in the order of
    /// [`crate::outcome::Information`] and as [`crate::geometry::RectifyingRotations::unknowns_to`] measures them.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "rows"))]
    pub covariance: Matrix5<T>,
    /// Standard deviations with the lens models uncertain ([`crate::Config::with_lens_prior`]). Their yaw is the yaw of
    /// the mount, as rows, factory calibration and witnesses determine it. They equal `sd` without a lens prior as long
    /// as no witness is taken.
    pub sd_lens: StandardDeviations<T>,
    /// Covariance with the lens models uncertain, as `covariance`.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "rows"))]
    pub covariance_lens: Matrix5<T>,
    /// Errors of the lens models that the pairs show; `None` without a lens prior.
    pub lens: Option<LensEstimate<T>>,
    /// Apparent yaw `a` of the lenses, rad: with `extrinsics` the right row is below the left one by `a x y`, at unit
    /// depth. Rows alone do not separate it from the yaw of the mount. `extrinsics` do not contain it, because depth
    /// needs the yaw of the mount.
    pub lens_yaw: Finding<T>,
    /// Whether pairs have determined the baseline direction: its variance is at most an eighth of the variance of the
    /// prior. Points more than some thousand baselines away do not observe it, because their disparities are noise.
    pub baseline_observed: bool,
    /// Whether the pairs fit the estimate clearly better than the calibration in use: their RMS row offset is smaller by
    /// a tenth, and `applicable` differs from that in use by more than chance. `None` if the calibration in use or
    /// `applicable` belongs to other cameras than the rays of the pairs ([`crate::LensTracking::Compensate`]), because
    /// the sums over the pairs cannot compare the two then.
    pub improves: Option<bool>,
    /// Reliability of `R`; `baseline_observed` tells whether pairs have determined `t`.
    pub state: State,
    /// Reasons to doubt the matches. They do not follow from the other fields.
    pub(crate) doubts: Reasons,
    /// Motion of the rig about the estimate from pair to pair.
    pub vibration: Vibration<T>,
}

impl<T: Scalar> Proposal<T> {
    /// Returns the reasons not to rely on the estimate. [`crate::Verdict::reasons`] adds the reasons of the last pair.
    pub fn reasons(&self) -> Reasons {
        let lens_is_off =
            self.lens.is_some_and(|lens| lens.is_significant()) || self.lens_yaw.is_significant();
        let yaw_is_open = self.lens_yaw.sd > T::lit(MAX_CONFIRMED_YAW_RAD);
        self.doubts
            .with(Reason::NotLocked, self.state != State::Locked)
            .with(Reason::Lens, lens_is_off)
            .with(Reason::Baseline, !self.baseline_observed)
            .with(Reason::Yaw, yaw_is_open)
    }

    /// Returns the mistake that the estimate shows.
    ///
    /// * `rows_px`: RMS row offset of a pair about its own optimum, px.
    /// * `alike`: whether most matches of the last pair have the same motion between the images, and no pairs show
    ///   depth.
    pub(crate) fn cause(&self, prior: &LensPrior, rows_px: T, alike: bool) -> Option<Cause> {
        if self.lens.is_some_and(|lens| lens.is_gross(prior, rows_px)) {
            Some(Cause::Lens)
        } else {
            (alike && self.shows_one_image()).then_some(Cause::SameImage)
        }
    }

    /// Returns whether pairs have not determined the baseline, and the roll between the cameras is 0 to within chance.
    /// This always holds for the same image on both sides, and rarely for a rig that looks at infinity.
    fn shows_one_image(&self) -> bool {
        let roll = (self.extrinsics.rotation().matrix().m21
            - self.extrinsics.rotation().matrix().m12)
            * T::HALF;
        let least = T::lit(SIGNIFICANT * SIGNIFICANT);
        !self.baseline_observed && roll * roll <= least * self.covariance.m33
    }

    /// Returns the least certain direction and its standard deviation with the lens uncertain, rad.
    pub fn weakest(&self) -> (Direction, T) {
        let (sd, direction) = largest_direction(&Symmetric5::packed(&self.covariance_lens));
        (Direction::of(&direction), sd)
    }
}

impl<T: Scalar> fmt::Display for Proposal<T> {
    /// Writes one line: state, extrinsics, standard deviations with the lens uncertain, pairs and the least certain
    /// direction. If there are any, lens errors, vibration and the reasons against the estimate follow.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { state, extrinsics, sd_lens: sd, pairs, .. } = self;
        let (direction, weakest) = self.weakest();
        write!(
            f,
            "{state}: {extrinsics}, {sd}, {pairs} pairs, weakest {direction} {weakest:.5} rad"
        )?;
        if let Some(lens) = self.lens.filter(LensEstimate::is_significant) {
            write!(f, ", lens: {lens}")?;
        }
        if !self.vibration.is_none() {
            write!(f, ", {}", self.vibration)?;
        }
        let reasons = self.reasons();
        if reasons.is_empty() { Ok(()) } else { write!(f, ", against it: {reasons}") }
    }
}

/// One of the five unknowns, in the rectified frame (x along the baseline, z forward).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Direction {
    /// Turn of `R` about x: shifts all rows alike.
    Pitch,
    /// Turn of `R` about y: moves rows by the product of column and row.
    Yaw,
    /// Turn of `R` about z: tilts rows.
    Roll,
    /// Turn of the baseline about y: `t_z`.
    BaselineForward,
    /// Turn of the baseline about z: `t_y`.
    BaselineDown,
}

codes! {
    Direction { Pitch = 1, Yaw = 2, Roll = 3, BaselineForward = 4, BaselineDown = 5 }
}
texts! {
    Direction {
        Pitch = "pitch", Yaw = "yaw", Roll = "roll", BaselineForward = "baseline forward",
        BaselineDown = "baseline down",
    }
}

impl Direction {
    /// Returns the unknown with the largest component in a direction.
    pub(crate) fn of<T: Scalar>(direction: &Vector5<T>) -> Self {
        let names = [Self::Pitch, Self::Yaw, Self::Roll, Self::BaselineForward, Self::BaselineDown];
        let sized = names.into_iter().zip(direction.iter().map(|x| ComplexField::abs(*x)));
        let largest = |a: (Self, T), b: (Self, T)| if b.1 > a.1 { b } else { a };
        sized.fold((Self::Pitch, T::ZERO), largest).0
    }
}

/// A covariance as rows of plain numbers.
#[cfg(feature = "serde")]
mod rows {
    use nalgebra::Matrix5;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use crate::scalar::Scalar;

    pub(super) fn serialize<T: Scalar + Serialize, S: Serializer>(
        covariance: &Matrix5<T>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        <[[T; 5]; 5]>::from(covariance.transpose()).serialize(to)
    }

    pub(super) fn deserialize<'de, T: Scalar + Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Matrix5<T>, D::Error> {
        Ok(Matrix5::from(<[[T; 5]; 5]>::deserialize(from)?).transpose())
    }
}
