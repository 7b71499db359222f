//! OpenCV's `FileStorage`, as the sample `stereo_calib.cpp` writes it in YAML, XML or JSON, and the same matrices as
//! plain lists under common names.
//!
//! `x_2 = R x_1 + T` with the left camera first (`cv::stereoCalibrate`): our convention except for the length of `T`.
//! Image size and `fisheye_model` are the keys of the sample `camera_calibration.cpp`. Without `R` the rectification
//! `R1 R2 P2` has the extrinsics, as in ROS.

use std::fmt::Write;

use anyhow::{Result, anyhow, bail, ensure};

use super::node::Value;
use super::number::list as numbers;
use super::rectified::Rectified;
use super::rig::{self, LENS_YAW, NO_SCALE, Pose, Unknowns, View};
use super::rigid::Rigid;
use super::{Document, Files, named, scale};
use crate::data::{LensModel, Meta, WrongSign};

/// Keys that tell the format: those of `stereo_calib.cpp`, or a name of the left camera matrix in a file of lists.
#[rustfmt::skip]
pub(super) const MARKS: [&[&str]; 10] = [
    &["M1"], &["M2"], &["R", "T"], &["R1", "P1"], &["R2", "P2"], &["K1"], &["cameraMatrix1"], &["camera_matrix_left"],
    &["K_left"], &["K_l"],
];

/// Names of the camera matrices, left and right.
#[rustfmt::skip]
const K: [&[&str]; 2] = [
    &["M1", "K1", "cameraMatrix1", "camera_matrix_1", "camera_matrix1", "camera_matrix_left", "left_camera_matrix",
      "K_left", "K_l", "KL", "Kl", "mtxL", "mtx_l", "M_left"],
    &["M2", "K2", "cameraMatrix2", "camera_matrix_2", "camera_matrix2", "camera_matrix_right", "right_camera_matrix",
      "K_right", "K_r", "KR", "Kr", "mtxR", "mtx_r", "M_right"],
];

/// Names of the lens coefficients, left and right.
#[rustfmt::skip]
const D: [&[&str]; 2] = [
    &["D1", "distCoeffs1", "dist_coeffs_1", "dist_coeffs1", "distCoeffsLeft", "dist_coeffs_left", "distortion_left",
      "dist_left", "D_left", "D_l", "DL", "Dl", "dist_l", "distL"],
    &["D2", "distCoeffs2", "dist_coeffs_2", "dist_coeffs2", "distCoeffsRight", "dist_coeffs_right", "distortion_right",
      "dist_right", "D_right", "D_r", "DR", "Dr", "dist_r", "distR"],
];

const R: &[&str] = &["R", "rotation", "rotation_matrix"];
const T: &[&str] = &["T", "t", "translation", "translation_vector"];

/// Keys of the width of the images, left and right: the right images may have a key of their own.
#[rustfmt::skip]
const WIDTH: [&[&str]; 2] =
    [&["image_width", "width", "ImageWidth", "imageWidth"], &["image_width_2", "image_width", "width", "ImageWidth", "imageWidth"]];
#[rustfmt::skip]
const HEIGHT: [&[&str]; 2] =
    [&["image_height", "height", "ImageHeight", "imageHeight"], &["image_height_2", "image_height", "height", "ImageHeight", "imageHeight"]];
const SIZE: &[&str] = &["image_size", "imageSize", "size", "img_size", "resolution"];

/// * `exchanged`: whether the first camera is the right one.
fn pose(files: &Files, exchanged: bool) -> Result<Pose> {
    let (rigid, place) = if let (None, Some(right)) = (files.get(R), files.get(&["R2"])) {
        of_rectification(files, &right)?
    } else {
        let r = rig::rotation(&files.find(R, "R (3 x 3)")?)?;
        let t = files.find(T, "T (3 x 1)")?;
        (Rigid { r, t: t.array::<3>("T (3 x 1)")?.into() }, t.place().to_owned())
    };
    let pose = Pose::of(&if exchanged { rigid.inverse() } else { rigid }, &place);
    pose.map_err(|why| match why.downcast_ref::<WrongSign>() {
        Some(_) => anyhow!("{why:#} (--cameras 1,0)"),
        None => why,
    })
}

/// `R` and `T` of the rectification `R1 R2 P2`, if `R` is missing.
fn of_rectification(files: &Files, right: &Value) -> Result<(Rigid, String)> {
    let r = [rig::rotation(&files.find(&["R1"], "R1 (3 x 3)")?)?, rig::rotation(right)?];
    let p = files.find(&["P2"], "P2 (3 x 4), or R and T")?;
    let [fx, _, _, x, _, fy, _, y, ..] = p.shaped::<12>(3, 4)?;
    ensure!(fx > 0.0 && fy > 0.0, p.refuse("expected fx and fy above 0"));
    let rigid = rig::of_rectification([&r[0], &r[1]], [-x / fx, -y / fy]);
    Ok((rigid, p.place().to_owned()))
}

/// `R` and `T` of files without cameras; `None` for other files.
pub(super) fn pose_alone(files: &Files) -> Option<Result<Pose>> {
    let alone =
        files.get(K[0]).is_none() && files.get(&["R"]).is_some() && files.get(&["T"]).is_some();
    alone.then(|| pose(files, false))
}

