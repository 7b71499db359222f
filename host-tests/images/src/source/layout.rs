//! Folders of known layouts: `EuRoC`, KITTI, Middlebury, and plain left and right.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use super::folders::images;

/// Files found in a folder.
#[derive(Debug)]
pub(super) struct Layout {
    /// Left and right images, each in the order of names.
    pub(super) sides: [Vec<PathBuf>; 2],
    /// Files of its calibration; may be empty.
    pub(super) rig: Vec<PathBuf>,
    /// Numbers of the two cameras in the calibration, if the folders tell.
    pub(super) cameras: Option<[u8; 2]>,
}

/// Folders of left and right images, from the top of a data set.
const FOLDERS: [[&str; 2]; 13] = [
    ["mav0/cam0/data", "mav0/cam1/data"],
    ["cam0/data", "cam1/data"],
    ["image_0", "image_1"],
    ["image_00/data", "image_01/data"],
    ["image_00", "image_01"],
    ["image_2", "image_3"],
    ["image_02/data", "image_03/data"],
    ["image_02", "image_03"],
    ["colored_0", "colored_1"],
    ["infra1", "infra2"],
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

/// Files of a calibration, from the top of a data set; all files of a row are needed.
const RIGS: [&[&str]; 9] = [
    &["mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml"],
    &["cam0/sensor.yaml", "cam1/sensor.yaml"],
    &["calib.txt"],
    &["../calib_cam_to_cam.txt"],
    &["calib_cam_to_cam.txt"],
    &["rig.json"],
    &["camchain.yaml"],
    &["intrinsics.yml", "extrinsics.yml"],
    &["left.yaml", "right.yaml"],
];

impl Layout {
    pub(super) fn of(top: &Path) -> Result<Self> {
        let sides = sides(top)?;
        let cameras = cameras([&sides[0], &sides[1]]);
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
        Ok(Self { sides, rig, cameras })
    }
}

/// The numbers of two cameras, from the folders of their images: KITTI's `image_2` and `image_3` are cameras 2 and 3.
pub(super) fn cameras(sides: [&[PathBuf]; 2]) -> Option<[u8; 2]> {
    let number = |side: &[PathBuf]| -> Option<u8> {
        let folders =
            side.first()?.ancestors().skip(1).filter_map(|folder| folder.file_name()?.to_str());
        let mut numbered = folders.filter_map(|name| name.strip_prefix("image_"));
        numbered.next()?.parse().ok()
    };
    Some([number(sides[0])?, number(sides[1])?])
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
        "{}: no left and right images: EuRoC (mav0/cam0/data), KITTI (image_0, image_1, or image_2, image_3), Middlebury \
         (im0, im1), left/ and right/, or left*.png and right*.png are known; or give two folders, or --side-by-side for \
         pictures of both cameras",
        top.display()
    )
}
