//! Mueller and Wuensche, "Continuous extrinsic online calibration for stereo cameras", IV 2016.
//!
//! An unscented Kalman filter over the extrinsics, measured by the epipolar residual of each match. Sigma points are
//! turned about the state on the manifold. All matches of a pair enter one update in information form, each through its
//! statistical linearisation, which is exact for independent noise.
//!
//! Filled in:
//! - The spread of the sigma points (alpha 1, kappa 0).
//! - Residuals are divided by their deviation (Sampson).
//! - The update by a pair is repeated about its own posterior. Without this, a start some degrees off is linearised too
//!   far from the rig.
//! - Rejection, prior and process noise (`filter`).
//!
//! Left out: the motion of the vehicle, and 3-D points. The source also measures the extrinsics by points that it
//! triangulates and tracks over time. Here there are no tracks, and the epipolar residual of a point that is seen in
//! one pair contains all its information on the extrinsics.

use nalgebra::{Matrix5, Vector5};
use stereo_selfcal::Extrinsics;

use super::epipolar::Scaling;
use super::filter::{self, Belief, limit};
use super::method::{Method, Setting};
use rigs::data::Rays;

/// Number of unknowns.
const N: usize = 5;

/// Squared spread of the sigma points, in variances: the number of unknowns, at kappa 0.
const SPREAD_SQUARED: f64 = 5.0;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct MuellerUkf;

impl Method for MuellerUkf {
    fn name(&self) -> &'static str {
        "mueller-ukf"
    }

    fn source(&self) -> &'static str {
        "Mueller and Wuensche, IV 2016: unscented Kalman filter over the extrinsics from epipolar \
         residuals, in information form. Filled in: Sampson weighting, update repeated about its \
         posterior, rejection by the median, prior 0.1 rad, process noise. Left out: tracked 3-D points"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        filter::iterated(pairs, setting, |prior, about, rays| {
            updated(prior, about, rays, setting.noise())
        })
    }
}

/// A residual linearised over the sigma points: `e = mean + slope . d`, and the variance about this line.
struct Linearised {
    mean: f64,
    slope: Vector5<f64>,
    variance: f64,
}

/// `prior` updated by a pair that is linearised over the sigma points of `about`. `None` if a covariance is not
/// positive definite.
fn updated(prior: &Belief, about: &Belief, rays: &[Rays], noise: f64) -> Option<Belief> {
    let cholesky = about.covariance.cholesky()?;
    let (root, inverse) = (cholesky.l(), cholesky.inverse());
    let spread = SPREAD_SQUARED.sqrt();
    let steps: [Vector5<f64>; 2 * N] = std::array::from_fn(|i| {
        let side = if i < N { spread } else { -spread };
        root.column(i % N) * side
    });
    let essentials = steps.map(|step| about.pose.moved(&step).essential());
    let linearise = |rays: &Rays| {
        let seen = essentials.each_ref().map(|e| Scaling::Sampson.residual(e, rays));
        // All sigma points have equal weight, except the one in the middle, which has weight 0 at kappa 0.
        let weight = 0.5 / SPREAD_SQUARED;
        let mean = weight * seen.iter().sum::<f64>();
        let off = || seen.iter().map(|e| e - mean);
        let cross: Vector5<f64> = steps.iter().zip(off()).map(|(d, e)| d * (e * weight)).sum();
        let slope = inverse * cross;
        let variance = weight * off().map(|e| e * e).sum::<f64>();
        Linearised { mean, slope, variance: (variance - slope.dot(&cross)).max(0.0) }
    };
    let all: Vec<Linearised> = rays.iter().map(linearise).collect();
    let limit = limit(all.iter().map(|e| e.mean.abs()), noise);
    let (mut information, mut gradient) = (Matrix5::zeros(), Vector5::zeros());
    for e in all.iter().filter(|e| e.mean.abs() <= limit) {
        let weighted = e.slope / (e.variance + noise * noise);
        information += weighted * e.slope.transpose();
        gradient += weighted * e.mean;
    }
    prior.corrected(&about.pose, information, gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::pose::Pose;
    use crate::rivals::tests::{NOISE, assert_covariance_is_the_bound, clean_pair};

    #[test]
    fn over_narrow_sigma_points_a_pair_reaches_its_cramer_rao_bound() {
        let (rig, rays) = clean_pair();
        let pose = Pose::of(&rig);
        let prior = Belief { pose, covariance: Matrix5::identity() };
        let about = Belief { pose, covariance: Matrix5::identity() * 1e-8 };
        let updated = updated(&prior, &about, &rays, NOISE).unwrap();
        assert_covariance_is_the_bound(&updated.covariance, &rig, &rays);
    }
}
