//! Dang, Hoffmann and Stiller, "Continuous stereo self-calibration by camera parameter tracking",
//! IEEE Transactions on Image Processing 2009.
//!
//! An iterated extended Kalman filter, recursive over pairs. Its state is the rotation of each camera against the
//! baseline. The measurement is the implicit epipolar constraint `h = i_1 . (R_l p_l x R_r p_r) = 0`, through which the
//! noise of the image points is propagated.
//!
//! Left out: intrinsics, motion of the points over time, and bundle constraints.
//!
//! Filled in:
//! - The gauge: the left camera does not turn about the baseline.
//! - Prior and process noise (`filter`).
//! - Outliers are rejected by the median of the innovations, instead of random sampling for the least median of
//!   squares.
//! - The published update is a plain Gauss-Newton step, which may diverge from a start some degrees off. Here the step
//!   is damped, and repeated until it has converged.

use nalgebra::{Matrix3, Matrix5, Rotation3, Vector3, Vector5};
use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::so3;

use super::filter::{PRIOR_SD, limit};
use super::literal_paper;
use super::method::{Method, Setting, usable};
use rigs::data::Rays;

/// Largest number of steps of an update; most updates take about ten.
const STEPS: usize = 60;

/// The step below which an update has converged, rad.
const TOLERANCE: f64 = 1e-9;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct Dang;

impl Method for Dang {
    fn name(&self) -> &'static str {
        "dang"
    }

    fn source(&self) -> &'static str {
        "Dang, Hoffmann and Stiller, TIP 2009: iterated extended Kalman filter on the rotations of both \
         cameras from implicit epipolar constraints. Extrinsics only, no bundle constraints. Filled in: \
         rejection by the median innovation, damping, prior 0.1 rad, process noise"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        let mut filter = Filter::at(&setting.start);
        let mut estimate = None;
        let after = pairs.iter().map(|rays| {
            let process_sd = setting.tuning.process_sd();
            filter.covariance += Matrix5::identity() * (process_sd * process_sd);
            let updated = filter.updated(&usable(rays), setting.noise());
            if let Some((updated, rig)) = updated.and_then(|f| Some((f, f.state.extrinsics()?))) {
                filter = updated;
                estimate = Some(rig);
            }
            estimate
        });
        after.collect()
    }
}

/// `R_l`, `R_r`: from each camera to axes whose x is along the baseline.
#[derive(Debug, Clone, Copy)]
struct State {
    left: Rotation3<f64>,
    right: Rotation3<f64>,
}

impl State {
    /// The state after the turns `[y_l, z_l, x_r, y_r, z_r]`, rad, which multiply the rotations from the left.
    fn moved(&self, d: &Vector5<f64>) -> Self {
        Self {
            left: Rotation3::new(Vector3::new(0.0, d[0], d[1])) * self.left,
            right: Rotation3::new(Vector3::new(d[2], d[3], d[4])) * self.right,
        }
    }

    /// The turns of [`State::moved`] that lead to `other`, to first order.
    fn step_to(&self, other: &Self) -> Vector5<f64> {
        let left = so3::log(&(other.left * self.left.inverse()));
        let right = so3::log(&(other.right * self.right.inverse()));
        Vector5::new(left.y, left.z, right.x, right.y, right.z)
    }

    /// `R = R_r^T R_l`, `t = -r_r1`.
    fn extrinsics(&self) -> Option<Extrinsics<f64>> {
        let r: Matrix3<f64> = (self.right.inverse() * self.left).into_inner();
        Extrinsics::try_new(&r, &-self.right.matrix().row(0).transpose()).ok()
    }

    /// `h` divided by the propagated deviation of unit noise, and its derivative by the five turns. The derivative is
    /// exact where `h` is 0, because it takes the deviation as constant.
    fn innovation(&self, [p_l, p_r]: &Rays) -> (f64, Vector5<f64>) {
        let (l, r) = (self.left * p_l, self.right * p_r);
        // h = l . (r x i_1) = r . (i_1 x l).
        let (by_l, by_r) = (r.cross(&Vector3::x()), Vector3::x().cross(&l));
        let in_left = self.left.inverse_transform_vector(&by_l).xy().norm_squared();
        let in_right = self.right.inverse_transform_vector(&by_r).xy().norm_squared();
        let deviation = (in_left + in_right).sqrt();
        let (turn_l, turn_r) = (l.cross(&by_l), r.cross(&by_r));
        let j = Vector5::new(turn_l.y, turn_l.z, turn_r.x, turn_r.y, turn_r.z);
        (l.dot(&by_l) / deviation, j / deviation)
    }
}

