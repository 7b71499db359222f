//! Common practice: Sampson residuals under Cauchy's loss.
//!
//! There is no publication. Levenberg-Marquardt with reweighting solves each pair alone, over five degrees of freedom.
//! The scale of the loss follows the expected noise, or is annealed down to it from 64 times this scale. The estimates
//! of the pairs are fused by the chordal mean of `R` and the mean direction of `t`.

use stereo_selfcal::Extrinsics;

use super::epipolar::Scaling;
use super::fusion::{Chordal, running};
use super::gate;
use super::method::{Method, Setting, usable};
use super::minimise::{Loss, minimise};
use super::pose::Pose;
use rigs::data::Rays;

/// Scale of the loss in deviations of the noise: 95 % efficient for normal noise.
pub(super) const CAUCHY_SD: f64 = 2.385;

/// Number of halvings of the scale of an annealed loss: it starts at 64 times the final scale.
pub(super) const HALVINGS: i32 = 6;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct Cauchy;

impl Method for Cauchy {
    fn name(&self) -> &'static str {
        "cauchy"
    }

    fn source(&self) -> &'static str {
        "common practice: 5-dof Levenberg-Marquardt on Sampson residuals, Cauchy loss of 2.385 noise \
         deviations, pair by pair; chordal mean of R, mean direction of t. Annealed: entered from 64 \
         times that scale, halved six times"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        let start = Pose::of(&setting.start);
        let halvings = if setting.tuning.annealed { HALVINGS } else { 0 };
        let single = |rays: &Vec<Rays>| {
            let rays = usable(rays);
            let found = (0..=halvings).rev().try_fold(start, |pose, halving| {
                let scale = CAUCHY_SD * setting.noise() * 2.0_f64.powi(halving);
                minimise(&pose, &rays, Scaling::Sampson, Loss::Cauchy(scale))
            });
            gate::passed(found, &rays, setting)
        };
        running::<Chordal>(pairs.iter().map(single))
    }
}
