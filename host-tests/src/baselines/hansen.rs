//! Hansen, Alismail, Rander and Browning, "Online continuous stereo extrinsic parameter estimation",
//! CVPR 2012.
//!
//! Per pair, the five parameters of least epipolar error (eq 2 of Zhao et al.): the distances of both
//! points to their epipolar lines, squared and summed. Over pairs a Kalman filter of a constant rig
//! with little process noise, each pair measured with the covariance of its Cramer-Rao bound.
//!
//! Filled in: Huber weights at 1 px, for the published rejection of outliers; prior, process noise
//! and the matches that the bound counts (`filter`); each pair is solved from the start.

use nalgebra::{Matrix5, Vector5};
use stereo_selfcal::Extrinsics;

use super::epipolar::Scaling;
use super::filter::{self, limit};
use super::method::{Method, Setting};
use super::minimise::{Loss, minimise};
use super::pose::Pose;
use crate::data::Rays;

/// Huber threshold, px.
const HUBER_PX: f64 = 1.0;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct Hansen;

impl Method for Hansen {
    fn name(&self) -> &'static str {
        "hansen"
    }

    fn source(&self) -> &'static str {
        "Hansen, Alismail, Rander and Browning, CVPR 2012: least squared distances to epipolar lines \
         pair by pair, Kalman filter over pairs with Cramer-Rao covariances. Filled in: Huber weights \
         at 1 px, prior 0.1 rad, process noise 1e-5 rad a pair"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        let start = Pose::of(&setting.start);
        let loss = Loss::Huber(HUBER_PX / setting.focal);
        filter::running(pairs, setting, |belief, rays| {
            let pair = minimise(&start, rays, Scaling::Distances, loss)?;
            let information = information(&pair, rays, setting.noise());
            // The pair's estimate is the measurement: it is linear, and zero off itself.
            belief.corrected(&pair, information, Vector5::zeros())
        })
    }
}

/// Inverse of the Cramer-Rao bound of a pair, from the matches that fit it.
///
/// * `noise`: of a coordinate, unit depth; more where the matches scatter more.
fn information(pose: &Pose, rays: &[Rays], noise: f64) -> Matrix5<f64> {
    let essential = pose.essential();
    let rows: Vec<_> =
        rays.iter().map(|rays| Scaling::Sampson.linearised(&essential, rays)).collect();
    let mut sizes: Vec<f64> = rows.iter().map(|(e, _)| e.abs()).collect();
    let limit = limit(&mut sizes, noise);
    let fit = || rows.iter().filter(|(e, _)| e.abs() <= limit);
    let squares: f64 = fit().map(|(e, _)| e * e).sum();
    let count: f64 = fit().map(|_| 1.0).sum();
    let variance = (squares / count).max(noise * noise);
    fit().map(|(_, j)| j * j.transpose()).sum::<Matrix5<f64>>() / variance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baselines::tests::{NOISE, assert_covariance_is_the_bound, clean_pair};

    #[test]
    fn a_pair_without_noise_is_measured_with_its_cramer_rao_bound() {
        let (rig, rays) = clean_pair();
        let covariance = information(&Pose::of(&rig), &rays, NOISE).try_inverse().unwrap();
        assert_covariance_is_the_bound(&covariance, &rig, &rays);
    }
}
