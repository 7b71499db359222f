//! Hansen, Alismail, Rander and Browning, "Online continuous stereo extrinsic parameter estimation",
//! CVPR 2012.
//!
//! Literal: the estimate of a pair minimises the sum, over its matches, of the squared distances of both points to
//! their epipolar lines. A Kalman filter of a constant rig fuses these estimates; the covariance of each is its
//! Cramer-Rao bound.
//!
//! Filled in:
//! - Outliers: Huber's loss with a threshold of 1 px, on the root of the sum of both squared distances of a match. With
//!   [`Tuning::rejecting`](super::Tuning), matches beyond 2.5 robust deviations are removed, as published, and the sum
//!   of squares is minimised over the others.
//! - Prior and process noise of the filter (`filter`), and the choice of the matches that the bound counts (`gate`).
//! - Each pair is solved from the extrinsics at which the run starts, not from the last estimate.

use nalgebra::Vector5;
use stereo_selfcal::Extrinsics;

use super::epipolar::Scaling;
use super::filter::{self, limit};
use super::gate;
use super::method::{Method, Setting};
use super::minimise::{Loss, minimise};
use super::pose::Pose;
use rigs::data::Rays;

/// Huber threshold, px.
const HUBER_PX: f64 = 1.0;

/// Rounds of rejection and fit.
const ROUNDS: usize = 5;

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
         at 1 px, or rejection at 2.5 robust deviations and least squares; prior 0.1 rad; process noise"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        filter::running(pairs, setting, |belief, rays| {
            let pair = gate::passed(single(rays, setting), rays, setting)?;
            let information = gate::information(&pair, rays, setting.noise());
            // The measurement is the estimate of the pair. It is linear, and its residual is zero at this estimate.
            belief.corrected(&pair, information, Vector5::zeros())
        })
    }
}

/// Solves one pair. `None` if a fit fails.
fn single(rays: &[Rays], setting: &Setting) -> Option<Pose> {
    let huber = Loss::Huber(HUBER_PX / setting.focal);
    let mut pose = minimise(&Pose::of(&setting.start), rays, Scaling::Distances, huber)?;
    if !setting.tuning.rejecting {
        return Some(pose);
    }
    for _ in 0..ROUNDS {
        let essential = pose.essential();
        let size = |rays: &Rays| Scaling::Distances.residual(&essential, rays).abs();
        // If `a` and `b` of `epipolar` are equal, the deviation of this residual is twice the deviation of a
        // coordinate.
        let limit = limit(rays.iter().map(size), 2.0 * setting.noise());
        let kept: Vec<Rays> = rays.iter().filter(|rays| size(rays) <= limit).copied().collect();
        pose = minimise(&pose, &kept, Scaling::Distances, Loss::Huber(f64::INFINITY))?;
    }
    Some(pose)
}
