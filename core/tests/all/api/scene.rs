//! A generated rig and its correspondences, which most tests use.

use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::geometry::so3;
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Correspondence, Extrinsics, Fused, Intrinsics, Lens, Rejection,
    Scalar,
};

pub(crate) const SIZE: [u16; 2] = [1920, 1200];
pub(crate) const FOCAL: f64 = 1400.0;

pub(crate) fn cameras<T: Scalar>() -> Cameras<T> {
    let intrinsics = Intrinsics {
        focal: [T::lit(FOCAL); 2],
        principal: [T::lit(959.5), T::lit(599.5)],
        size: SIZE,
    };
    let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
    Cameras { left: camera, right: camera }
}

/// Extrinsics with `R` of a rotation vector, degrees, and `t` turned from `(-1, 0, 0)` about y and z, degrees.
pub(crate) fn rig<T: Scalar>(rotation_deg: [f64; 3], baseline_deg: [f64; 2]) -> Extrinsics<T> {
    let exp = |v: [f64; 3]| so3::exp(&Vector3::from(v).map(f64::to_radians)).unwrap();
    let [y, z] = baseline_deg;
    let r: Matrix3<T> = exp(rotation_deg).matrix().map(T::lit);
    let t = exp([0.0, y, z]) * -Vector3::x();
    Extrinsics::try_new(&r, &t.map(T::lit)).unwrap()
}

/// Correspondences of points 3 to 80 baselines away, with uniform noise of +-`noise_px` on each coordinate.
pub(crate) fn correspondences<T: Scalar>(
    rig: &Extrinsics<f64>,
    n: usize,
    noise_px: f64,
    seed: u64,
) -> Vec<Correspondence<T>> {
    correspondences_within(rig, [3.0, 80.0], n, noise_px, seed)
}

/// Correspondences as [`correspondences`], of points at log-uniform depths in a range, in baselines.
pub(crate) fn correspondences_within<T: Scalar>(
    rig: &Extrinsics<f64>,
    [nearest, farthest]: [f64; 2],
    n: usize,
    noise_px: f64,
    seed: u64,
) -> Vec<Correspondence<T>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let [width, height] = SIZE.map(|n| f64::from(n) - 1.0);
    let mut found = Vec::new();
    while found.len() < n {
        let [u, v] = [rng.random_range(0.0..width), rng.random_range(0.0..height)];
        let depth = nearest * (farthest / nearest).powf(rng.random());
        let p_l = Vector3::new((u - 959.5) / FOCAL, (v - 599.5) / FOCAL, 1.0) * depth;
        let p_r = rig.rotation() * p_l + rig.translation().into_inner();
        let mut noise = || (rng.random::<f64>() * 2.0 - 1.0) * noise_px;
        let left = [u + noise(), v + noise()];
        let right =
            [959.5 + FOCAL * p_r.x / p_r.z + noise(), 599.5 + FOCAL * p_r.y / p_r.z + noise()];
        let inside = |[u, v]: [f64; 2]| (0.0..=width).contains(&u) && (0.0..=height).contains(&v);
        if inside(left) && inside(right) {
            let [left, right] = [left, right].map(|p| p.map(T::lit));
            found.push(Correspondence { left, right, score: T::ONE, grid_step: T::ZERO });
        }
    }
    found
}

/// Replaces the matches of the batch.
pub(crate) fn fill<T: Scalar, const N: usize>(
    calibrator: &mut Calibrator<T, N>,
    matches: &[Correspondence<T>],
) {
    calibrator.discard_pair();
    for c in matches {
        calibrator.push(c).unwrap();
    }
}

/// Replaces the matches of the batch, and solves the pair; the matches stay in the batch.
pub(crate) fn take<T: Scalar, const N: usize>(
    calibrator: &mut Calibrator<T, N>,
    matches: &[Correspondence<T>],
) -> Result<Fused, Rejection> {
    fill(calibrator, matches);
    calibrator.solve_pair().fused
}
