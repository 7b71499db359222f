//! Batches and solvers for tests of a pass.

extern crate std;

use super::solver::{PairSolver, TrackStart};
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::Batch;
use crate::batch::correspondence::Correspondence;
use crate::config::Config;
use crate::geometry::camera::{Camera, Intrinsics};
use crate::geometry::cameras::Cameras;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens::Lens;
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::rectification::tests::pose;
use crate::scalar::Scalar;
use nalgebra::Vector3;
use proptest::prelude::*;
use std::vec::Vec;

/// Focal length and principal point of the cameras, px.
pub(super) const FOCAL: f64 = 500.0;
pub(super) const CENTRE: f64 = 4000.0;

/// Returns a batch of pixels `u_l`, `v_l`, `u_r`, `v_r`. The images are so wide that some rays point behind a turned
/// camera. Every third correspondence has no grid.
pub(super) fn batch<T: Scalar>(pixels: impl Iterator<Item = [f64; 4]>) -> Batch<T, 100> {
    let intrinsics =
        Intrinsics { focal: [T::lit(FOCAL); 2], principal: [T::lit(CENTRE); 2], size: [8000; 2] };
    let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
    let cameras = Cameras { left: camera, right: camera };
    let mut batch = Batch::new();
    for (i, pixel) in pixels.enumerate() {
        let grid_step = if i % 3 == 0 { T::ZERO } else { T::lit(1.5) };
        let [u_l, v_l, u_r, v_r] = pixel.map(T::lit);
        let (left, right) = ([u_l, v_l], [u_r, v_r]);
        batch.push(&cameras, &Correspondence { left, right, score: T::ONE, grid_step }).unwrap();
    }
    batch
}

/// Generates pixels `u_l`, `v_l`, `u_r`, `v_r` over the whole width, with varied disparities and row offsets.
pub(super) fn pixels() -> impl Strategy<Value = Vec<[f64; 4]>> {
    let pixel = [200.0..7800.0, 3700.0..4299.0, -5.0..80.0, -3.0..3.0_f64];
    prop::collection::vec(pixel.prop_map(|[u, v, d, e]| [u, v, u - d, v + e]), 0..100)
}

/// Returns the rays `x_l`, `y_l`, `x_r`, `y_r` at unit depth, in the camera frames, of a correspondence given in the
/// rectified frame of a pose.
///
/// * `[u, v, d, e]`: left ray, disparity, and row of the right ray minus row of the left ray, at unit depth.
pub(super) fn rays(pose: &RectifyingRotations<f64>, [u, v, d, e]: [f64; 4]) -> [f64; 4] {
    let l = pose.left().inverse() * Vector3::new(u, v, 1.0);
    let r = pose.right().inverse() * Vector3::new(u - d, v + e, 1.0);
    [l.x / l.z, l.y / l.z, r.x / r.z, r.y / r.z]
}

/// Converts a pose to another scalar type.
pub(super) fn rounded<T: Scalar>(pose: &RectifyingRotations<f64>) -> RectifyingRotations<T> {
    let extrinsics = pose.extrinsics().unwrap();
    let r = extrinsics.rotation().matrix().map(T::lit);
    let t = extrinsics.translation().map(T::lit);
    RectifyingRotations::from(&Extrinsics::try_new(&r, &t).unwrap())
}

/// Returns a search before each of its first nine passes, and a track before its first.
pub(super) fn solvers<T: Scalar>(
    batch: &Batch<T, 100>,
    rotation: [f64; 3],
    t: [f64; 2],
) -> impl Iterator<Item = PairSolver<T>> {
    let (start, focal) = (rounded(&pose(rotation, t)), T::lit(FOCAL));
    let mut search = PairSolver::search(&Config::robust(), focal, start, 12);
    let covariance = Symmetric5::of_diagonal([T::lit(1e-6); 5]);
    let start_of_track = TrackStart {
        pose: start,
        covariance,
        noise: T::lit(0.4),
        trusts_leverage: false,
        sees_crowd: false,
    };
    let track = PairSolver::track(&Config::robust(), focal, &start_of_track).unwrap();
    let stages: Vec<_> = (0..9)
        .map(|_| {
            let at = search.clone();
            let _ = search.advance(batch.matches());
            at
        })
        .chain([track])
        .collect();
    stages.into_iter()
}
