//! The paper's single-pair method, transcribed literally: six parameters, the gauge row `e_0`,
//! Huber weights, Levenberg-Marquardt (eqs 10-19), in `f64`.
//!
//! It is slow and plain, and shares no code with the core, because it checks the core. Where the paper is wrong (see
//! the errata tests), it has the corrected form.

use nalgebra::{Matrix3, Matrix6, RowVector3, Vector3, Vector6};

use rigs::data::Rays;

/// Parameters of the transcription.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// `c_t` of eq 18, unit depth.
    pub huber: f64,
    /// Weight of the gauge row `e_0` in the energy; 1 in the paper. A large weight makes the gauge exact.
    pub gauge_weight: f64,
    /// Step below which it has converged, rad.
    pub tolerance: f64,
    /// Largest number of steps.
    pub max_steps: usize,
}

impl Options {
    /// The published parameters, with enough steps for convergence.
    #[must_use]
    pub fn literal(huber: f64) -> Self {
        Self { huber, gauge_weight: 1.0, tolerance: 1e-12, max_steps: 5000 }
    }
}

/// The rotations found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution {
    /// `R_l`.
    pub left: Matrix3<f64>,
    /// `R_r`.
    pub right: Matrix3<f64>,
    /// Whether the step fell below the tolerance.
    pub converged: bool,
}

impl Solution {
    /// `R = R_r^T R_l` (eq 7).
    #[must_use]
    pub fn rotation(&self) -> Matrix3<f64> {
        self.right.transpose() * self.left
    }

    /// `t = -r_r1` (eq 7).
    #[must_use]
    pub fn translation(&self) -> Vector3<f64> {
        -self.right.row(0).transpose()
    }

    /// `e_0` at the solution: the deviation from the gauge of eq 8.
    #[must_use]
    pub fn gauge(&self) -> f64 {
        gauge(&self.right)
    }
}

/// `e_0 = i_2^T R_r i_3` (eq 10).
#[must_use]
pub fn gauge(right: &Matrix3<f64>) -> f64 {
    right[(1, 2)]
}

/// `J_0 = [0 0 0, -i_2^T [R_r i_3]x]` (eq 14 with the sign that finite differences give).
#[must_use]
pub fn gauge_jacobian(right: &Matrix3<f64>) -> Vector6<f64> {
    let i_2 = RowVector3::new(0.0, 1.0, 0.0);
    let row = -i_2 * (right * Vector3::z()).cross_matrix();
    Vector6::new(0.0, 0.0, 0.0, row[0], row[1], row[2])
}

/// `e_i = (r_l2 . p_l) / (r_l3 . p_l) - (r_r2 . p_r) / (r_r3 . p_r)` (eq 11).
#[must_use]
pub fn residual(left: &Matrix3<f64>, right: &Matrix3<f64>, [p_l, p_r]: &Rays) -> f64 {
    let (l, r) = (left * p_l, right * p_r);
    l.y / l.z - r.y / r.z
}

/// Derivative of [`residual`] by left perturbations of both rotations (eqs 14, 15): the chain of
/// `d(y/z) = [0, 1/z, -y/z^2] dp'` and `dp' = -[p']x dtheta`.
#[must_use]
pub fn residual_jacobian(
    left: &Matrix3<f64>,
    right: &Matrix3<f64>,
    [p_l, p_r]: &Rays,
) -> Vector6<f64> {
    let derivative =
        |p: Vector3<f64>| RowVector3::new(0.0, 1.0 / p.z, -p.y / (p.z * p.z)) * -p.cross_matrix();
    let (l, r) = (derivative(left * p_l), -derivative(right * p_r));
    Vector6::new(l[0], l[1], l[2], r[0], r[1], r[2])
}

/// `R_r` = rows `-t`, `normalize(i_3 x r_r1)`, `r_r1 x r_r2` (eq 8, normalized); `R_l = R_r R`.
#[must_use]
pub fn initial(r: &Matrix3<f64>, t: &Vector3<f64>) -> [Matrix3<f64>; 2] {
    let r_1 = -t.normalize();
    let r_2 = Vector3::z().cross(&r_1).normalize();
    let r_3 = r_1.cross(&r_2);
    let right = Matrix3::from_rows(&[r_1.transpose(), r_2.transpose(), r_3.transpose()]);
    [right * r, right]
}

