//! Levenberg-Marquardt over the five unknowns with a robust loss, by reweighting.

use nalgebra::{Matrix5, Vector5};

use super::epipolar::Scaling;
use super::pose::Pose;
use rigs::data::Rays;

/// Loss of a residual.
#[derive(Debug, Clone, Copy)]
pub(super) enum Loss {
    /// Quadratic up to this threshold of the residual, linear beyond.
    Huber(f64),
    /// `c^2 / 2 log(1 + (e / c)^2)`, with the scale `c`.
    Cauchy(f64),
    /// `c^2 (1 - exp(-e^2 / 2 c^2))`, with the scale `c`.
    Welsch(f64),
}

impl Loss {
    fn of(self, e: f64) -> f64 {
        match self {
            Self::Huber(c) if e.abs() <= c => e * e / 2.0,
            Self::Huber(c) => c * (e.abs() - c / 2.0),
            Self::Cauchy(c) => c * c / 2.0 * (e / c).powi(2).ln_1p(),
            Self::Welsch(c) => -c * c * (-(e / c).powi(2) / 2.0).exp_m1(),
        }
    }

    /// Derivative of the loss, divided by the residual.
    pub(super) fn weight(self, e: f64) -> f64 {
        match self {
            Self::Huber(c) if e.abs() <= c => 1.0,
            Self::Huber(c) => c / e.abs(),
            Self::Cauchy(c) => 1.0 / (1.0 + (e / c).powi(2)),
            Self::Welsch(c) => (-(e / c).powi(2) / 2.0).exp(),
        }
    }
}

/// Fewest correspondences: the number of unknowns.
pub(super) const FEWEST: usize = 5;

/// Largest number of steps; well-posed pairs take about ten.
const STEPS: usize = 60;

/// Step below which it has converged, rad.
const TOLERANCE: f64 = 1e-9;

/// The minimum of the robust energy near `start`.
///
/// `None` for fewer than [`FEWEST`] rays, or if there is no finite solution.
pub(super) fn minimise(start: &Pose, rays: &[Rays], scaling: Scaling, loss: Loss) -> Option<Pose> {
    if rays.len() < FEWEST {
        return None;
    }
    let energy_of = |pose: &Pose| -> f64 {
        let essential = pose.essential();
        rays.iter().map(|rays| loss.of(scaling.residual(&essential, rays))).sum()
    };
    let mut pose = *start;
    let mut energy = energy_of(&pose);
    let (mut h, mut g) = normal_equations(&pose, rays, scaling, loss);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        // The damping is proportional to the diagonal. The small part of the trace keeps it above 0 in a direction that
        // the matches leave free.
        let scale = h.diagonal().add_scalar(h.trace() * 1e-12);
        let damped = h + Matrix5::from_diagonal(&(scale * damping));
        let step = -damped.cholesky()?.solve(&g);
        let moved = pose.moved(&step);
        let moved_energy = energy_of(&moved);
        // Unlike a test with `>`, this rejects NaN.
        if moved_energy <= energy {
            (pose, energy) = (moved, moved_energy);
            damping = (damping / 10.0).max(1e-9);
            if step.norm() < TOLERANCE {
                break;
            }
            (h, g) = normal_equations(&pose, rays, scaling, loss);
        } else if step.norm() < TOLERANCE {
            break;
        } else {
            damping *= 10.0;
        }
    }
    energy.is_finite().then_some(pose)
}

/// `sum w J J^T` and `sum w J e`.
pub(super) fn normal_equations(
    pose: &Pose,
    rays: &[Rays],
    scaling: Scaling,
    loss: Loss,
) -> (Matrix5<f64>, Vector5<f64>) {
    let essential = pose.essential();
    let (mut h, mut g) = (Matrix5::zeros(), Vector5::zeros());
    for rays in rays {
        let (e, j) = scaling.linearised(&essential, rays);
        let weighted = j * loss.weight(e);
        h += weighted * j.transpose();
        g += weighted * e;
    }
    (h, g)
}
