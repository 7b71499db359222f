//! The rectified rig that OpenCV and ROS files carry beside the extrinsics.
//!
//! The rectified frame is as upright as the left camera: if the cameras are above each other, the baseline is along its
//! y, as in `cv::stereoRectify` and ROS. A fisheye image too wide for a plane is rectified in part.

use anyhow::{Context, Result, ensure};
use nalgebra::{Rotation3, Vector2, Vector3};
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};
use stereo_selfcal::{Camera, Cameras};

use crate::data::{Meta, QuarterTurns, Rows, rows};

/// Horizontal fields of view, in multiples of [`FIELD_STEP`]. If a whole image cannot be rectified, they are tried from
/// the widest to the narrowest.
const FIELDS: std::ops::RangeInclusive<u16> = 8..=30;

/// Step between two fields, degrees.
const FIELD_STEP: u16 = 5;

/// Number of parts of each border between the points that must be seen.
const BORDER: u16 = 16;

/// Rotations into the rectified frame, and the common camera of both views there.
pub(super) struct Rectified {
    /// `R_l`, `R_r`.
    pub(super) rotations: [Rows; 2],
    /// `[fx 0 cx 0; 0 fy cy 0; 0 0 1 0]`, and the same with `-fx b` at the end of the first row; for cameras above each
    /// other with `-fy b` at the end of the second row.
    pub(super) projections: [[f64; 12]; 2],
    /// Pixel and disparity to a point in the left rectified frame, homogeneous.
    pub(super) reprojection: [f64; 16],
}

impl Rectified {
    /// The rectified rig.
    ///
    /// * `field_deg`: field of view of the wanted part across the left image, which the cameras need not see in full.
    ///   `None`: both cameras see every rectified pixel (alpha 0). If that is too wide for a plane: the widest part
    ///   that both see.
    pub(super) fn of(meta: &Meta, field_deg: Option<f64>) -> Result<Self> {
        let turns = QuarterTurns::upright(meta);
        let upright = if turns.is_none() { meta.clone() } else { turns.meta(meta) };
        let cameras = upright.cameras::<f64>()?;
        let rotations = RectifyingRotations::from(&upright.extrinsics::<f64>()?);
        let camera = chosen(&cameras, &rotations, field_deg)?;
        let back = turns.rotation(0).transpose();
        let in_rows = |side: usize, r: &Rotation3<f64>| {
            if turns.is_none() {
                rows(r.matrix())
            } else {
                rows(&(back * r.matrix() * turns.rotation(side)))
            }
        };
        let size = meta.sizes()[0];
        let [cx, cy] = turns.pixel_back(0, size, camera.principal);
        let baseline = meta.baseline_m.unwrap_or(1.0);
        let f = camera.focal;
        // The vector from left to right in the rectified frame, m.
        let along = back * Vector3::x() * baseline;
        let projection = |x: f64, y: f64| [f, 0.0, cx, x, 0.0, f, cy, y, 0.0, 0.0, 1.0, 0.0];
        let shift = [along.x, along.y].map(|b| if b == 0.0 { 0.0 } else { -f * b });
        Ok(Self {
            rotations: [in_rows(0, rotations.left()), in_rows(1, rotations.right())],
            projections: [projection(0.0, 0.0), projection(shift[0], shift[1])],
            #[rustfmt::skip]
            reprojection: [
                1.0, 0.0, 0.0, -cx,
                0.0, 1.0, 0.0, -cy,
                0.0, 0.0, 0.0, f,
                0.0, 0.0, 1.0 / (along.x + along.y), 0.0,
            ],
        })
    }
}

fn chosen(
    cameras: &Cameras<f64>,
    rotations: &RectifyingRotations<f64>,
    field_deg: Option<f64>,
) -> Result<RectifiedCamera<f64>> {
    if let Some(field) = field_deg {
        ensure!(
            (1.0..=170.0).contains(&field),
            "--field {field}: a field of view from 1 to 170 degrees can be rectified"
        );
        return Ok(of_field(cameras, field));
    }
    let whole = RectifiedCamera::try_choose(cameras, rotations, 0.0);
    let Err(why) = whole else { return Ok(whole?) };
    let mut fields = FIELDS.rev().map(|n| of_field(cameras, f64::from(n * FIELD_STEP)));
    fields.find(|part| is_seen(cameras, rotations, part)).with_context(|| {
        format!("no rectified camera can be chosen for this rig: {why}; choose a part (--field DEGREES), or the kalibr format, which needs no rectified camera")
    })
}

/// The part with this field of view across an image of the left camera's size, with the principal point in the middle.
fn of_field(cameras: &Cameras<f64>, degrees: f64) -> RectifiedCamera<f64> {
    let last = cameras.left.intrinsics().size.map(|n| f64::from(n) - 1.0);
    let focal = last[0] / 2.0 / (degrees.to_radians() / 2.0).tan();
    RectifiedCamera { focal, principal: last.map(|x| x / 2.0) }
}

/// Whether both cameras see the whole border of a part.
fn is_seen(
    cameras: &Cameras<f64>,
    rotations: &RectifyingRotations<f64>,
    part: &RectifiedCamera<f64>,
) -> bool {
    let last = cameras.left.intrinsics().size.map(|n| f64::from(n) - 1.0);
    let [cx, cy] = part.principal;
    let sees = |camera: &Camera<f64>, rotation: &Rotation3<f64>, [u, v]: [f64; 2]| {
        let ray =
            rotation.inverse() * Vector3::new((u - cx) / part.focal, (v - cy) / part.focal, 1.0);
        let [width, height] = camera.intrinsics().size.map(|n| f64::from(n) - 1.0);
        ray.z > 0.0
            && camera
                .pixel(Vector2::new(ray.x / ray.z, ray.y / ray.z))
                .is_ok_and(|[u, v]| (0.0..=width).contains(&u) && (0.0..=height).contains(&v))
    };
    (0..=BORDER).all(|i| {
        let share = f64::from(i) / f64::from(BORDER);
        let [u, v] = last.map(|x| x * share);
        [[u, 0.0], [u, last[1]], [0.0, v], [last[0], v]].iter().all(|at| {
            sees(&cameras.left, rotations.left(), *at)
                && sees(&cameras.right, rotations.right(), *at)
        })
    })
}