/// Minimises eq 12 from `R`, `t`.
///
/// # Panics
/// If the rays are not finite.
#[must_use]
pub fn solve(r: &Matrix3<f64>, t: &Vector3<f64>, rays: &[Rays], options: Options) -> Solution {
    let [mut left, mut right] = initial(r, t);
    let mut energy = total_energy(&left, &right, rays, options);
    let mut lambda = 1e-3;
    for _ in 0..options.max_steps {
        let (h, g) = normal_equations(&left, &right, rays, options);
        let damped = h + Matrix6::identity() * lambda;
        let step = -damped.cholesky().expect("damped normal equations").solve(&g);
        let turn = |i: usize| exp(&step.fixed_rows::<3>(i).into_owned());
        let (new_left, new_right) = (turn(0) * left, turn(3) * right);
        let new_energy = total_energy(&new_left, &new_right, rays, options);
        let small = step.norm() < options.tolerance;
        if new_energy <= energy {
            (left, right, energy) = (new_left, new_right, new_energy);
            lambda = (lambda / 10.0).max(1e-12);
        } else {
            lambda *= 10.0;
        }
        if small {
            return Solution { left, right, converged: true };
        }
    }
    Solution { left, right, converged: false }
}

/// Eq 12 with Huber's loss in place of the square for `e_1` to `e_N`, and `w_0 e_0^2`; halved.
fn total_energy(left: &Matrix3<f64>, right: &Matrix3<f64>, rays: &[Rays], options: Options) -> f64 {
    let huber = |e: f64| {
        let c = options.huber;
        if e.abs() <= c { e * e / 2.0 } else { c * (e.abs() - c / 2.0) }
    };
    let e_0 = gauge(right);
    let matches: f64 = rays.iter().map(|rays| huber(residual(left, right, rays))).sum();
    options.gauge_weight * e_0 * e_0 / 2.0 + matches
}

/// `sum w_i J_i J_i^T` and `sum w_i J_i e_i` (eqs 17, 18).
fn normal_equations(
    left: &Matrix3<f64>,
    right: &Matrix3<f64>,
    rays: &[Rays],
    options: Options,
) -> (Matrix6<f64>, Vector6<f64>) {
    let j_0 = gauge_jacobian(right);
    let mut h = options.gauge_weight * j_0 * j_0.transpose();
    let mut g = options.gauge_weight * j_0 * gauge(right);
    for rays in rays {
        let e = residual(left, right, rays);
        let w = if e.abs() <= options.huber { 1.0 } else { options.huber / e.abs() };
        let j = residual_jacobian(left, right, rays);
        h += w * j * j.transpose();
        g += w * j * e;
    }
    (h, g)
}

/// Rodrigues' formula.
fn exp(w: &Vector3<f64>) -> Matrix3<f64> {
    let angle = w.norm();
    let k = w.cross_matrix();
    if angle < 1e-8 {
        return Matrix3::identity() + k + k * k / 2.0;
    }
    let half = (angle / 2.0).sin() / (angle / 2.0);
    Matrix3::identity() + k * (angle.sin() / angle) + k * k * (half * half / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEFT: Vector3<f64> = Vector3::new(0.02, -0.07, 0.05);
    const RIGHT: Vector3<f64> = Vector3::new(-0.04, 0.03, 0.06);

    fn pose() -> [Matrix3<f64>; 2] {
        [exp(&LEFT), exp(&RIGHT)]
    }

    /// Central difference by the six left perturbations.
    fn differences(f: impl Fn(&Matrix3<f64>, &Matrix3<f64>) -> f64) -> Vector6<f64> {
        let [left, right] = pose();
        let h = 1e-5;
        Vector6::from_fn(|i, _| {
            let at = |h: f64| {
                let mut d = Vector6::zeros();
                d[i] = h;
                let turn = |i: usize| exp(&d.fixed_rows::<3>(i).into_owned());
                f(&(turn(0) * left), &(turn(3) * right))
            };
            (at(h) - at(-h)) / (2.0 * h)
        })
    }

    #[test]
    fn residual_jacobian_matches_central_differences() {
        let [left, right] = pose();
        let rays = [Vector3::new(0.3, -0.2, 1.0), Vector3::new(0.25, -0.21, 1.0)];
        let miss =
            differences(|l, r| residual(l, r, &rays)) - residual_jacobian(&left, &right, &rays);
        assert!(miss.norm() < 1e-9, "{miss}");
    }

    #[test]
    fn gauge_jacobian_matches_central_differences_and_its_printed_sign_does_not() {
        let [_, right] = pose();
        let numeric = differences(|_, r| gauge(r));
        let analytic = gauge_jacobian(&right);
        assert!((numeric - analytic).norm() < 1e-9);
        assert!((numeric + analytic).norm() > 1.0, "erratum 1 cannot be detected");
    }
}
