//! `selfcal import`.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use crate::conventions::{self, Unknowns};
use anyhow::{Context, Result, ensure};
use clap::Args;

use super::parse::numbers;

/// Read the rig in the files of OpenCV, Kalibr or ROS, and write it as the meta.json of a data set,
/// for `selfcal replay FILE --rig meta.json` or a recording of your own.
///
/// Told by their keys: OpenCV's intrinsics.yml and extrinsics.yml (M1 D1 M2 D2 R T, also in one file),
/// where x_2 = R x_1 + T and the first camera is the left one; Kalibr's camchain.yaml, where T_cn_cnm1
/// takes points of cam0 (left) to cam1 (right); left.yaml and right.yaml of ROS, where R = R_r^T R_l and
/// t = -(first row of R_r) of the rectification matrices, and the right camera has `P[0][3] = -fx b`. So T,
/// t and `P[0][3]` are negative in x for a side-by-side rig.
///
/// Also: two sensor.yaml of EuRoC (left, right), calib.txt of KITTI or Middlebury, the calibration of a Luxonis
/// camera, and of a RealSense as JSON: rs2_intrinsics under left and right, rs2_extrinsics (left to right) under
/// extrinsics.
///
/// A baseline of 1 stands for one that is not known. Lenses: k1 k2 p1 p2 k3, with k4 k5 k6, or a fisheye of four.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal import intrinsics.yml extrinsics.yml --size 640,480 --unit 0.001 --out meta.json
  selfcal import camchain.yaml --out meta.json
  selfcal import camera_info/ --out meta.json")]
pub struct ImportArgs {
    /// The files of one rig; a folder stands for its *.yaml and *.yml.
    #[arg(required = true, value_name = "FILE|DIR")]
    files: Vec<PathBuf>,

    /// Size of the images, px; OpenCV's stereo_calib.cpp does not write it.
    #[arg(long, value_parser = numbers::<u16, 2>, value_name = "W,H")]
    size: Option<[u16; 2]>,

    /// Unit of OpenCV's T in metres: that of the chessboard's squares. 0.001 for mm.
    #[arg(long, default_value_t = 1.0, value_name = "M")]
    unit: f64,

    /// Where the rig goes; must not exist.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Runs `selfcal import`.
pub(crate) fn import(args: &ImportArgs) -> Result<()> {
    let out = args.out.display();
    ensure!(!args.out.exists(), "{out} exists: nothing is overwritten");
    let unknowns = Unknowns { size: args.size, unit_m: args.unit };
    let meta = conventions::import(&args.files, unknowns)?;
    let text = serde_json::to_string_pretty(&meta)?;
    fs::write(&args.out, text + "\n").with_context(|| format!("cannot write {out}"))?;
    let [x, y, z] = meta.t;
    let baseline = meta.baseline_m.map_or("not known".into(), |b| format!("{b} m"));
    writeln!(io::stdout(), "{out}: t = ({x:.4}, {y:.4}, {z:.4}), baseline {baseline}")?;
    Ok(())
}
