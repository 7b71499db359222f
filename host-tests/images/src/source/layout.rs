//! Folders of known layouts: `EuRoC`, KITTI, Middlebury, and plain left and right.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use super::folders::images;

/// What was found in a folder.
#[derive(Debug)]
pub(super) struct Layout {
    /// Left and right images, each in the order of names.
    pub(super) sides: [Vec<PathBuf>; 2],
    /// Files of its calibration; may be none.
    pub(super) rig: Vec<PathBuf>,
}

/// Folders of left and right images, from the top of a data set.
const FOLDERS: [[&str; 2]; 8] = [
    ["mav0/cam0/data", "mav0/cam1/data"],
    ["cam0/data", "cam1/data"],
    ["image_0", "image_1"],
    ["image_00/data", "image_01/data"],
    ["image_00", "image_01"],
    ["left", "right"],
    ["cam0", "cam1"],
    ["image_left", "image_right"],
];

/// Files of one pair, or of many, in one folder.
const FILES: [[&str; 2]; 5] = [
    ["im0.*", "im1.*"],
    ["view1.*", "view5.*"],
    ["left*", "right*"],
    ["*_left.*", "*_right.*"],
    ["*_l.*", "*_r.*"],
];

/// Files of a calibration, from the top of a data set; all of a row.
const RIGS: [&[&str]; 7] = [
    &["mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml"],
    &["cam0/sensor.yaml", "cam1/sensor.yaml"],
    &["calib.txt"],
    &["../calib_cam_to_cam.txt"],
    &["camchain.yaml"],
    &["intrinsics.yml", "extrinsics.yml"],
    &["left.yaml", "right.yaml"],
];

impl Layout {
    pub(super) fn of(top: &Path) -> Result<Self> {
        let sides = sides(top)?;
        let meta = top.join("meta.json");
        let rig = if meta.is_file() {
            vec![meta]
        } else {
            let paths = |names: &[&str]| names.iter().map(|name| top.join(name)).collect();
            let all = RIGS.iter().map(|names| paths(names));
            let mut there =
                all.filter(|paths: &Vec<PathBuf>| paths.iter().all(|path| path.is_file()));
            there.next().unwrap_or_default()
        };
        Ok(Self { sides, rig })
    }
}

fn sides(top: &Path) -> Result<[Vec<PathBuf>; 2]> {
    for [left, right] in FOLDERS {
        let folders = [top.join(left), top.join(right)];
        if folders.iter().all(|folder| folder.is_dir()) {
            return Ok([images(&folders[0])?, images(&folders[1])?]);
        }
    }
    for pair in FILES {
        let [left, right] = pair.map(|name| images(&top.join(name)));
        if let (Ok(left), Ok(right)) = (left, right) {
            return Ok([left, right]);
        }
    }
    bail!(
        "{}: no left and right images: EuRoC (mav0/cam0/data), KITTI (image_0, image_1), Middlebury (im0, im1), \
         left/ and right/, or left*.png and right*.png are known; or give two folders",
        top.display()
    )
}
