//! `EuRoC`'s `sensor.yaml` of two cameras, in the order left, right.
//!
//! `T_BS` takes points of the camera to the body, in metres: `R = R_r^T R_l`, `b t = R_r^T (t_l - t_r)`.

use anyhow::{Result, bail};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::Meta;

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let sensors = files.with(&["T_BS"]);
    let [left, right] = sensors.as_slice() else {
        bail!("{files}: expected two sensor.yaml, cam0 (left) and cam1, not {}", sensors.len());
    };
    let to_body = |sensor: &Value| sensor.need(&["T_BS"], "4 x 4 numbers")?.transform();
    let way = Rigid::left_to_right([to_body(left)?, to_body(right)?]);
    let pose = Pose::of(&way, &format!("{} and {}: T_BS", left.place(), right.place()))?;
    rig::meta(
        [view(left, 0, unknowns)?, view(right, 1, unknowns)?],
        &pose,
        format!("EuRoC: {files}"),
    )
}

fn view(sensor: &Value, side: usize, unknowns: Unknowns) -> Result<View> {
    if let Some(model) = sensor.get(&["camera_model"]).filter(|model| model.text() != "pinhole") {
        bail!(model.refuse("expected pinhole: calibrate with it"));
    }
    let lens = rig::lens_at(sensor, &["distortion_model"])?;
    let given = sensor.need(&["intrinsics"], "fu fv cu cv")?;
    given.array::<4>("fu fv cu cv")?;
    let k = rig::intrinsics(&given)?;
    let size = sensor.get(&["resolution"]).map(|size| size.size()).transpose()?;
    let size = unknowns.size(side, size, sensor.place())?;
    View::of(k, lens, sensor.get(&["distortion_coefficients"]).as_ref(), size)
}
