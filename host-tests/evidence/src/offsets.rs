//! Distances of points from their expected positions under an estimate: rows, and reprojections.

use stereo_selfcal::Extrinsics;
use stereo_selfcal::batch::{RayPair, row_offset};
use stereo_selfcal::geometry::RectifyingRotations;

use rigs::data::Rays;

/// RMS over points, at unit depth: times the focal length, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offsets {
    /// Vertical offset between the two rectified images. Infinite if the estimate puts a point behind a camera.
    pub row: f64,
    /// Distance of an image point from the reprojection of the space point that fits both image points best.
    pub reprojection: f64,
}

impl Offsets {
    /// Offsets of points under an estimate.
    #[must_use]
    pub fn of(estimate: &Extrinsics<f64>, points: impl Iterator<Item = Rays>) -> Self {
        let rotations = RectifyingRotations::from(estimate);
        let (mut count, mut rows, mut reprojections) = (0_u32, 0.0, 0.0);
        for rays in points {
            let [p_l, p_r] = rays;
            let pair = RayPair::try_new([p_l.x, p_l.y], [p_r.x, p_r.y]);
            let row = pair.and_then(|pair| row_offset(&rotations, &pair)).unwrap_or(f64::INFINITY);
            count += 1;
            rows += row * row;
            reprojections += reprojection(estimate, &rays);
        }
        let rms = |sum: f64, count: f64| (sum / count.max(1.0)).sqrt();
        let count = f64::from(count);
        Self { row: rms(rows, count), reprojection: rms(reprojections, 2.0 * count) }
    }
}

/// Sum of the squared distances in both images from the nearest pair of points that meet in space.
///
/// To first order in the distance (Sampson): `(p_r^T E p_l)^2 / |grad|^2`, `E = [t]x R`.
fn reprojection(estimate: &Extrinsics<f64>, [p_l, p_r]: &Rays) -> f64 {
    let e = estimate.translation().cross_matrix() * estimate.rotation().matrix();
    let (in_right, in_left) = (e * p_l, e.tr_mul(p_r));
    let gradient = in_right.xy().norm_squared() + in_left.xy().norm_squared();
    p_r.dot(&in_right).powi(2) / gradient
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Rotation3, Vector3};

    fn side_by_side(r: Matrix3<f64>) -> Extrinsics<f64> {
        Extrinsics::try_new(&r, &-Vector3::x()).unwrap()
    }

    #[test]
    fn true_points_are_in_their_rows_and_a_turn_about_x_lifts_them_by_its_angle() {
        let rays = [Vector3::new(0.1, 0.0, 1.0), Vector3::new(-0.1, 0.0, 1.0)];
        let truth = Offsets::of(&side_by_side(Matrix3::identity()), [rays].into_iter());
        assert!(truth.row < 1e-12 && truth.reprojection < 1e-12, "{truth:?}");
        let turn = Rotation3::new(Vector3::x() * 1e-3).into_inner();
        let off = Offsets::of(&side_by_side(turn), [rays].into_iter());
        assert!((off.row - 1e-3).abs() < 1e-6, "{off:?}");
        // Half of the offset is in each image.
        assert!((off.reprojection - 0.5e-3).abs() < 1e-6, "{off:?}");
    }
}
