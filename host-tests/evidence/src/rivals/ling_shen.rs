//! Ling and Shen, "High-precision online markerless stereo extrinsic calibration", IROS 2016.
//!
//! Minimises the epipolar constraint `p_r^T [t]x R p_l` (eq 3 of Zhao et al., erratum 9) over five degrees of
//! freedom on the manifold, `R` perturbed on the left and `t` on the unit sphere, by
//! Levenberg-Marquardt with Huber weights. Zhao et al. compare with it, and it runs here as theirs does:
//! each pair alone from the start, mean directions over pairs (their eqs 20-22).
//!
//! Filled in: the Huber threshold, 1 px at unit depth as in Zhao et al. Left out: the published stop on the covariance,
//! because the number of pairs is given here; matching, and its rejection of outliers.

use stereo_selfcal::Extrinsics;

use super::epipolar::Scaling;
use super::fusion::{MeanDirection, running};
use super::gate;
use super::method::{Method, Setting, usable};
use super::minimise::{Loss, minimise};
use super::pose::Pose;
use rigs::data::Rays;

/// Huber threshold, px.
const HUBER_PX: f64 = 1.0;

/// Huber threshold in deviations of a coordinate, if the noise is estimated: 1.345 deviations of the residual, which
/// has the noise of two coordinates.
const HUBER_SD: f64 = 1.345 * std::f64::consts::SQRT_2;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct LingShen;

impl Method for LingShen {
    fn name(&self) -> &'static str {
        "ling-shen"
    }

    fn source(&self) -> &'static str {
        "Ling and Shen, IROS 2016: 5-dof Levenberg-Marquardt on p_r^T [t]x R p_l with Huber weights, \
         as in eq 3 of Zhao et al.; pair by pair, fused by their eqs 20-22. Filled in: Huber \
         threshold 1 px. Left out: convergence test on the covariance"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        let start = Pose::of(&setting.start);
        let loss = Loss::Huber(if setting.tuning.noise_estimated {
            HUBER_SD * setting.noise()
        } else {
            HUBER_PX / setting.focal
        });
        let single = |rays: &Vec<Rays>| {
            let rays = usable(rays);
            let found = minimise(&start, &rays, Scaling::Algebraic, loss);
            gate::passed(found, &rays, setting)
        };
        running::<MeanDirection>(pairs.iter().map(single))
    }
}
