//! The best possible estimates from the data: the Cramer-Rao bound, and the joint maximum-likelihood fit of the true
//! inliers of all pairs.
//!
//! Model: independent Gaussian noise of one variance on all four pixel coordinates, and unknown points. To first order
//! the unknown points drop out. The epipolar constraint divided by its own standard deviation (Sampson) remains:
//! `r = p_r^T E p_l / |grad|`, `E = [t]x R`. The code is independent of the core: it uses `E` instead of rectifying
//! rotations, numeric derivatives, and `f64`.

use nalgebra::{Matrix3, Matrix5, Rotation3, Vector3, Vector5};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Camera, Cameras, Extrinsics};

use rigs::data::Rays;

/// `R` and unit `t`. A step has five unknowns in the right camera frame, rad: a rotation of `R` about x, y and z, and a
/// turn of `t` in two directions perpendicular to it.
#[derive(Debug, Clone, Copy)]
struct Pose {
    rotation: Rotation3<f64>,
    translation: Vector3<f64>,
}

impl Pose {
    fn moved(&self, d: &Vector5<f64>) -> Self {
        let rotation = Rotation3::new(Vector3::new(d[0], d[1], d[2])) * self.rotation;
        // Two directions that are perpendicular to t and to each other.
        let across = self.translation.cross(&Vector3::z()).normalize();
        let other = self.translation.cross(&across);
        let translation = (self.translation + across * d[3] + other * d[4]).normalize();
        Self { rotation, translation }
    }

    fn essential(&self) -> Matrix3<f64> {
        self.translation.cross_matrix() * self.rotation.matrix()
    }
}

impl From<&Extrinsics<f64>> for Pose {
    fn from(extrinsics: &Extrinsics<f64>) -> Self {
        Self {
            rotation: *extrinsics.rotation(),
            translation: extrinsics.translation().into_inner(),
        }
    }
}

/// Epipolar constraint of a correspondence over its standard deviation, for noise of standard deviation 1 at unit
/// depth.
fn whitened(e: &Matrix3<f64>, [p_l, p_r]: &Rays) -> f64 {
    let (in_right, in_left) = (e * p_l, e.tr_mul(p_r));
    let gradient = in_right.xy().norm_squared() + in_left.xy().norm_squared();
    p_r.dot(&in_right) / gradient.sqrt()
}

/// `sum J J^T` and `sum J r` of the whitened residuals `r` and their derivatives `J` with respect to the unknowns of
/// [`Pose`], for noise of standard deviation 1 at unit depth.
fn normal_equations<'a>(
    pose: &Pose,
    rays: impl Iterator<Item = &'a Rays>,
) -> (Matrix5<f64>, Vector5<f64>) {
    const H: f64 = 1e-6;
    let moved = |i: usize, h: f64| pose.moved(&(Vector5::ith(i, h))).essential();
    let both: [[Matrix3<f64>; 2]; 5] = std::array::from_fn(|i| [moved(i, H), moved(i, -H)]);
    let centre = pose.essential();
    let (mut h, mut g) = (Matrix5::zeros(), Vector5::zeros());
    for rays in rays {
        let j = Vector5::from_fn(|i, _| {
            let [plus, minus] = &both[i];
            (whitened(plus, rays) - whitened(minus, rays)) / (2.0 * H)
        });
        h += j * j.transpose();
        g += j * whitened(&centre, rays);
    }
    (h, g)
}

/// Cramer-Rao bound: least possible RMS error of `t` and of `R` of an unbiased estimate, rad.
///
/// * `rays`: the noise-free rays of the true inliers.
/// * `noise`: standard deviation of a coordinate at unit depth: px over the focal length.
///
/// # Panics
/// If the rays do not determine all five unknowns.
pub fn cramer_rao<'a>(
    truth: &Extrinsics<f64>,
    rays: impl Iterator<Item = &'a Rays>,
    noise: f64,
) -> Deviation<f64> {
    let (information, _) = normal_equations(&Pose::from(truth), rays);
    deviation(&(information / (noise * noise)))
}

/// Maximum-likelihood extrinsics of all given correspondences, by four Gauss-Newton steps from the truth.
///
/// # Panics
/// If [`try_joint_fit`] gives `None`.
pub fn joint_fit(truth: &Extrinsics<f64>, rays: &[Rays]) -> Extrinsics<f64> {
    try_joint_fit(truth, rays).expect("the scene determines all directions")
}

/// As [`joint_fit`]; `None` if the rays do not determine all five unknowns, or so poorly that the fit diverges.
pub fn try_joint_fit(truth: &Extrinsics<f64>, rays: &[Rays]) -> Option<Extrinsics<f64>> {
    let mut pose = Pose::from(truth);
    for _ in 0..4 {
        let (h, g) = normal_equations(&pose, rays.iter());
        pose = pose.moved(&-h.cholesky()?.solve(&g));
    }
    Extrinsics::try_new(pose.rotation.matrix(), &pose.translation).ok()
}

/// Cramer-Rao bound as [`cramer_rao`], for noise of the pixels of any lens: a pixel near the border of a wide-angle lens
/// is a larger part of the plane at unit depth, and not equal in all directions.
///
/// * `pixels`: noise-free `ul vl ur vr` of the true inliers; `noise_px`: standard deviation of a coordinate, px.
///
/// # Panics
/// If a pixel or one beside it has no ray, or the pixels do not determine all five unknowns.
pub fn cramer_rao_through<'a>(
    cameras: &Cameras<f64>,
    truth: &Extrinsics<f64>,
    pixels: impl Iterator<Item = &'a [f64; 4]>,
    noise_px: f64,
) -> Deviation<f64> {
    const H: f64 = 1e-6;
    let pose = Pose::from(truth);
    let centre = pose.essential();
    let moved = |i: usize, h: f64| pose.moved(&(Vector5::ith(i, h))).essential();
    let both: [[Matrix3<f64>; 2]; 5] = std::array::from_fn(|i| [moved(i, H), moved(i, -H)]);
    let constraint = |e: &Matrix3<f64>, [ul, vl, ur, vr]: [f64; 4]| {
        let ray = |camera: &Camera<f64>, pixel| camera.ray(pixel).expect("a ray").push(1.0);
        ray(&cameras.right, [ur, vr]).dot(&(e * ray(&cameras.left, [ul, vl])))
    };
    let mut information = Matrix5::zeros();
    for pixels in pixels {
        let beside =
            |i: usize, h: f64| std::array::from_fn(|k| pixels[k] + if k == i { h } else { 0.0 });
        let by_pixel = |i| {
            let h = 1e-3;
            (constraint(&centre, beside(i, h)) - constraint(&centre, beside(i, -h))) / (2.0 * h)
        };
        let variance = (0..4).map(|i| by_pixel(i).powi(2)).sum::<f64>() * noise_px * noise_px;
        let j = Vector5::from_fn(|i, _| {
            let [plus, minus] = &both[i];
            (constraint(plus, *pixels) - constraint(minus, *pixels)) / (2.0 * H)
        });
        information += j * j.transpose() / variance;
    }
    deviation(&information)
}

/// Root of the traces of the blocks of the covariance with an information.
fn deviation(information: &Matrix5<f64>) -> Deviation<f64> {
    let covariance = information.try_inverse().expect("the scene determines all directions");
    Deviation {
        rotation: covariance.fixed_view::<3, 3>(0, 0).trace().sqrt(),
        translation: covariance.fixed_view::<2, 2>(3, 3).trace().sqrt(),
    }
}
