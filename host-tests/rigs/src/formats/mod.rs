//! Reads rigs from files of other tools, and writes rigs as files of OpenCV, Kalibr and ROS.
//!
//! Our convention is `p_r = R p_l + t`, `|t| = 1`, with the length of the baseline beside it, in metres. The table in
//! `table` has the formats that are read and the convention of each.
//!
//! `T`, the last column of `T_cn_cnm1` and `P[0][3]` are negative in x for a side-by-side rig. The centre of the top
//! left pixel is at `(0, 0)`. Numbers are written with the digits that read back to the same bits: `R`, `K` and lens of
//! OpenCV and Kalibr survive any number of round trips unchanged, and so does `T` of a file (see `scale`). ROS has `R`
//! and `t` only through products of rotations, and keeps them to rounding. None of the formats has the apparent yaw of
//! the lenses ([`Meta::LENS_YAW`]): it is written as the number `lens_yaw` of OpenCV's extrinsics.yml, and as a comment
//! in the files of Kalibr and ROS (left.yaml). A length of 1 stands for an unknown baseline.

mod bare;
mod basalt;
mod bouguet;
mod camera_list;
mod colmap;
mod dsec;
mod euroc;
mod files;
mod ini_sets;
mod kalibr;
mod luxonis;
mod mc_calib;
mod models;
mod mynt;
mod named;
mod node;
mod number;
mod opencv;
mod orbslam;
mod printed;
mod realsense;
mod rectified;
mod rectified_sets;
mod rig;
mod rigid;
mod ros;
mod scale;
mod syntax;
mod table;
mod vins;
mod zed;

use std::path::Path;

use anyhow::Result;
use stereo_selfcal::Extrinsics;
use strum::{Display, EnumMessage, EnumString, VariantArray};

pub use files::{Document, Files};
pub use rig::Unknowns;
pub use table::list;

use crate::data::Meta;

/// Format of another tool.
#[expect(clippy::doc_markdown, reason = "doc comments of the variants are help text")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Display, EnumMessage, EnumString, VariantArray)]
#[strum(serialize_all = "kebab-case")]
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
    /// All formats.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// The files of a rig, in this format. A baseline of unknown length is written as 1, with a
    /// comment.
    ///
    /// # Errors
    /// If the rig is not valid, or the format cannot express it.
    pub fn write(self, meta: &Meta) -> Result<Vec<Document>> {
        self.write_part(meta, None)
    }

    /// As [`Format::write`]; the rectified camera of OpenCV and ROS sees the part of the images with this field of view
    /// across, degrees.
    pub fn write_part(self, meta: &Meta, field_deg: Option<f64>) -> Result<Vec<Document>> {
        rig::check(meta)?;
        // The rig as it will be read back, so that derived numbers have the same bits.
        let (t, baseline_m) = scale::split(scale::scaled(meta.t, meta.baseline_m))?;
        let meta = Meta { t, baseline_m, ..meta.clone() };
        match self {
            Self::Opencv => opencv::write(&meta, field_deg),
            Self::Kalibr => kalibr::write(&meta),
            Self::Ros => ros::write(&meta, field_deg),
        }
    }
}

/// The rig of one or more files, or of all rig files of a folder; the keys tell the format.
///
/// `unknowns`: values that the files may lack.
///
/// # Errors
/// Names the file, the key and the expected value.
pub fn import(places: &[impl AsRef<Path>], unknowns: Unknowns) -> Result<Meta> {
    rig_of(&Files::read(places)?, unknowns)
}

/// As [`import`], for files in memory.
pub fn rig_of(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    table::rig(files, unknowns)
}

/// The rig of the rectified images of two `camera_info`: `P` is the camera, without distortion or turn.
pub fn rig_of_rectified(files: &Files) -> Result<Meta> {
    ros::of_rectified(files)
}

/// `R` and unit `t` alone: OpenCV's extrinsics.yml is enough.
pub fn import_extrinsics(place: &Path) -> Result<Extrinsics<f64>> {
    let files = Files::read(&[place])?;
    match opencv::pose_alone(&files) {
        Some(pose) => pose?.extrinsics(),
        None => rig_of(&files, Unknowns::default())?.extrinsics(),
    }
}