/// State and covariance.
#[derive(Debug, Clone, Copy)]
struct Filter {
    state: State,
    covariance: Matrix5<f64>,
}

impl Filter {
    fn at(start: &Extrinsics<f64>) -> Self {
        let t = start.translation().into_inner();
        let [left, right] = literal_paper::initial(start.rotation().matrix(), &t)
            .map(Rotation3::from_matrix_unchecked);
        let covariance = Matrix5::identity() * (PRIOR_SD * PRIOR_SD);
        Self { state: State { left, right }, covariance }
    }

    /// The iterated update by all constraints of a pair, by Levenberg-Marquardt. `None` without rays, or if a matrix is
    /// not positive definite.
    fn updated(&self, rays: &[Rays], noise: f64) -> Option<Self> {
        if rays.is_empty() {
            return None;
        }
        let prior = self.covariance.cholesky()?.inverse();
        let mut state = self.state;
        let mut damping = 0.0;
        for _ in 0..STEPS {
            let rows: Vec<_> = rays.iter().map(|rays| state.innovation(rays)).collect();
            let limit = limit(rows.iter().map(|(h, _)| h.abs()), noise);
            let off = state.step_to(&self.state);
            let (mut information, mut gradient) = (prior, -prior * off);
            for (h, j) in rows.iter().filter(|(h, _)| h.abs() <= limit) {
                information += j * j.transpose() / (noise * noise);
                gradient += j * (h / (noise * noise));
            }
            let scale = Matrix5::from_diagonal(&information.diagonal());
            let step = -(information + scale * damping).cholesky()?.solve(&gradient);
            let moved = state.moved(&step);
            let energy = |at: &State| self.energy(&prior, at, rays, noise, limit);
            if energy(&moved) <= energy(&state) {
                (state, damping) = (moved, if damping < 1e-6 { 0.0 } else { damping / 10.0 });
            } else {
                damping = (damping * 10.0).max(1e-3);
            }
            if step.norm() < TOLERANCE {
                break;
            }
        }
        Self::at_optimum(&prior, state, rays, noise)
    }

    /// The state with its covariance. `None` if the information is not positive definite.
    fn at_optimum(prior: &Matrix5<f64>, state: State, rays: &[Rays], noise: f64) -> Option<Self> {
        let rows: Vec<_> = rays.iter().map(|rays| state.innovation(rays)).collect();
        let limit = limit(rows.iter().map(|(h, _)| h.abs()), noise);
        let fit = rows.iter().filter(|(h, _)| h.abs() <= limit);
        let information: Matrix5<f64> = fit.map(|(_, j)| j * j.transpose()).sum();
        let posterior = (prior + information / (noise * noise)).cholesky()?;
        Some(Self { state, covariance: posterior.inverse() })
    }

    /// Sum of the squared distance from the prior and the squared truncated innovations, in units of their variances.
    fn energy(
        &self,
        prior: &Matrix5<f64>,
        at: &State,
        rays: &[Rays],
        noise: f64,
        limit: f64,
    ) -> f64 {
        let off = at.step_to(&self.state);
        let size = |rays: &Rays| at.innovation(rays).0.abs().min(limit) / noise;
        off.dot(&(prior * off)) + rays.iter().map(|rays| size(rays).powi(2)).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::synth;

    #[test]
    fn derivatives_of_the_constraint_match_central_differences_where_it_holds() {
        let rig = synth::rig([4.0, -3.0, 2.0], [6.0, -5.0]).unwrap();
        let state = Filter::at(&rig).state;
        let p_l = Vector3::new(0.3, -0.2, 1.0);
        let p = rig.rotation() * p_l * 4.0 + rig.translation().into_inner();
        let rays = [p_l, p / p.z];
        let (h, j) = state.innovation(&rays);
        assert!(h.abs() < 1e-12, "{h}");
        let numeric = Vector5::from_fn(|i, _| {
            let at = |h| state.moved(&Vector5::ith(i, h)).innovation(&rays).0;
            (at(1e-5) - at(-1e-5)) / 2e-5
        });
        assert!((numeric - j).norm() < 1e-9, "{numeric} {j}");
    }
}
