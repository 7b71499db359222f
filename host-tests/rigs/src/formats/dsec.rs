//! DSEC's `cam_to_cam.yaml`: cameras under `intrinsics`, and under `extrinsics` the chain `T_10`, `T_21`, ..., each of
//! which takes points of a camera to the next one, in metres.

use anyhow::Result;

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::Meta;

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["extrinsics"])?;
    let chain = file.need(&["extrinsics"], "the transforms of the chain")?;
    let intrinsics = file.need(&["intrinsics"], "the cameras")?;
    let numbers: Vec<u8> =
        (0..=9).filter(|n| intrinsics.get(&[&format!("cam{n}")]).is_some()).collect();
    let [left, right] = rig::two(&numbers, unknowns, intrinsics.place())?.map(|n| *n);
    let mut way = Rigid::NONE;
    for n in left.min(right)..left.max(right) {
        let key = format!("T_{}{n}", n + 1);
        let step = chain.need(&[&key], "4 x 4 numbers: from each camera to the next")?;
        way = way.then(&step.transform()?);
    }
    let way = if left < right { way } else { way.inverse() };
    let pose = Pose::of(&way, &format!("{}, cameras {left} and {right}", chain.place()))?;
    let view = |side: usize, n: u8| -> Result<View> {
        let camera = intrinsics.need(&[&format!("cam{n}")], "a camera")?;
        view(&camera, side, unknowns)
    };
    rig::meta(
        [view(0, left)?, view(1, right)?],
        &pose,
        format!("DSEC, cameras {left} and {right}: {files}"),
    )
}

fn view(camera: &Value, side: usize, unknowns: Unknowns) -> Result<View> {
    let lens = rig::lens_at(camera, &["distortion_model"])?;
    let k = rig::intrinsics(&camera.need(&["camera_matrix"], "fx fy cx cy")?)?;
    let size = camera.get(&["resolution"]).map(|size| size.size()).transpose()?;
    let size = unknowns.size(side, size, camera.place())?;
    View::of(k, lens, camera.get(&["distortion_coeffs"]).as_ref(), size)
}
