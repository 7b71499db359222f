//! Kalibr's `camchain.yaml` and `results-cam.txt`: pinhole cameras with radtan or equidistant lenses. `OpenVINS` uses
//! the same format.
//!
//! `T_cn_cnm1` of a camera takes points of the previous camera to it, in metres: `[R b t; 0 1]` for cam1 with cam0
//! left. Without it both cameras have `T_cam_imu` (IMU to camera), or `T_imu_cam` (camera to IMU). Kalibr's radtan is
//! `k1 k2 p1 p2`, without `k3`.

use std::fmt::Write;

use anyhow::{Result, bail, ensure};

use super::node::Value;
use super::number::list;
use super::rig::{self, NO_SCALE, Pose, Unknowns, View};
use super::rigid::Rigid;
use super::{Document, Files, scale};
use crate::data::{LensModel, Meta, Rows};

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let chain = files.one(&["cam0", "cam1"])?;
    let numbers = unknowns.cameras_or([0, 1]);
    let cams = numbers.map(|n| format!("cam{n}"));
    let of = |side: usize| chain.need(&[cams[side].as_str()], "a camera of the chain");
    let cams = [of(0)?, of(1)?];
    let pose = pose(&chain, &cams, numbers)?;
    let views = [view(&cams[0], 0, unknowns)?, view(&cams[1], 1, unknowns)?];
    rig::meta(views, &pose, format!("Kalibr: {files}"))
}

fn pose(chain: &Value, cams: &[Value; 2], [left, right]: [u8; 2]) -> Result<Pose> {
    // The transform along the chain, from the camera of the lower number to that of the higher one.
    let mut along = Some(Rigid::NONE);
    for n in left.min(right)..left.max(right) {
        let key = format!("cam{}", n + 1);
        let step = chain.get(&[key.as_str()]).and_then(|cam| cam.get(&["T_cn_cnm1"]));
        let step = step.map(|value| value.transform()).transpose()?;
        along = along.zip(step).map(|(so_far, step)| so_far.then(&step));
    }
    if let Some(along) = along {
        let way = if left < right { along } else { along.inverse() };
        return Pose::of(&way, &format!("{}: T_cn_cnm1", cams[1].place()));
    }
    let to_body = |cam: &Value| -> Result<Rigid> {
        match (cam.get(&["T_imu_cam"]), cam.get(&["T_cam_imu"])) {
            (Some(to_imu), _) => to_imu.transform(),
            (None, Some(from_imu)) => Ok(from_imu.transform()?.inverse()),
            _ => bail!(
                "{}: T_cn_cnm1 is missing, and {} has no T_cam_imu or T_imu_cam: expected one of them, 4 x 4 numbers",
                cams[1].place(),
                cam.place()
            ),
        }
    };
    // Reads the right camera first, so that an error names it: if `T_cn_cnm1` is missing, that camera lacks it.
    let right = to_body(&cams[1])?;
    let way = Rigid::left_to_right([to_body(&cams[0])?, right]);
    Pose::of(&way, &format!("{}: T_imu_cam or T_cam_imu", cams[1].place()))
}

fn view(cam: &Value, side: usize, unknowns: Unknowns) -> Result<View> {
    if let Some(model) = cam.get(&["camera_model"]).filter(|model| model.text() != "pinhole") {
        bail!(model.refuse(
            "expected pinhole, not omni, eucm or ds: calibrate with pinhole-radtan or pinhole-equi"
        ));
    }
    let lens = rig::lens_at(cam, &["distortion_model"])?;
    let given = cam.need(&["intrinsics"], "fu fv pu pv")?;
    given.array::<4>("fu fv pu pv")?;
    let k = rig::intrinsics(&given)?;
    let size = cam.get(&["resolution"]).map(|size| size.size()).transpose()?;
    let size = unknowns.size(side, size, cam.place())?;
    View::of(k, lens, cam.get(&["distortion_coeffs"]).as_ref(), size)
}

/// `camchain.yaml`.
pub(super) fn write(meta: &Meta) -> Result<Vec<Document>> {
    let mut text = String::from("# T_cn_cnm1: points of cam0 (left) to cam1 (right), metres.\n");
    if meta.baseline_m.is_none() {
        text.push_str(NO_SCALE);
    }
    text.push_str(&rig::lens_yaw_comment(meta));
    let ([lens_l, lens_r], [size_l, size_r]) = (meta.lenses(), meta.sizes());
    text.push_str(&cam("cam0", lens_l, size_l, &meta.k_l, &meta.dist_l)?);
    text.push_str(&cam("cam1", lens_r, size_r, &meta.k_r, &meta.dist_r)?);
    text.push_str("  T_cn_cnm1:\n");
    let scaled = scale::scaled(meta.t, meta.baseline_m);
    for ([x, y, z], t) in meta.r.into_iter().zip(scaled) {
        writeln!(text, "  - [{}]", list(&[x, y, z, t]))?;
    }
    writeln!(text, "  - [{}]", list(&[0.0, 0.0, 0.0, 1.0]))?;
    Ok(vec![Document { name: "camchain.yaml", text }])
}

fn cam(name: &str, lens: LensModel, size: [u16; 2], k: &Rows, dist: &[f64]) -> Result<String> {
    let (model, coefficients) = match lens {
        LensModel::Fisheye => ("equidistant", dist),
        LensModel::Rational => {
            bail!("{name} has a rational lens, which Kalibr lacks: use opencv or ros")
        }
        LensModel::RadialTangential => {
            let (four, k3) = dist.split_at(dist.len().min(4));
            ensure!(
                k3.iter().all(|&k| k == 0.0),
                "{name} has a lens coefficient k3, which Kalibr's radtan lacks: use opencv or ros"
            );
            ("radtan", four)
        }
    };
    let [[fx, _, cx], [_, fy, cy], _] = k;
    let [width, height] = size;
    let mut text = format!("{name}:\n  cam_overlaps: [{}]\n", u8::from(name == "cam0"));
    writeln!(text, "  camera_model: pinhole\n  distortion_model: {model}")?;
    writeln!(text, "  distortion_coeffs: [{}]", list(coefficients))?;
    writeln!(text, "  intrinsics: [{}]", list(&[*fx, *fy, *cx, *cy]))?;
    writeln!(text, "  resolution: [{width}, {height}]")?;
    writeln!(text, "  rostopic: /{name}/image_raw")?;
    Ok(text)
}
