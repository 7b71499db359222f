//! Batches and solvers for tests of a pass.

use super::solver::{PairSolver, TrackStart};
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::Batch;
use crate::batch::correspondence::{Cameras, Correspondence};
use crate::config::Config;
use crate::geometry::camera::{Camera, Intrinsics};
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens::Lens;
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::rectification::tests::pose;
use crate::scalar::Scalar;

/// px.
const FOCAL: f64 = 500.0;

/// Rays all over wide images, some of them behind a turned pose; large and small disparities.
pub(super) fn batch<T: Scalar>(pixels: &[[f64; 4]]) -> Batch<T, 100> {
    let intrinsics = Intrinsics {
        focal: [T::lit(FOCAL); 2],
        principal: [T::lit(4000.0), T::lit(300.0)],
        size: [8000, 600],
    };
    let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
    let cameras = Cameras { left: camera, right: camera };
    let mut batch = Batch::new();
    for (i, [u, v, d, e]) in pixels.iter().enumerate() {
        let grid_step = if i % 3 == 0 { T::ZERO } else { T::lit(1.5) };
        let left = [T::lit(*u), T::lit(*v)];
        let right = [T::lit(u - d), T::lit(v + e)];
        let _ = batch.push(&cameras, &Correspondence { left, right, score: T::ONE, grid_step });
    }
    batch
}

/// A search at each of its stages, and a track.
pub(super) fn solvers<T: Scalar>(
    batch: &Batch<T, 100>,
    rotation: [f64; 3],
    t: [f64; 2],
) -> impl Iterator<Item = PairSolver<T>> {
    let start = pose(rotation, t).extrinsics().unwrap();
    let r = start.rotation().matrix().map(T::lit);
    let t = start.translation().map(T::lit);
    let start = RectifyingRotations::from(&Extrinsics::try_new(&r, &t).unwrap());
    let focal = T::lit(FOCAL);
    let mut search = PairSolver::search(&Config::robust(), focal, start, 12);
    let mut covariance = Symmetric5::ZERO;
    covariance.add_diagonal(T::lit(1e-6));
    let start_of_track = TrackStart { pose: start, covariance, noise: T::lit(0.4) };
    let track = PairSolver::track(&Config::robust(), focal, &start_of_track).unwrap();
    let stages: heapless::Vec<_, 12> = (0..9)
        .map(|_| {
            let at = search.clone();
            let _ = search.advance(batch.matches());
            at
        })
        .chain([track])
        .collect();
    stages.into_iter()
}
