//! The factory calibration of a ZED camera, `SN*.conf`.
//!
//! `R` has the rotation vector `(RX, CV, RZ)` of the resolution, rad, and `T = -(Baseline, TY, TZ)`, mm: the vendor's
//! programs hand both to `cv::stereoRectify`, for which the sign of `T` does not matter. Here the sign follows from the
//! side of the right camera. If there are sections `LEFT_DISTO` and `RIGHT_DISTO`, they have the lens of all modes; the
//! simpler lens in the sections of the modes is then ignored.

use anyhow::{Context, Result, ensure};
use nalgebra::{Rotation3, Vector3};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// Sections that tell the format.
#[rustfmt::skip]
pub(super) const MARKS: [&[&str]; 7] = [
    &["LEFT_CAM_HD"], &["LEFT_CAM_FHD"], &["LEFT_CAM_2K"], &["LEFT_CAM_VGA"], &["LEFT_CAM_FHD1200"], &["LEFT_CAM_SVGA"],
    &["STEREO"],
];

/// Sections by the size of an image, px.
const RESOLUTIONS: [(&str, [u16; 2]); 6] = [
    ("2K", [2208, 1242]),
    ("FHD", [1920, 1080]),
    ("FHD1200", [1920, 1200]),
    ("HD", [1280, 720]),
    ("SVGA", [960, 600]),
    ("VGA", [672, 376]),
];

/// Coefficients in OpenCV's order.
const COEFFICIENTS: [&str; 12] =
    ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"];

/// The rig of the requested resolution.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&MARKS.concat())?;
    let section = |side: &str, name: &str| file.get(&[format!("{side}_CAM_{name}").as_str()]);
    let there: Vec<&(&str, [u16; 2])> =
        RESOLUTIONS.iter().filter(|(name, _)| section("LEFT", name).is_some()).collect();
    ensure!(
        !there.is_empty(),
        "{}: there are no intrinsics of the left camera: expected LEFT_CAM_HD or another",
        file.place()
    );
    let wanted = unknowns.sizes.map(|[left, _]| left);
    let (name, size) = rig::of_size(&there, |(_, size)| *size, wanted, file.place())?;
    let side = |side: &str| -> Result<View> {
        let of = section(side, name).with_context(|| {
            format!(
                "{}: {side}_CAM_{name} is missing: expected the intrinsics of that mode",
                file.place()
            )
        })?;
        let lens = file.get(&[&format!("{side}_DISTO")]);
        view(&of, lens.as_ref().unwrap_or(&of), *size)
    };
    let stereo = file.need(&["STEREO"], "the extrinsics")?;
    let key = |axis: &str| format!("{axis}_{}", name.to_lowercase());
    let turn = stereo.numbers_or_0(&["rx", "cv", "rz"].map(key))?;
    let r = *Rotation3::new(Vector3::from_column_slice(&turn)).matrix();
    let shift = |axis: &str| stereo.get(&[&key(axis), axis]).map_or(Ok(0.0), |t| t.number());
    let t = -Vector3::new(stereo.number_at("baseline")?, shift("ty")?, shift("tz")?) / 1000.0;
    let pose = Pose::of(&Rigid { r, t }, &format!("{}: Baseline, TY, TZ", stereo.place()))?;
    rig::meta([side("LEFT")?, side("RIGHT")?], &pose, format!("ZED, {name}: {files}"))
}

/// A camera of a mode. Its lens is in the same section, or in a section for all modes.
fn view(of: &Value, lens: &Value, size: [u16; 2]) -> Result<View> {
    let given = lens.numbers_or_0(&COEFFICIENTS)?;
    ensure!(
        given[5] == 0.0 || given[6] != 0.0,
        lens.refuse("k4 without k5 is of a fisheye lens, whose conf is not read: write the numbers as K1 D1 K2 D2 R T")
    );
    View::try_new(
        of.numbers_at(["fx", "fy", "cx", "cy"])?,
        LensModel::RadialTangential,
        &given,
        size,
    )
    .map_err(|why| lens.refuse(why))
}
