//! Common practice: Sampson residuals under Cauchy's loss.
//!
//! No publication. Five degrees of freedom, Levenberg-Marquardt with reweighting, the scale of the
//! loss at the expected noise from the start, each pair alone; over pairs the chordal mean of `R`
//! and the mean direction of `t`.

use stereo_selfcal::Extrinsics;

use super::epipolar::Scaling;
use super::fusion::{Chordal, running};
use super::method::{Method, Setting, usable};
use super::minimise::{Loss, minimise};
use super::pose::Pose;
use crate::data::Rays;

/// Scale of the loss in deviations of the noise: 95 % efficient where the noise is normal.
pub(super) const CAUCHY_SD: f64 = 2.385;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct Cauchy;

impl Method for Cauchy {
    fn name(&self) -> &'static str {
        "cauchy"
    }

    fn source(&self) -> &'static str {
        "common practice: 5-dof Levenberg-Marquardt on Sampson residuals, Cauchy loss of 2.385 noise \
         deviations, pair by pair; chordal mean of R, mean direction of t"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        let start = Pose::of(&setting.start);
        let loss = Loss::Cauchy(CAUCHY_SD * setting.noise());
        let single = |rays: &Vec<Rays>| minimise(&start, &usable(rays), Scaling::Sampson, loss);
        running::<Chordal>(pairs.iter().map(single))
    }
}
