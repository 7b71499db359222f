//! The common part of the Kalman filters: a belief (the expected rig with its covariance), the model of a constant rig
//! with process noise ([`Tuning::agile`](super::Tuning::agile)), and the rejection of outliers.
//!
//! The publications do not describe their rejection of outliers fully. All filters use the same one, so that only the
//! filters make their figures differ.

use nalgebra::{Matrix5, Vector5};
use stereo_selfcal::Extrinsics;

use super::method::{Setting, usable};
use super::pose::Pose;
use rigs::data::Rays;
use sim::stats::median;

/// Standard deviation of the start about each axis, rad, as in the core.
pub(super) const PRIOR_SD: f64 = 0.1;

/// Number of linearisations of a pair by [`iterated`], each at the result of the previous one.
pub(super) const ITERATIONS: usize = 10;

/// A pose, and the covariance of the five unknowns about it, rad^2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Belief {
    /// Expected pose.
    pub(super) pose: Pose,
    /// Covariance of the step from it to the true pose.
    pub(super) covariance: Matrix5<f64>,
}

impl Belief {
    /// The belief before the first pair.
    fn at(start: &Extrinsics<f64>) -> Self {
        let covariance = Matrix5::identity() * (PRIOR_SD * PRIOR_SD);
        Self { pose: Pose::of(start), covariance }
    }

    /// The belief before the next pair: its covariance grows by the process noise.
    fn predicted(mut self, process_sd: f64) -> Self {
        self.covariance += Matrix5::identity() * (process_sd * process_sd);
        self
    }

    /// The belief corrected by the sums `sum J J^T / s^2` and `sum J e / s^2`, linearised at `at`: one step of an
    /// iterated filter. `None` if a covariance is not positive definite.
    pub(super) fn corrected(
        &self,
        at: &Pose,
        information: Matrix5<f64>,
        gradient: Vector5<f64>,
    ) -> Option<Self> {
        let prior = self.covariance.cholesky()?.inverse();
        let posterior = (prior + information).cholesky()?;
        let step = posterior.solve(&(prior * at.step_to(&self.pose) - gradient));
        Some(Self { pose: at.moved(&step), covariance: posterior.inverse() })
    }
}

/// The estimate after each pair of a filter that `update`s its belief. A pair without an update keeps the estimate, and
/// only adds the process noise to the covariance.
pub(super) fn running(
    pairs: &[Vec<Rays>],
    setting: &Setting,
    update: impl Fn(&Belief, &[Rays]) -> Option<Belief>,
) -> Vec<Option<Extrinsics<f64>>> {
    let mut belief = Belief::at(&setting.start);
    let mut estimate = None;
    let after = pairs.iter().map(|rays| {
        let predicted = belief.predicted(setting.tuning.process_sd());
        let updated = update(&predicted, &usable(rays));
        let found = updated.and_then(|updated| Some((updated, updated.pose.extrinsics()?)));
        belief = found.map_or(predicted, |(updated, _)| updated);
        estimate = found.map_or(estimate, |(_, extrinsics)| Some(extrinsics));
        estimate
    });
    after.collect()
}

/// As [`running`], for an iterated filter. `update` gets the belief before the pair, and the result of the previous
/// iteration, about which it linearises the pair.
pub(super) fn iterated(
    pairs: &[Vec<Rays>],
    setting: &Setting,
    update: impl Fn(&Belief, &Belief, &[Rays]) -> Option<Belief>,
) -> Vec<Option<Extrinsics<f64>>> {
    running(pairs, setting, |prior, rays| {
        if rays.is_empty() {
            return None;
        }
        (0..ITERATIONS).try_fold(*prior, |about, _| update(prior, &about, rays))
    })
}

/// Residuals beyond so many robust deviations are outliers (Rousseeuw and Leroy).
const REJECTED: f64 = 2.5;

/// Largest residual of an inlier: 2.5 robust deviations of all residuals, by their median; 0 without residuals.
///
/// * `sizes`: absolute residuals.
/// * `noise`: the least robust deviation.
pub(super) fn limit(sizes: impl IntoIterator<Item = f64>, noise: f64) -> f64 {
    median(sizes).map_or(0.0, |median| REJECTED * (1.4826 * median).max(noise))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_outliers_is_beyond_the_limit_and_the_noise_is_not() {
        let limit = limit([0.1, 5.0, 0.2, 0.3, 7.0, 0.1, 0.2, 9.0, 0.3], 0.05);
        assert!(limit > 0.3 && limit < 5.0, "{limit}");
    }

    #[test]
    fn a_correction_between_prior_and_measurement_is_weighted_by_their_information() {
        let prior = Belief::at(&Extrinsics::SIDE_BY_SIDE);
        // A direct measurement of all unknowns, as certain as the prior, 0.02 rad away.
        let information = Matrix5::identity() / (PRIOR_SD * PRIOR_SD);
        let gradient = -information * Vector5::repeat(0.02);
        let found = prior.corrected(&prior.pose, information, gradient).unwrap();
        let step = prior.pose.step_to(&found.pose);
        assert!((step - Vector5::repeat(0.01)).norm() < 1e-5, "{step}");
        assert!((found.covariance * 2.0 - prior.covariance).norm() < 1e-12);
    }
}
