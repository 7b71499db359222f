//! Rigs in the files of other tools, and, for OpenCV, Kalibr and ROS, out of them.
//!
//! Ours is `p_r = R p_l + t`, `|t| = 1`, and the length of the baseline beside it, in metres.
//!
//! | format | extrinsics | scale |
//! |---|---|---|
//! | OpenCV | `R`, `T` of `x_2 = R x_1 + T`, the left camera first | `\|T\|`, unit of the chessboard |
//! | Kalibr | `T_cn_cnm1` of cam1: points of cam0 to cam1, the left camera is cam0 | metres |
//! | `EuRoC` | `T_BS` of both: points of the camera to the body | metres |
//! | KITTI, Middlebury | rectified: `R = I`, `t = (-1, 0, 0)` | metres, millimetres |
//! | `RealSense`, Luxonis | left to right | metres, centimetres |
//! | ROS | `R = R_r^T R_l`, `t = -`(first row of `R_r`) of the rectification matrices | `P[0][3] = -fx b` of the right camera, metres |
//!
//! So `T`, the last column of `T_cn_cnm1` and `P[0][3]` are negative in x for a side-by-side rig. All
//! pixels have the centre of the top left one at `(0, 0)`. Numbers are written with the digits that
//! read back to the same bits: `R`, `K` and lens of OpenCV and Kalibr survive any number of journeys
//! unchanged, and so does `T` of a file (see `scale`). ROS has `R` and `t` only through products of
//! rotations, and keeps them to rounding. The apparent yaw of the lenses ([`Meta::LENS_YAW`]), which none of them has, is
//! the number `lens_yaw` of OpenCV's extrinsics.yml, and a comment in the files of Kalibr and ROS (left.yaml). A length of 1 stands for a baseline that is not known.

mod devices;
mod euroc;
mod files;
mod kalibr;
mod mat;
mod number;
mod opencv;
mod rectified;
mod rectified_sets;
mod rig;
mod ros;
mod scale;

use std::path::Path;

use anyhow::{Result, bail};
use clap::ValueEnum;
use stereo_selfcal::Extrinsics;

pub use files::{Document, Files};
pub use rig::Unknowns;

use host_tests::data::Meta;

/// Format of another tool.
#[expect(clippy::doc_markdown, reason = "doc comments of the variants are help text")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// FileStorage YAML as stereo_calib.cpp writes it: intrinsics.yml (M1 D1 M2 D2) and
    /// extrinsics.yml (R T R1 R2 P1 P2 Q). x_2 = R x_1 + T, first camera left; T.x is negative.
    Opencv,
    /// camchain.yaml: cam0 left, cam1 right; T_cn_cnm1 takes points of cam0 to cam1, in metres.
    Kalibr,
    /// left.yaml and right.yaml (camera_info): rectification matrices, and `P[0][3] = -fx b` of the
    /// right camera, b in metres.
    Ros,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Opencv, Self::Kalibr, Self::Ros];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Opencv => "opencv",
            Self::Kalibr => "kalibr",
            Self::Ros => "ros",
        }
    }

    /// The files of a rig, in this format. A baseline of unknown length is written as 1, with a
    /// comment.
    ///
    /// # Errors
    /// If the rig is not valid, or the format cannot express it.
    pub fn write(self, meta: &Meta) -> Result<Vec<Document>> {
        rig::check(meta)?;
        // As it will be read, so that derived numbers have the same bits.
        let (t, baseline_m) = scale::split(scale::scaled(meta.t, meta.baseline_m))?;
        let meta = Meta { t, baseline_m, ..meta.clone() };
        match self {
            Self::Opencv => opencv::write(&meta),
            Self::Kalibr => kalibr::write(&meta),
            Self::Ros => ros::write(&meta),
        }
    }
}

/// Format that a rig is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Written(Format),
    Euroc,
    Kitti,
    Middlebury,
    RealSense,
    Luxonis,
}

impl Source {
    /// Which format files are in, by their keys.
    fn of(files: &Files) -> Result<Self> {
        for (keys, format) in [
            (&["T_BS"][..], Self::Euroc),
            (&["P0", "P_rect_00"], Self::Kitti),
            // Middlebury's cam0 and cam1 have sizes beside them, Kalibr's within.
            (&["doffs", "ndisp"], Self::Middlebury),
            (&["cameraData"], Self::Luxonis),
            (&["extrinsics"], Self::RealSense),
            (&["cam0", "cam1"], Self::Written(Format::Kalibr)),
            (&["camera_matrix", "projection_matrix"], Self::Written(Format::Ros)),
            (&["M1", "K1", "R", "T"], Self::Written(Format::Opencv)),
        ] {
            if keys.iter().any(|key| files.have(key)) {
                return Ok(format);
            }
        }
        bail!(
            "{files}: neither OpenCV (M1, D1, M2, D2, R, T) nor Kalibr (cam0, cam1) nor ROS (camera_matrix, \
             projection_matrix) nor EuRoC (T_BS) nor KITTI (P0, P1) nor Middlebury (cam0=, doffs=) nor RealSense \
             (left, right, extrinsics) nor Luxonis (cameraData)"
        )
    }
}

/// The rig of one or more files, or of all YAML files of a folder; the format is told by the keys.
///
/// `unknowns`: values that the files may lack.
///
/// # Errors
/// Names the file, the key and the expected value.
pub fn import(places: &[impl AsRef<Path>], unknowns: Unknowns) -> Result<Meta> {
    rig_of(&Files::read(places)?, unknowns)
}

/// As [`import`], of files that are read already.
///
/// # Errors
/// As [`import`].
pub fn rig_of(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    match Source::of(files)? {
        Source::Written(Format::Opencv) => opencv::rig(files, unknowns),
        Source::Written(Format::Kalibr) => kalibr::rig(files, unknowns),
        Source::Written(Format::Ros) => ros::rig(files, unknowns),
        Source::Euroc => euroc::rig(files, unknowns),
        Source::Kitti => rectified_sets::kitti(files, unknowns),
        Source::Middlebury => rectified_sets::middlebury(files, unknowns),
        Source::RealSense => devices::realsense(files, unknowns),
        Source::Luxonis => devices::luxonis(files, unknowns),
    }
}

/// `R` and unit `t` alone: OpenCV's extrinsics.yml is enough.
///
/// # Errors
/// As [`import`].
pub fn import_extrinsics(place: &Path) -> Result<Extrinsics<f64>> {
    let files = Files::read(&[place])?;
    let pose = match Source::of(&files)? {
        Source::Written(Format::Opencv) => opencv::pose(&files),
        Source::Written(Format::Kalibr) => kalibr::pose(&files),
        Source::Written(Format::Ros) => ros::pose(&files),
        Source::Euroc => euroc::pose(&files),
        _ => return rig_of(&files, Unknowns::default())?.extrinsics(),
    };
    pose?.extrinsics()
}
