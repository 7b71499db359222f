//! The paper's row offsets minimised by a general solver: MINPACK's `lmder` from the crate
//! `levenberg-marquardt`.
//!
//! Six parameters, the rotation vectors of `R_l` and `R_r` from the start; `N + 1` residuals, the
//! gauge row `e_0` (eq 10) before the row offsets (eq 11). `f64`, no Huber weights, default tolerances.

use host_tests::data::Rays;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_034::{
    DVector, Dyn, Matrix3, OMatrix, Owned, Rotation3, RowVector3, U6, Vector3, Vector6,
};
use rivals::literal_paper::{Solution, initial};
use stereo_selfcal::Extrinsics;

/// Result of the solver.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// The rectifying rotations.
    pub(crate) solution: Solution,
    /// Evaluations of all residuals.
    pub(crate) evaluations: usize,
}

/// The least-squares problem of one pair.
#[derive(Debug, Clone)]
pub(crate) struct RowOffsets {
    rays: Vec<[Vector3<f64>; 2]>,
    start: [Matrix3<f64>; 2],
    params: Vector6<f64>,
    pose: [Matrix3<f64>; 2],
}

impl RowOffsets {
    /// The problem at the rig `start`.
    pub(crate) fn new(start: &Extrinsics<f64>, rays: &[Rays]) -> Self {
        let start = initial(start.rotation().matrix(), &start.translation().into_inner())
            .map(|m| <[[f64; 3]; 3]>::from(m).into());
        let rays = rays.iter().map(|pair| pair.map(|ray| <[f64; 3]>::from(ray).into())).collect();
        Self { rays, start, params: Vector6::zeros(), pose: start }
    }

    /// Runs the solver.
    pub(crate) fn minimise(self) -> Fit {
        let (end, report) = LevenbergMarquardt::new().minimize(self);
        let [left, right] = end.pose.map(|m| <[[f64; 3]; 3]>::from(m).into());
        let converged = report.termination.was_successful();
        let evaluations = report.number_of_evaluations;
        Fit { solution: Solution { left, right, converged }, evaluations }
    }

    fn turns(&self) -> [Vector3<f64>; 2] {
        [0, 3].map(|i| self.params.fixed_rows::<3>(i).into_owned())
    }
}

impl LeastSquaresProblem<f64, Dyn, U6> for RowOffsets {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U6>;
    type ParameterStorage = Owned<f64, U6>;

    fn set_params(&mut self, params: &Vector6<f64>) {
        self.params = *params;
        let [left, right] = self.turns().map(|turn| Rotation3::new(turn).into_inner());
        let [start_left, start_right] = &self.start;
        self.pose = [left * start_left, right * start_right];
    }

    fn params(&self) -> Vector6<f64> {
        self.params
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let [left, right] = &self.pose;
        let row = |m: &Matrix3<f64>, ray: &Vector3<f64>| {
            let p = m * ray;
            p.y / p.z
        };
        let offsets = self.rays.iter().map(|[l, r]| row(left, l) - row(right, r));
        let all = std::iter::once(right.m23).chain(offsets);
        Some(DVector::from_iterator(self.rays.len() + 1, all))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U6>> {
        let [left, right] = &self.pose;
        let [by_left, by_right] = self.turns().map(|turn| left_jacobian(&turn));
        // Derivative of v by a left perturbation (eq 15).
        let row = |m: &Matrix3<f64>, ray: &Vector3<f64>| {
            let p = m * ray;
            let (u, v) = (p.x / p.z, p.y / p.z);
            RowVector3::new(-(1.0 + v * v), u * v, u)
        };
        let mut all = OMatrix::<f64, Dyn, U6>::zeros(self.rays.len() + 1);
        // -i_2^T [R_r i_3]x (eq 14, its sign corrected).
        let gauge = RowVector3::new(-right.m33, 0.0, right.m13);
        all.fixed_view_mut::<1, 3>(0, 3).copy_from(&(gauge * by_right));
        for (i, [l, r]) in self.rays.iter().enumerate() {
            all.fixed_view_mut::<1, 3>(i + 1, 0).copy_from(&(row(left, l) * by_left));
            all.fixed_view_mut::<1, 3>(i + 1, 3).copy_from(&(row(right, r) * -by_right));
        }
        Some(all)
    }
}

/// `J` of `exp(w + d) = exp(J d) exp(w)` to first order.
fn left_jacobian(w: &Vector3<f64>) -> Matrix3<f64> {
    let (angle, k) = (w.norm(), w.cross_matrix());
    if angle < 1e-6 {
        return Matrix3::identity() + k / 2.0;
    }
    let square = angle * angle;
    let [first, second] = [1.0 - angle.cos(), 1.0 - angle.sin() / angle];
    Matrix3::identity() + k * (first / square) + k * k * (second / square)
}
