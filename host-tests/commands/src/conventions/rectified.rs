//! The rectified rig that OpenCV and ROS files carry beside the extrinsics.

use anyhow::{Context, Result};
use nalgebra::Rotation3;
use stereo_selfcal::{RectifiedCamera, RectifyingRotations};

use host_tests::data::Meta;
use host_tests::data::{Rows, rows};

/// Rotations into the rectified frame, and the camera both views share there.
pub(super) struct Rectified {
    /// `R_l`, `R_r`.
    pub(super) rotations: [Rows; 2],
    /// `[fx 0 cx 0; 0 fy cy 0; 0 0 1 0]`, and the same with `-fx b` in the first row's last place.
    pub(super) projections: [[f64; 12]; 2],
    /// Pixel and disparity to a point in the left rectified frame, homogeneous.
    pub(super) reprojection: [f64; 16],
}

impl Rectified {
    /// Every rectified pixel is seen by both cameras (alpha 0).
    pub(super) fn of(meta: &Meta) -> Result<Self> {
        let cameras = meta.cameras::<f64>()?;
        let rotations = RectifyingRotations::from(&meta.extrinsics::<f64>()?);
        let camera = RectifiedCamera::try_choose(&cameras, &rotations, 0.0).context(
            "no rectified camera can be chosen for this rig; the kalibr format needs none",
        )?;
        let baseline = meta.baseline_m.unwrap_or(1.0);
        let f = camera.focal;
        let [cx, cy] = camera.principal;
        let projection = |shift: f64| [f, 0.0, cx, shift, 0.0, f, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
        let in_rows = |r: &Rotation3<f64>| rows(r.matrix());
        Ok(Self {
            rotations: [in_rows(rotations.left()), in_rows(rotations.right())],
            projections: [projection(0.0), projection(-f * baseline)],
            #[rustfmt::skip]
            reprojection: [
                1.0, 0.0, 0.0, -cx,
                0.0, 1.0, 0.0, -cy,
                0.0, 0.0, 0.0, f,
                0.0, 0.0, 1.0 / baseline, 0.0,
            ],
        })
    }
}