/// The lens of both cameras; `None` if no key names it.
pub(super) fn lens(files: &Files) -> Result<Option<LensModel>> {
    let says_fisheye = files.get(&["fisheye_model", "fisheye", "is_fisheye"]).map(|value| {
        let no = matches!(value.text().to_lowercase().as_str(), "0" | "false" | "no");
        if no { LensModel::RadialTangential } else { LensModel::Fisheye }
    });
    // The other keys may as well name a product.
    let named = files.values().map(|file| -> Result<Option<LensModel>> {
        if file.get(&["distortion_model"]).is_some() {
            return rig::lens_at(&file, &["distortion_model"]).map(Some);
        }
        let keys = ["lens_model", "camera_model", "model_type", "model", "lens"];
        Ok(file.get(&keys).and_then(|_| rig::lens_at(&file, &keys).ok()))
    });
    let named: Vec<LensModel> = named.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    let is_fisheye = named.contains(&LensModel::Fisheye);
    Ok(if is_fisheye { Some(LensModel::Fisheye) } else { says_fisheye.or(named.first().copied()) })
}

/// The whole rig; `--cameras 1,0` exchanges left and right.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    // The cameras may be numbered from 0.
    let from_0: [[&[&str]; 2]; 2] = [[&["K0"], &["K1"]], [&["D0"], &["D1"]]];
    let [k, d] = if files.get(&["K0"]).is_some() { from_0 } else { [K, D] };
    let exchanged = unknowns.are_exchanged(files)?;
    // Names that are not known may have words that are.
    if files.get(k[0]).is_none()
        && let Some(rig) = named::rig(files, unknowns)
    {
        return rig;
    }
    let named = lens(files)?;
    let lens = named.unwrap_or(LensModel::RadialTangential);
    let size = |side: usize| -> Result<[u16; 2]> {
        let own = match (files.get(WIDTH[side]), files.get(HEIGHT[side]), files.get(SIZE)) {
            (Some(width), Some(height), _) => Some([width.count()?, height.count()?]),
            (_, _, Some(both)) => Some(both.size()?),
            _ => None,
        };
        unknowns.size(
            side ^ usize::from(exchanged),
            own,
            &format!("{files}: no image_width and image_height"),
        )
    };
    let mut is_unnamed = named.is_none();
    let mut view = |side: usize| -> Result<View> {
        let intrinsics = rig::intrinsics(&files.find(k[side], "a camera matrix (3 x 3)")?)?;
        let given = files.find(d[side], "lens coefficients (1 x 5)")?;
        is_unnamed &= given.numbers()?.len() == 4;
        View::of(intrinsics, lens, Some(&given), size(side)?)
    };
    let mut views = [view(0)?, view(1)?];
    if exchanged {
        views.reverse();
    }
    let pose = pose(files, exchanged)?.in_unit(unknowns.unit_m)?;
    let mut meta = rig::meta(views, &pose, format!("OpenCV: {files}"))?;
    if is_unnamed {
        meta.other.insert(Meta::UNNAMED_LENS.to_owned(), true.into());
    }
    Ok(meta)
}

/// `intrinsics.yml` and `extrinsics.yml`.
pub(super) fn write(meta: &Meta, field_deg: Option<f64>) -> Result<Vec<Document>> {
    let rectified = Rectified::of(meta, field_deg)?;
    let (lenses, sizes) = (meta.lenses(), meta.sizes());
    let fisheyes = lenses.map(|lens| lens == LensModel::Fisheye);
    if fisheyes[0] != fisheyes[1] {
        bail!(
            "one camera is a fisheye and the other is not, which a file of OpenCV cannot express: use kalibr or ros"
        );
    }
    let mut intrinsics = String::from("%YAML:1.0\n---\n");
    let [width, height] = sizes[0];
    writeln!(intrinsics, "image_width: {width}\nimage_height: {height}")?;
    if sizes[0] != sizes[1] {
        let [width, height] = sizes[1];
        writeln!(intrinsics, "image_width_2: {width}\nimage_height_2: {height}")?;
    }
    writeln!(intrinsics, "fisheye_model: {}", u8::from(fisheyes[0]))?;
    for (m, k, d, dist) in
        [("M1", &meta.k_l, "D1", &meta.dist_l), ("M2", &meta.k_r, "D2", &meta.dist_r)]
    {
        intrinsics.push_str(&mat(m, 3, &k.concat()));
        intrinsics.push_str(&mat(d, dist.len(), dist));
    }
    let mut extrinsics = String::from("%YAML:1.0\n---\n");
    extrinsics.push_str("# x_2 = R x_1 + T, the left camera is the first; T in metres.\n");
    if meta.baseline_m.is_none() {
        extrinsics.push_str(NO_SCALE);
    }
    let [r1, r2] = rectified.rotations;
    let [p1, p2] = rectified.projections;
    extrinsics.push_str(&mat("R", 3, &meta.r.concat()));
    extrinsics.push_str(&mat("T", 1, &scale::scaled(meta.t, meta.baseline_m)));
    extrinsics.push_str(&mat("R1", 3, &r1.concat()));
    extrinsics.push_str(&mat("R2", 3, &r2.concat()));
    extrinsics.push_str(&mat("P1", 4, &p1));
    extrinsics.push_str(&mat("P2", 4, &p2));
    extrinsics.push_str(&mat("Q", 4, &rectified.reprojection));
    if let Some(a) = meta.lens_yaw() {
        writeln!(extrinsics, "{LENS_YAW}lens_yaw: {a:?}")?;
    }
    Ok(vec![
        Document { name: "intrinsics.yml", text: intrinsics },
        Document { name: "extrinsics.yml", text: extrinsics },
    ])
}

/// A matrix of `cols` columns.
fn mat(name: &str, cols: usize, all: &[f64]) -> String {
    let rows = all.len() / cols;
    let lines: Vec<String> = all.chunks(cols).map(numbers).collect();
    let data = lines.join(",\n       ");
    format!(
        "{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {data} ]\n"
    )
}
