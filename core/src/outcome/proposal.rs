//! The estimate over all pairs, and its reliability.

use core::fmt;

use nalgebra::{ComplexField, Matrix5, Vector5};

use crate::algebra::information::{StandardDeviations, largest_direction};
use crate::algebra::symmetric5::Symmetric5;
use crate::config::LensPrior;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::LensCorrection;
use crate::outcome::cause::Cause;
use crate::outcome::lens_estimate::{Finding, LensEstimate};
use crate::outcome::vibration::Vibration;
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::LENS_FOUND;

/// The estimate over all pairs so far.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Proposal<T: Scalar> {
    /// The best `R`, `t`.
    pub extrinsics: Extrinsics<T>,
    /// Correction of the cameras that they belong to; none but with [`crate::LensTracking::Compensate`].
    pub correction: LensCorrection<T>,
    /// What [`crate::Calibrator::apply`] puts into use. `t` is that in use, and `R` the best there is with it, where
    /// the baseline is not observed, where it is observed and not significantly different, and where `doubt` is
    /// [`Doubt::Baseline`]. Otherwise the best `R`, `t`.
    pub applicable: Extrinsics<T>,
    /// Correction of the cameras that `applicable` belongs to.
    pub applicable_correction: LensCorrection<T>,
    /// Pairs behind it; those of a repeated scene count once.
    pub pairs: u32,
    /// Standard deviations of the error. Robust: from the information, widened by the scatter of the pairs
    /// beyond it and by the disagreement of image halves. Paper: from the scatter of the pairs and the
    /// disagreement of axis and angle; those of the pair itself while there is only one.
    pub sd: StandardDeviations<T>,
    /// Covariance of the five unknowns, rad^2, in the order of [`crate::outcome::Information`] and as far as
    /// [`crate::geometry::RectifyingRotations::unknowns_to`] measures them; `None` in the paper preset.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "rows"))]
    pub covariance: Option<Matrix5<T>>,
    /// The same with the lens models uncertain ([`crate::Config::with_lens_prior`]): expected error of the extrinsics
    /// where the lens may be off. Equal to `sd` without a lens prior and in the paper preset.
    pub sd_lens: StandardDeviations<T>,
    /// Covariance with the lens models uncertain, as `covariance`.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "rows"))]
    pub covariance_lens: Option<Matrix5<T>>,
    /// Errors of the lens models that the pairs show; `None` without a lens prior and in the paper preset.
    pub lens: Option<LensEstimate<T>>,
    /// Apparent yaw `a` of the lenses, rad: with `extrinsics` the right row is below the left one by `a x y`, at unit
    /// depth. Rows alone cannot tell it from yaw; depth needs `extrinsics` without it.
    pub lens_yaw: Finding<T>,
    /// Whether pairs have determined the baseline direction: its variance is at most an eighth of what it is without
    /// pairs. Points more than some thousand baselines away do not observe it: their disparities are noise. The paper
    /// preset fuses no pair that does not: always true.
    pub baseline_observed: bool,
    /// Whether the pairs fit it clearly better than what is in use: their RMS row offset is smaller by a tenth, and the two
    /// differ by more than chance. `None` where the sums over the pairs do not tell: in the paper preset, and with other
    /// cameras in use ([`crate::LensTracking::Compensate`]).
    pub improves: Option<bool>,
    /// Whether `R` is confirmed; `t` is, where `baseline_observed` says so. The paper preset confirms nothing: locked
    /// from the first pair on.
    pub state: State,
    /// Evidence against it.
    pub doubt: Option<Doubt>,
    /// Motion of the rig about the estimate from pair to pair; none in the paper preset.
    pub vibration: Vibration<T>,
}

impl<T: Scalar> Proposal<T> {
    /// Whether too much speaks against it to apply any of it. With a lens prior a disagreement of image halves widens
    /// the deviations, and does not block.
    pub(crate) fn is_doubtful(&self) -> bool {
        match self.doubt {
            Some(Doubt::SecondMode) => true,
            Some(Doubt::Everything) => self.lens.is_none(),
            _ => false,
        }
    }

