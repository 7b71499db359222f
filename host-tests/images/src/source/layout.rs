//! Folders of known layouts: `EuRoC`, KITTI, Middlebury, and folders or files named left and right.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use super::folders::images;

/// Files found in a folder.
#[derive(Debug)]
pub(super) struct Layout {
    /// Left and right images, each in the order of names.
    pub(super) sides: [Vec<PathBuf>; 2],
    /// Files of the calibration; may be empty.
    pub(super) rig: Vec<PathBuf>,
    /// Numbers of the two cameras in the calibration, if the folders tell.
    pub(super) cameras: Option<[u8; 2]>,
}

/// Folders of left and right images, from the top of a data set.
const FOLDERS: [[&str; 2]; 18] = [
    ["mav0/cam0/data", "mav0/cam1/data"],
    ["cam0/data", "cam1/data"],
    ["image_0", "image_1"],
    ["image_00/data", "image_01/data"],
    ["image_00/data_rect", "image_01/data_rect"],
    ["image_00", "image_01"],
    ["image_2", "image_3"],
    ["image_02/data", "image_03/data"],
    ["image_02", "image_03"],
    ["colored_0", "colored_1"],
    ["infra1", "infra2"],
    ["left", "right"],
    ["cam0", "cam1"],
    ["image_left", "image_right"],
    ["imageL", "imageR"],
    ["image_lcam_front", "image_rcam_front"],
    ["stereo/left", "stereo/right"],
    ["dso/cam0/images", "dso/cam1/images"],
];

/// Patterns of left and right files in one folder.
const FILES: [[&str; 2]; 9] = [
    ["im0.*", "im1.*"],
    ["view1.*", "view5.*"],
    ["left*", "right*"],
    ["*_left.*", "*_right.*"],
    ["*_l.*", "*_r.*"],
    ["*_L.*", "*_R.*"],
    ["L*", "R*"],
    ["*_cam0.*", "*_cam1.*"],
    ["image_0_*", "image_1_*"],
];

/// Files of a calibration, from the top of a data set. The first row whose files all exist is used.
const RIGS: [&[&str]; 11] = [
    &["mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml"],
    &["cam0/sensor.yaml", "cam1/sensor.yaml"],
    &["calib.txt"],
    &["../calib_cam_to_cam.txt"],
    &["calib_cam_to_cam.txt"],
    &["rig.json"],
    &["camchain.yaml"],
    &["camchain-imucam.yaml"],
    &["K.txt"],
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The left and right images that are found in a folder with empty files of these names.
    fn found(names: [&str; 2]) -> [Vec<PathBuf>; 2] {
        let top = tempfile::tempdir().unwrap();
        for name in names {
            let path = top.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let within = |path: &PathBuf| path.strip_prefix(top.path()).unwrap().to_path_buf();
        sides(top.path()).unwrap().map(|side| side.iter().map(within).collect())
    }

    #[test]
    fn folders_and_names_of_data_sets_and_drivers_tell_left_and_right() {
        for names in [
            ["imageL/1.png", "imageR/1.png"],
            ["image_00/data_rect/0000000001.png", "image_01/data_rect/0000000001.png"],
            ["image_lcam_front/000000_lcam_front.png", "image_rcam_front/000000_rcam_front.png"],
            ["stereo/left/1399381444.png", "stereo/right/1399381444.png"],
            ["dso/cam0/images/1520530308199447626.png", "dso/cam1/images/1520530308199447626.png"],
            ["infra1/1.png", "infra2/1.png"],
            ["room_L.png", "room_R.png"],
            ["L0001.jpg", "R0001.jpg"],
            ["frame0003_cam0.png", "frame0003_cam1.png"],
            ["image_0_17.png", "image_1_17.png"],
        ] {
            assert_eq!(found(names), names.map(|name| vec![PathBuf::from(name)]), "{names:?}");
        }
    }
}
