//! Fusion by information: every pair counts by what it knows about each direction.
//!
//! A running estimate and its 5 x 5 information, begun at the factory extrinsics and their prior. A
//! pair adds its information and moves the estimate to the joint optimum of both, by a few
//! Gauss-Newton steps on the manifold: `(H + H_k) d = H d_0 + H_k d_k + s_k`, where `d_0` and `d_k` are
//! the old estimate and the pair's pose as seen from the new one, and `s_k` is the pair's score, which
//! takes the prior back out of the pair. What the scatter of the pairs says beyond their own claims
//! widens the reported deviation.

use nalgebra::{Rotation3, Vector2, Vector3, Vector5};

use super::FusedEstimate;
use crate::extrinsics::Extrinsics;
use crate::information::{Information, StandardDeviations};
use crate::rectification::RectifyingRotations;
use crate::report::PairReport;
use crate::scalar::Scalar;
use crate::so3;

/// Enough for a pair 10 degrees away: each step squares the error of the linearisation.
const GAUSS_NEWTON_STEPS: usize = 3;

/// Sums over the pairs fused so far. RAM: about 130 bytes in `f32`.
#[derive(Debug, Clone)]
pub struct InformationMean<T: Scalar> {
    extrinsics: Extrinsics<T>,
    information: Information<T>,
    pairs: u32,
    /// Running mean of the normalised innovation squared, per degree of freedom, and its count.
    dispersion: T,
    innovations: u32,
}

impl<T: Scalar> InformationMean<T> {
    /// No pairs yet, no prior.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            extrinsics: Extrinsics::SIDE_BY_SIDE,
            information: Information::ZERO,
            pairs: 0,
            dispersion: T::ZERO,
            innovations: 0,
        }
    }

    /// Begins at `extrinsics`, known to `sd` rad about every axis.
    #[must_use]
    pub fn from_prior(extrinsics: Extrinsics<T>, sd: T) -> Self {
        let information = Information::ZERO.plus_diagonal(T::ONE / (sd * sd));
        Self { extrinsics, information, ..Self::new() }
    }

    /// Adds one pair; whether it was taken. One that would lead to a rig that cannot be rectified is
    /// not, and leaves the sums as they were.
    pub fn add(&mut self, report: &PairReport<T>) -> bool {
        let mut joint = self.information;
        joint.add(&report.information);
        let optimum = (0..GAUSS_NEWTON_STEPS)
            .try_fold(self.extrinsics, |at, _| self.joint_step(&at, &joint, report));
        let Some(extrinsics) = optimum else {
            return false;
        };
        if self.pairs > 0 {
            self.note_innovation(report);
        }
        self.extrinsics = extrinsics;
        self.information = joint;
        self.pairs = self.pairs.saturating_add(1);
        true
    }

    /// One step from `at` towards the joint optimum of the estimate and a pair.
    fn joint_step(
        &self,
        at: &Extrinsics<T>,
        joint: &Information<T>,
        report: &PairReport<T>,
    ) -> Option<Extrinsics<T>> {
        let rotations = RectifyingRotations::from(at);
        let estimate = seen_from(at, &rotations, &self.extrinsics);
        let pair = seen_from(at, &rotations, &report.extrinsics);
        let pull = self.information.times(&estimate)
            + report.information.times(&pair)
            + Vector5::from(report.score);
        let d = joint.damped_step(T::ZERO, &(-pull).into())?;
        let turn = Vector3::new(d.x, d.y, d.z);
        rotations.stepped(&turn, &Vector2::new(d.w, d.a))?.extrinsics().ok()
    }

    /// Pairs added.
    pub fn pairs(&self) -> u32 {
        self.pairs
    }

    /// The running estimate. `None` before the first pair, or while a direction is free.
    pub fn estimate(&self) -> Option<FusedEstimate<T>> {
        if self.pairs == 0 {
            return None;
        }
        let claimed = self.information.standard_deviations()?;
        let widened = self.dispersion.max(T::ONE).sqrt();
        Some(FusedEstimate {
            extrinsics: self.extrinsics,
            pairs: self.pairs,
            sd: StandardDeviations {
                rotation: claimed.rotation * widened,
                translation: claimed.translation * widened,
            },
            axis_concentration: T::ONE,
            axis_is_meaningful: true,
        })
    }

    /// `y^T (H^-1 + H_k^-1)^-1 y / 5`, `y` the pair's own optimum as seen from the estimate.
    fn note_innovation(&mut self, report: &PairReport<T>) {
        let both = self.information.covariance().zip(report.information.covariance());
        let Some((estimate, pair)) = both else {
            return;
        };
        let rotations = RectifyingRotations::from(&self.extrinsics);
        let seen = seen_from(&self.extrinsics, &rotations, &report.extrinsics);
        let innovation = seen + pair * Vector5::from(report.score);
        let Some(weight) = nalgebra::Cholesky::new(estimate + pair) else {
            return;
        };
        let squared = innovation.dot(&weight.solve(&innovation)) / T::lit(5.0);
        if squared.is_finite() {
            self.innovations = self.innovations.saturating_add(1);
            self.dispersion += (squared - self.dispersion) / T::count(self.innovations);
        }
    }
}

/// The five unknowns that lead from `at` to `pose`, to first order.
fn seen_from<T: Scalar>(
    at: &Extrinsics<T>,
    rotations: &RectifyingRotations<T>,
    pose: &Extrinsics<T>,
) -> Vector5<T> {
    let right = rotations.right();
    let turn: Rotation3<T> = pose.rotation() * at.rotation().inverse();
    let w = right * so3::log(&turn);
    let t = right * pose.translation().into_inner();
    // A baseline across the other is as far as it goes.
    let along = (-t.x).max(T::lit(0.1));
    Vector5::new(w.x, w.y, w.z, -t.z / along, t.y / along)
}

impl<T: Scalar> Default for InformationMean<T> {
    fn default() -> Self {
        Self::new()
    }
}