    /// Mistake that the estimate shows.
    ///
    /// * `rows_px`: RMS row offset of a pair about its own optimum.
    /// * `alike`: whether most matches of the pair at hand are moved alike between both images.
    pub(crate) fn cause(&self, prior: &LensPrior, rows_px: T, alike: bool) -> Option<Cause> {
        if self.lens.is_some_and(|lens| lens.is_gross(prior, rows_px)) {
            Some(Cause::Lens)
        } else {
            (alike && self.shows_one_image()).then_some(Cause::SameImage)
        }
    }

    /// Whether no pair has shown depth, and the cameras are turned about their axes by no more than chance: a rig that
    /// looks at infinity may be so by chance, both sides with the same image always are.
    fn shows_one_image(&self) -> bool {
        let roll = (self.extrinsics.rotation().matrix().m21
            - self.extrinsics.rotation().matrix().m12)
            * T::HALF;
        let least = T::lit(LENS_FOUND * LENS_FOUND);
        let by_chance = |c: Matrix5<T>| roll * roll <= least * c.m33;
        !self.baseline_observed && self.covariance.is_some_and(by_chance)
    }

    /// The least certain direction and its standard deviation with the lens uncertain, rad; `None` in the paper preset.
    pub fn weakest(&self) -> Option<(Direction, T)> {
        let (sd, direction) = largest_direction(&Symmetric5::packed(&self.covariance_lens?));
        Some((Direction::of(&direction), sd))
    }
}

impl<T: Scalar> fmt::Display for Proposal<T> {
    /// One line: state, extrinsics, standard deviations, pairs, doubt.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { state, extrinsics, sd, pairs, doubt, .. } = self;
        write!(f, "{state}: {extrinsics}, {sd}, {pairs} pairs")?;
        doubt.map_or(Ok(()), |doubt| write!(f, ", doubt: {doubt}"))
    }
}

/// Evidence against an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Doubt {
    /// Image halves disagree by more than 3 of their standard deviations: matches are biased alike somewhere, or the
    /// lens is wrong. The deviations are widened by it. Without a lens prior the baseline is not applied.
    Baseline,
    /// They disagree by more than 5. Without a lens prior nothing is applied.
    Everything,
    /// Paper preset: the rotation is so near the identity, or a half turn, that its axis is noise.
    Axis,
    /// Nearly as many matches agree on another calibration, rows away: a fence, or a reflection. Nothing is applied
    /// until the view has changed.
    SecondMode,
}

// 0 is free for none.
codes! { Doubt { Baseline = 1, Everything = 2, Axis = 3, SecondMode = 4 } }
texts! {
    Doubt {
        Baseline = "baseline: image halves disagree", Everything = "all: image halves disagree",
        Axis = "axis of the rotation is noise", SecondMode = "all: a second crowd of matches",
    }
}

/// One of the five unknowns, in the rectified frame (x along the baseline, z forward).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Direction {
    /// Turn of `R` about x: shifts all rows alike.
    Pitch,
    /// Turn of `R` about y: shears rows with the product of column and row.
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
    /// The unknown that has most of a direction.
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

    #[expect(clippy::ref_option, reason = "serde asks for this signature")]
    pub(super) fn serialize<T: Scalar + Serialize, S: Serializer>(
        covariance: &Option<Matrix5<T>>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        covariance.map(|matrix| <[[T; 5]; 5]>::from(matrix.transpose())).serialize(to)
    }

    pub(super) fn deserialize<'de, T: Scalar + Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<Matrix5<T>>, D::Error> {
        let rows = Option::<[[T; 5]; 5]>::deserialize(from)?;
        Ok(rows.map(|rows| Matrix5::from(rows).transpose()))
    }
}
