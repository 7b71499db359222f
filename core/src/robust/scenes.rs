//! What the forms of a pass are compared on.

use super::{Descent, Known};
use crate::batch::Batch;
use crate::camera::{Camera, Intrinsics, Lens};
use crate::config::Config;
use crate::correspondence::{Cameras, Correspondence};
use crate::extrinsics::Extrinsics;
use crate::rectification::RectifyingRotations;
use crate::residual::tests::pose;
use crate::scalar::Scalar;
use crate::symmetric::Symmetric;

/// px.
const FOCAL: f64 = 500.0;

/// Seen all over wide images, so that some rays fall behind a turned pose; near each other and far.
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
pub(super) fn descents<T: Scalar>(
    batch: &Batch<T, 100>,
    rotation: [f64; 3],
    t: [f64; 2],
) -> impl Iterator<Item = Descent<T>> {
    let start = pose(rotation, t).extrinsics().unwrap();
    let r = start.rotation().matrix().map(T::lit);
    let t = start.translation().map(T::lit);
    let start = RectifyingRotations::from(&Extrinsics::try_new(&r, &t).unwrap());
    let focal = T::lit(FOCAL);
    let mut search = Descent::search(&Config::robust(), focal, start, 12);
    let mut covariance = Symmetric::ZERO;
    covariance.add_diagonal(T::lit(1e-6));
    let known = Known { pose: start, covariance, noise: T::lit(0.4) };
    let track = Descent::track(&Config::robust(), focal, &known).unwrap();
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
