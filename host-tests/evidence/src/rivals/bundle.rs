//! Bundle adjustment of all pairs: it finds the extrinsics with `|t| = 1` and the points that minimise a robust
//! reprojection error in both images.
//!
//! The points are eliminated exactly (variable projection): for given extrinsics the best point of a correspondence is
//! the nearest pair of points that meets the epipolar constraint (K. Kanatani, Y. Sugaya and H. Niitsu, "Triangulation
//! from two views revisited", BMVC 2008), and its distance from the measured points is the residual. Because the point
//! is at its optimum, the derivative of the residual equals that of the constraint there. Cauchy's loss applies to both
//! reprojection errors of a match together. MINPACK's Levenberg-Marquardt (crate `levenberg-marquardt`) minimises it.
//!
//! It starts from the result of RANSAC, as in structure from motion, because with outliers it may fail from a start
//! that is some degrees off. It is slow, because each estimate of a run is an adjustment of all pairs so far.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{Matrix3, Vector2};
use nalgebra_034::{DVector, Dyn, OMatrix, Owned, RowVector5, U5, Vector5};
use stereo_selfcal::Extrinsics;

use super::cauchy::CAUCHY_SD;
use super::method::{Method, Setting, usable};
use super::minimise::FEWEST;
use super::pose::{Essential, Pose};
use super::ransac::Ransac;
use rigs::data::Rays;

/// Number of corrections of a point towards the best point; convergence is quadratic.
const CORRECTIONS: usize = 4;

/// Factor of the number of unknowns in MINPACK's limit of evaluations.
const PATIENCE: usize = 20;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct Bundle;

impl Method for Bundle {
    fn name(&self) -> &'static str {
        "bundle"
    }

    fn source(&self) -> &'static str {
        "bundle adjustment of all pairs, points eliminated exactly, Cauchy loss of 2.385 noise \
         deviations, MINPACK's Levenberg-Marquardt (crate levenberg-marquardt) from what RANSAC gives"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        let starts = Ransac.running(pairs, setting);
        let upto = (1..).zip(&starts);
        upto.map(|(count, start)| adjusted(&pairs[..count], start.as_ref(), setting)).collect()
    }

    fn fused(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Option<Extrinsics<f64>> {
        adjusted(pairs, Ransac.fused(pairs, setting).as_ref(), setting)
    }
}

/// Adjusts all correspondences of all pairs, from `start` or from the start of the setting. `None` for fewer than
/// [`FEWEST`] correspondences, or if the result is not a stereo rig.
fn adjusted(
    pairs: &[Vec<Rays>],
    start: Option<&Extrinsics<f64>>,
    setting: &Setting,
) -> Option<Extrinsics<f64>> {
    let rays: Vec<Rays> = pairs.iter().flat_map(|rays| usable(rays)).collect();
    if rays.len() < FEWEST {
        return None;
    }
    let scale = CAUCHY_SD * setting.noise();
    let problem = Adjustment::new(Pose::of(start.unwrap_or(&setting.start)), rays, scale);
    let solver = LevenbergMarquardt::new().with_patience(PATIENCE);
    let (end, _) = solver.minimize(problem);
    end.pose.extrinsics()
}

/// The least-squares problem after the points are eliminated.
struct Adjustment {
    rays: Vec<Rays>,
    /// Scale of the loss, unit depth.
    scale: f64,
    start: Pose,
    params: Vector5<f64>,
    pose: Pose,
}

impl Adjustment {
    fn new(start: Pose, rays: Vec<Rays>, scale: f64) -> Self {
        Self { rays, scale, start, params: Vector5::zeros(), pose: start }
    }

    fn moved(&self, params: &Vector5<f64>) -> Pose {
        self.start.moved(&<[f64; 5]>::from(*params).into())
    }

    /// Essential matrix at the parameters, and its numeric derivatives by the parameters. The derivatives of
    /// [`Pose::essential`] do not serve, because they are by a step from that pose; the parameters are a step from
    /// `start`.
    fn essential(&self) -> Essential {
        const H: f64 = 1e-5;
        let by = std::array::from_fn(|i| {
            let at = |h| self.moved(&(self.params + Vector5::ith(i, h))).essential().e;
            (at(H) - at(-H)) / (2.0 * H)
        });
        Essential { e: self.pose.essential().e, by }
    }

    /// `f(d) = c sqrt(log(1 + (d / c)^2))`, whose square is Cauchy's loss, signed as `d`; and `f'`.
    fn robust(&self, d: f64) -> (f64, f64) {
        let squared = (d / self.scale).powi(2);
        let root = squared.ln_1p().sqrt();
        // Near 0 the quotient takes its limit.
        let by = if squared < 1e-12 { 1.0 } else { d.abs() / self.scale / (1.0 + squared) / root };
        (self.scale * root.copysign(d), by)
    }
}

impl LeastSquaresProblem<f64, Dyn, U5> for Adjustment {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U5>;
    type ParameterStorage = Owned<f64, U5>;

    fn set_params(&mut self, params: &Vector5<f64>) {
        self.params = *params;
        self.pose = self.moved(params);
    }

