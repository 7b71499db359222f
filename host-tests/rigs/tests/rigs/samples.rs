//! A sample of each format in `tests/samples`, most of them of one made-up rig.
//!
//! `R` turns about x by an angle of the 3-4-5 triangle, `T` = (-0.12, 0.01, 0.02) m: the point (0, 0, 5) of the left
//! camera is at (-0.12, -2.99, 4.02) in the right one, whose centre is (0.12, -0.02, -0.01) in the left frame. If a
//! file has a body frame, the left camera is at (0.1, 0.2, 0.3) in it, with its z along the body's x.
//!
//! In the rectifications (ROS, ORB-SLAM2, `stella_vslam`) `R_l` turns about z by this angle and `R_r` not at all, so
//! `R = R_l`; the baseline is 48 / 400 m. In the file of Luxonis, left (1) and right (2) lead to the camera in the
//! middle (0).

use rigs::formats::Unknowns;

/// A format: its name, its files, the values that they lack, and whether it has `R` and `T` of the rig above.
pub(crate) struct Sample {
    pub(crate) name: &'static str,
    pub(crate) files: Vec<(&'static str, String)>,
    pub(crate) unknowns: Unknowns,
    pub(crate) is_the_rig: bool,
}

/// Files of a folder of `tests/samples`.
macro_rules! files {
    ($folder:literal: $($file:literal),+) => {
        [$(($file, include_str!(concat!("../samples/", $folder, "/", $file)))),+]
    };
}

pub(crate) const OPENCV: [(&str, &str); 2] = files!("opencv": "intrinsics.yml", "extrinsics.yml");
pub(crate) const KALIBR: &str = include_str!("../samples/kalibr/camchain.yaml");
pub(crate) const ROS: [(&str, &str); 2] = files!("ros": "left.yaml", "right.yaml");

/// Names and texts of files.
type Files = &'static [(&'static str, &'static str)];

const NONE: Unknowns = Unknowns { sizes: None, unit_m: 1.0, cameras: None };

pub(crate) const fn size(width: u16, height: u16) -> Unknowns {
    Unknowns { sizes: Some([[width, height]; 2]), ..NONE }
}

#[rustfmt::skip]
const SAMPLES: [(&str, Files, Unknowns, bool); 50] = [
    ("OpenCV", &OPENCV, size(640, 480), true),
    ("OpenCV XML", &files!("opencv-xml": "stereo.xml"), NONE, true),
    ("lists in JSON", &files!("lists-in-json": "rig.json"), NONE, true),
    ("lists in text", &files!("lists-in-text": "rig.txt"), NONE, true),
    ("named keys", &files!("named-keys": "stereo_params.json"), NONE, true),
    ("Kalibr", &[("camchain.yaml", KALIBR)], NONE, true),
    ("OpenVINS", &files!("openvins": "kalibr_imucam_chain.yaml"), NONE, true),
    ("ROS", &ROS, NONE, false),
    ("ROS echo", &files!("ros-echo": "left.yaml", "right.yaml"), NONE, false),
    ("EuRoC", &files!("euroc": "cam0.yaml", "cam1.yaml"), NONE, true),
    ("ORB-SLAM3", &files!("orb-slam3": "stereo.yaml"), NONE, true),
    ("ORB-SLAM2", &files!("orb-slam2": "EuRoC.yaml"), NONE, false),
    ("ORB-SLAM3 rectification", &files!("orb-slam3-rectification": "stereo.yaml"), NONE, false),
    ("OV2SLAM", &files!("ov2slam": "parameters.yaml"), NONE, true),
    ("VINS-Fusion", &files!("vins-fusion": "config.yaml", "cam0.yaml", "cam1.yaml"), NONE, true),
    ("Basalt", &files!("basalt": "calibration.json"), NONE, true),
    ("MC-Calib", &files!("mc-calib": "calibrated_cameras_data.yml"), Unknowns { unit_m: 0.001, ..NONE }, true),
    ("ZED", &files!("zed": "SN1234.conf"), size(1280, 720), true),
    ("COLMAP", &files!("colmap": "cameras.txt", "rigs.txt"), NONE, true),
    ("COLMAP JSON", &files!("colmap-json": "rig_config.json", "cameras.txt"), NONE, true),
    ("RealSense", &files!("realsense": "realsense.json"), NONE, true),
    ("RealSense text", &files!("realsense-text": "rs.txt"), NONE, true),
    ("RealSense sensors", &files!("realsense-sensors": "rs.txt"), size(848, 800), true),
    ("Luxonis", &files!("luxonis": "calib.json"), NONE, true),
    ("KITTI", &files!("kitti": "calib.txt"), size(1241, 376), false),
    ("Middlebury", &files!("middlebury": "calib.txt"), NONE, false),
    ("DrivingStereo", &files!("drivingstereo": "calib.txt"), NONE, false),
    ("Cityscapes", &files!("cityscapes": "camera.json"), size(2048, 1024), false),
    ("K and baseline", &files!("k-and-baseline": "K.txt"), size(960, 540), false),
    ("RealSense table", &files!("realsense-table": "table.json"), size(1280, 720), false),
    ("MYNT EYE", &files!("mynt-eye": "params.txt"), NONE, true),
    ("OKVIS", &files!("okvis": "config.yaml"), NONE, true),
    ("maplab", &files!("maplab": "ncamera.yaml"), NONE, true),
    ("Spectacular AI", &files!("spectacular-ai": "calibration.json"), NONE, true),
    ("Monado", &files!("monado": "calibration.json"), NONE, true),
    ("Kalibr report", &files!("kalibr-report": "results-cam.txt"), size(752, 480), true),
    ("stella_vslam", &files!("stella_vslam": "stella.yaml"), NONE, false),
    ("OpenCV rectification", &files!("opencv-rectification": "rig.yaml"), NONE, false),
    ("numpy", &files!("numpy": "rig.txt"), NONE, true),
    ("DSEC", &files!("dsec": "cam_to_cam.yaml"), NONE, true),
    ("iCub", &files!("icub": "icubEyes.ini"), NONE, true),
    ("MRPT", &files!("mrpt": "stereo.ini"), NONE, true),
    ("Anipose", &files!("anipose": "calibration.toml"), Unknowns { unit_m: 0.001, ..NONE }, true),
    ("openMVG", &files!("openmvg": "sfm_data.json"), NONE, true),
    ("OpenSfM", &files!("opensfm": "reconstruction.json"), NONE, true),
    ("nerfstudio", &files!("nerfstudio": "transforms.json"), NONE, true),
    ("ETH3D SLAM", &files!("eth3d-slam": "calibration.txt", "calibration2.txt", "extrinsics_1_2.txt"), size(739, 458), true),
    ("DSOL", &files!("dsol": "calib.txt"), size(752, 480), false),
    ("Stereo-DSO", &files!("stereo-dso": "camera.txt"), NONE, false),
    ("Bouguet", &files!("bouguet": "Calib_Results_stereo.txt"), Unknowns { unit_m: 0.001, ..size(640, 480) }, true),
];

/// All formats.
pub(crate) fn samples() -> Vec<Sample> {
    let sample = |(name, files, unknowns, is_the_rig): (_, Files, _, _)| {
        let files = files.iter().map(|(name, text)| (*name, (*text).to_owned())).collect();
        Sample { name, files, unknowns, is_the_rig }
    };
    SAMPLES.map(sample).into()
}
