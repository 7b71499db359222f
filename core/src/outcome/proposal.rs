//! What the pairs come to, and how far it can be relied on.

use nalgebra::{ComplexField, Matrix5, Vector5};

use crate::algebra::information::{StandardDeviations, largest_direction};
use crate::algebra::symmetric5::Symmetric5;
use crate::geometry::extrinsics::Extrinsics;
use crate::scalar::Scalar;
use crate::state::State;

/// The estimate over all pairs so far.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Proposal<T: Scalar> {
    /// The best `R`, `t`.
    pub extrinsics: Extrinsics<T>,
    /// What [`crate::Calibrator::apply`] puts into use: the same, but where `doubt` is
    /// [`Doubt::Baseline`] `t` is that in use, and `R` the best there is with it.
    pub applicable: Extrinsics<T>,
    /// Pairs behind it; those of a repeated scene count once.
    pub pairs: u32,
    /// Expected size of the error. Robust: from the information, widened by what pairs scatter beyond
    /// it and image halves disagree. Paper: from the scatter of the pairs, and what the axis
    /// and the angle disagree by; that of the pair itself while there is one only.
    pub sd: StandardDeviations<T>,
    /// Covariance of the five unknowns, rad^2, in the order of [`crate::Information`] and as far as
    /// [`crate::RectifyingRotations::unknowns_to`] measures them; `None` in the paper preset.
    pub covariance: Option<Matrix5<T>>,
    /// Whether it is confirmed. The paper preset confirms nothing: locked from the first pair on.
    pub state: State,
    /// What speaks against it.
    pub doubt: Option<Doubt>,
}

impl<T: Scalar> Proposal<T> {
    /// The least certain direction and its standard deviation, rad; `None` in the paper preset.
    pub fn weakest(&self) -> Option<(Direction, T)> {
        let (sd, direction) = largest_direction(&Symmetric5::packed(&self.covariance?));
        Some((Direction::of(&direction), sd))
    }
}

/// What speaks against an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Doubt {
    /// Image halves disagree by more than 3 of their standard deviations: matches are biased alike
    /// somewhere. The baseline suffers first and is not applied.
    Baseline,
    /// They disagree by more than 5: nothing is applied.
    Everything,
    /// Paper preset: the rotation is so near the identity, or a half turn, that its axis is noise.
    Axis,
}

// 0 is free for none.
codes! { Doubt { Baseline = 1, Everything = 2, Axis = 3 } }

/// One of the five unknowns, in the rectified frame (x along the baseline, z forward).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

impl Direction {
    /// The unknown that has most of a direction.
    pub(crate) fn of<T: Scalar>(direction: &Vector5<T>) -> Self {
        let names = [Self::Pitch, Self::Yaw, Self::Roll, Self::BaselineForward, Self::BaselineDown];
        let sized = names.into_iter().zip(direction.iter().map(|x| ComplexField::abs(*x)));
        let largest = |a: (Self, T), b: (Self, T)| if b.1 > a.1 { b } else { a };
        sized.fold((Self::Pitch, T::ZERO), largest).0
    }
}
