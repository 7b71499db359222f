//! Rotations, rectification and metrics.

use core::hint::black_box;

use nalgebra::{Matrix3, Vector3};
use stereo_selfcal::batch::{RayPair, row_offset};
use stereo_selfcal::geometry::metrics::{
    Deviation, baseline_angle, rotation_angle, rotation_distance,
};
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations, so3};
use stereo_selfcal::{Cameras, Extrinsics};

use crate::{number, numbers, show};

pub(crate) fn extrinsics() -> Option<Extrinsics<f32>> {
    let rotation = so3::exp(&Vector3::from(numbers()))?;
    show(so3::log(&rotation));
    let columns = [numbers(), numbers(), numbers()].map(Vector3::from);
    show(so3::nearest_rotation(&Matrix3::from_columns(&columns)));
    show(Extrinsics::from_row_major(numbers(), numbers()).map_err(|error| error.code()));
    Extrinsics::try_new(rotation.matrix(), &Vector3::from(numbers())).ok()
}

pub(crate) fn all(cameras: &Cameras<f32>) {
    if let Some((a, b)) = extrinsics().zip(extrinsics()) {
        metrics(&a, &b);
        rectification(&a, &b, cameras);
    }
}

fn metrics(a: &Extrinsics<f32>, b: &Extrinsics<f32>) {
    show(a.rotation_row_major());
    show(baseline_angle(a.translation(), b.translation()));
    show(rotation_distance(a.rotation(), b.rotation()));
    show(rotation_angle(a.rotation(), b.rotation()));
    let deviation = Deviation::between(a, b);
    show(Deviation::root_mean_square(black_box([deviation; 2])));
}

fn rectification(a: &Extrinsics<f32>, b: &Extrinsics<f32>, cameras: &Cameras<f32>) {
    let [rotations, others] = [a, b].map(RectifyingRotations::from);
    show(rotations.left());
    show(rotations.right());
    show(rotations.extrinsics());
    show(rotations.unknowns_to(&others));
    if let Some(pair) = RayPair::try_new(numbers(), numbers()) {
        show(row_offset(&rotations, &pair));
    }
    if let Ok(camera) = RectifiedCamera::try_choose(cameras, &rotations, number()) {
        show(camera.matrix());
        show(camera.homographies(cameras, &rotations));
    }
}