    fn params(&self) -> Vector5<f64> {
        self.params
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let e = self.pose.essential().e;
        let residual = |rays| self.robust(Triangulated::of(&e, rays).miss).0;
        Some(DVector::from_iterator(self.rays.len(), self.rays.iter().map(residual)))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U5>> {
        let essential = self.essential();
        let row = |rays: &Rays| {
            let Triangulated { points: [p_l, p_r], gradient, miss } =
                Triangulated::of(&essential.e, rays);
            let by = self.robust(miss).1 / gradient;
            RowVector5::from(essential.by.map(|e| p_r.dot(&(e * p_l)) * by))
        };
        let rows: Vec<_> = self.rays.iter().map(row).collect();
        Some(OMatrix::<f64, Dyn, U5>::from_rows(&rows))
    }
}

/// The nearest points to a correspondence that meet the epipolar constraint.
struct Triangulated {
    points: Rays,
    /// Length of the gradient of the constraint at these points.
    gradient: f64,
    /// Distance of the points from the measurement, with the sign of the constraint at the measurement.
    miss: f64,
}

impl Triangulated {
    fn of(e: &Matrix3<f64>, measured: &Rays) -> Self {
        let mut points = *measured;
        let mut gradient = 0.0;
        for _ in 0..CORRECTIONS {
            let [p_l, p_r] = points;
            let (by_r, by_l) = ((e * p_l).xy(), e.tr_mul(&p_r).xy());
            gradient = (by_r.norm_squared() + by_l.norm_squared()).sqrt();
            // The constraint at the measurement, linearised at the points.
            let off = |i: usize| -> Vector2<f64> { (measured[i] - points[i]).xy() };
            let constraint = p_r.dot(&(e * p_l)) + by_l.dot(&off(0)) + by_r.dot(&off(1));
            let along = constraint / (gradient * gradient);
            points = *measured;
            points[0] -= (by_l * along).push(0.0);
            points[1] -= (by_r * along).push(0.0);
        }
        let [l, r] = [0, 1].map(|i| (measured[i] - points[i]).norm_squared());
        let sign = measured[1].dot(&(e * measured[0]));
        Self { points, gradient, miss: (l + r).sqrt().copysign(sign) }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector4;

    use super::*;
    use crate::rivals::Tuning;
    use sim::bounds::joint_fit;
    use sim::synth::{Scene, rig};
    use stereo_selfcal::geometry::metrics::Deviation;

    fn scene() -> Scene {
        Scene { rig: rig([4.0, -3.0, 2.0], [6.0, -5.0]).unwrap(), ..Scene::default() }
    }

    fn observed(scene: &Scene, pairs: usize) -> Vec<Vec<Rays>> {
        scene.pairs(7).take(pairs).map(|pair| pair.rays(scene)).collect()
    }

    #[test]
    fn the_triangulated_points_meet_the_constraint_and_no_nearer_ones_do() {
        let scene = scene();
        let e = Pose::of(&scene.rig).essential().e;
        for measured in &observed(&scene, 1)[0] {
            let Triangulated { points: [l, r], .. } = Triangulated::of(&e, measured);
            assert!(r.dot(&(e * l)).abs() < 1e-12);
            // The measurement is off along the normal of the constraint, in all four coordinates.
            let four = |a: Vector2<f64>, b: Vector2<f64>| Vector4::new(a.x, a.y, b.x, b.y);
            let off = four((measured[0] - l).xy(), (measured[1] - r).xy());
            let normal = four(e.tr_mul(&r).xy(), (e * l).xy()).normalize();
            let aside = off - normal * normal.dot(&off);
            assert!(aside.norm() < 1e-9, "{aside}");
        }
    }

    #[test]
    fn derivatives_match_central_differences_away_from_the_start() {
        let scene = Scene { matches: 20, outliers: 0.3, ..scene() };
        let rays = observed(&scene, 1).remove(0);
        let mut problem = Adjustment::new(Pose::of(&scene.rig), rays, 1e-3);
        let at = Vector5::new(0.02, -0.01, 0.03, -0.02, 0.01);
        problem.set_params(&at);
        let analytic = problem.jacobian().unwrap();
        for i in 0..5 {
            let mut residuals = |h| {
                problem.set_params(&(at + Vector5::ith(i, h)));
                problem.residuals().unwrap()
            };
            let numeric = (residuals(1e-6) - residuals(-1e-6)) / 2e-6;
            let off = (numeric - analytic.column(i)).amax();
            assert!(off < 1e-4, "{i}: {off}");
        }
    }

    #[test]
    fn without_outliers_it_is_the_joint_fit_of_all_pairs() {
        let scene = scene();
        let pairs = observed(&scene, 4);
        let tuning = Tuning::default();
        let start = Extrinsics::SIDE_BY_SIDE;
        let setting = Setting { start, focal: 1400.0, noise_px: 30.0, tuning };
        let found = Bundle.fused(&pairs, &setting).unwrap();
        let joint = joint_fit(&scene.rig, &pairs.concat());
        let off = Deviation::between(&found, &joint);
        let error = Deviation::between(&joint, &scene.rig);
        assert!(off.translation < 0.02 * error.translation, "{off:?} {error:?}");
        assert!(off.rotation < 0.02 * error.rotation, "{off:?} {error:?}");
    }
}
