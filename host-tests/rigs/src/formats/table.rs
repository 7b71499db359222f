//! The formats that are read: the keys of each, its description, and its reader.

use std::collections::HashSet;

use anyhow::{Context, Error, Result, anyhow, bail, ensure};

use super::Files;
use super::rig::Unknowns;
use super::{
    bare, basalt, bouguet, camera_list, colmap, dsec, euroc, ini_sets, kalibr, luxonis, mc_calib,
    models, mynt, named,
};
use super::{opencv, orbslam, realsense, rectified_sets, ros, vins, zed};
use crate::data::Meta;

/// The unit of a translation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    /// The unit of the format.
    Own,
    /// The unit of the board, or any unit: `--unit` gives it.
    Given,
}

use Unit::{Given, Own};

/// Which cameras of a file are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cameras {
    /// The two of the rig.
    Both,
    /// Two of several: `--cameras` chooses them and their order.
    Chosen,
}

use Cameras::{Both, Chosen};

/// A format.
struct Row {
    name: &'static str,
    /// Sets of keys that only this format has: a file with all keys of one set is in this format. `a.b` is the key `b`
    /// of `a`, or of the first item of a list `a`.
    marks: &'static [&'static [&'static str]],
    unit: Unit,
    /// Which cameras of a file are read.
    cameras: Cameras,
    read: fn(&Files, Unknowns) -> Result<Meta>,
    /// Files, direction of the extrinsics and unit, for the user.
    says: &'static str,
}

/// All formats.
#[rustfmt::skip]
const FORMATS: [Row; 30] = [
    Row { name: "EuRoC", marks: &[&["T_BS"]], unit: Own, cameras: Both, read: euroc::rig,
        says: "two sensor.yaml, left and right; T_BS: camera to body; metres" },
    Row { name: "KITTI", marks: &[&["P0"], &["P_rect_00"], &["P_rect_02"], &["P_rect_101"]], unit: Own, cameras: Chosen, read: rectified_sets::kitti,
        says: "calib.txt, calib_cam_to_cam.txt, perspective.txt; P0 and P1, or --cameras 2,3; rectified; metres. DrivingStereo: P_rect_101 and P_rect_103" },
    Row { name: "Middlebury, ETH3D", marks: &[&["doffs"], &["ndisp"], &["cam0", "baseline"]], unit: Own, cameras: Both, read: rectified_sets::middlebury,
        says: "calib.txt; rectified; millimetres" },
    Row { name: "Cityscapes", marks: &[&["intrinsic.fx"], &["intrinsic.u0"]], unit: Own, cameras: Both, read: rectified_sets::cityscapes,
        says: "camera.json; one camera and extrinsic: baseline; rectified; metres" },
    Row { name: "bare numbers", marks: &[&["bare numbers"]], unit: Own, cameras: Both, read: bare::rig,
        says: "FoundationStereo: nine numbers of K, then the baseline; DSOL: fx fy cx cy baseline; Stereo-DSO: camera.txt with the baseline in its fifth line; ETH3D SLAM: calibration.txt, calibration2.txt, extrinsics_1_2.txt (camera 2, which is left, to camera 1); metres" },
    Row { name: "Luxonis", marks: &[&["cameraData"]], unit: Own, cameras: Chosen, read: luxonis::rig,
        says: "JSON of DepthAI; extrinsics of a chain of sockets; centimetres" },
    Row { name: "DSEC", marks: &[&["extrinsics.T_10"], &["extrinsics.T_21"], &["intrinsics.cam0"]], unit: Own, cameras: Chosen, read: dsec::rig,
        says: "cam_to_cam.yaml; T_10 under extrinsics takes points of cam0 to cam1; of more than two cameras --cameras chooses; metres" },
    Row { name: "RealSense", marks: &[&["left", "right", "extrinsics"], &["extrinsics.rotation"]], unit: Own, cameras: Both, read: realsense::json,
        says: "JSON: rs2_intrinsics under left and right, rs2_extrinsics (left to right, rotation by columns) under extrinsics; metres" },
    Row { name: "RealSense text", marks: &[&["rs intrinsics"]], unit: Own, cameras: Both, read: realsense::printed,
        says: "output of rs-enumerate-devices -c, Infrared or Fisheye 1 and 2; metres" },
    Row { name: "RealSense sensors", marks: &[&["rs sensors"]], unit: Own, cameras: Both, read: realsense::sensors,
        says: "output of rs-sensor-control: left stream, right stream, left to right; metres" },
    Row { name: "RealSense table", marks: &[&["rectified.0.fx"], &["rectified.1.fx"]], unit: Own, cameras: Both, read: realsense::table,
        says: "JSON of the calibration table; rectified streams, the size tells the mode; baseline in millimetres" },
    Row { name: "MYNT EYE", marks: &[&["Intrinsics left"]], unit: Own, cameras: Both, read: mynt::rig,
        says: "output of get_img_params; Extrinsics right to left hold R and T of OpenCV; millimetres" },
    Row { name: "ORB-SLAM3, ORB-SLAM2, stella_vslam", marks: &[&["Camera1.fx"], &["Camera2.fx"], &["Stereo.b"], &["Tlr"], &["LEFT.K"], &["Camera.fx"], &["Camera.bf"]], unit: Own, cameras: Both, read: orbslam::rig,
        says: "settings; Stereo.T_c1_c2 (Tlr): right to left; LEFT and RIGHT with K D R P, StereoRectifier, or rectified with Camera.bf or focal_x_baseline; metres" },
    Row { name: "VINS-Fusion", marks: &[&["body_T_cam0"], &["cam0_calib"]], unit: Own, cameras: Chosen, read: vins::rig,
        says: "the configuration, its camera files beside it; OV2SLAM: cameras in the configuration; body_T_cam: camera to body; metres" },
    Row { name: "Basalt", marks: &[&["value0.T_imu_cam"], &["value0.intrinsics"]], unit: Own, cameras: Chosen, read: basalt::rig,
        says: "JSON; T_imu_cam: camera to IMU; metres" },
    Row { name: "OKVIS, maplab, Spectacular AI, Monado", marks: &[&["cameras.T_SC"], &["cameras.camera"], &["cameras.T_B_C"], &["cameras.imuToCamera"], &["opencv_stereo_calibrate"]], unit: Own, cameras: Chosen, read: camera_list::rig,
        says: "list `cameras`; T_SC, T_B_C: camera to body; imuToCamera: IMU to camera; opencv_stereo_calibrate: as OpenCV; metres" },
    Row { name: "Bouguet", marks: &[&["fc_left"]], unit: Given, cameras: Both, read: bouguet::rig,
        says: "Calib_Results_stereo of the MATLAB toolbox; x_r = R(om) x_l + T; unit of the board" },
    Row { name: "MC-Calib", marks: &[&["camera_0.camera_pose_matrix"], &["camera_1.camera_pose_matrix"], &["nb_camera"]], unit: Given, cameras: Chosen, read: mc_calib::rig,
        says: "calibrated_cameras_data.yml; camera_pose_matrix: camera to reference; unit of the board" },
    Row { name: "ZED", marks: &zed::MARKS, unit: Own, cameras: Both, read: zed::rig,
        says: "SN*.conf, the size tells the resolution; R of (RX, CV, RZ), T = -(Baseline, TY, TZ); millimetres" },
    Row { name: "iCub", marks: &[&["STEREO_DISPARITY"], &["CAMERA_CALIBRATION_LEFT"]], unit: Own, cameras: Both, read: ini_sets::icub,
        says: "icubEyes.ini, outputCalib.ini; HN: left to right; metres" },
    Row { name: "MRPT", marks: &[&["CAMERA_PARAMS_LEFT2RIGHT_POSE"], &["CAMERA_PARAMS_LEFT"]], unit: Own, cameras: Both, read: ini_sets::mrpt,
        says: "INI of the stereo calibration; pose_quaternion: right to left; metres" },
    Row { name: "Anipose, Caliscope, FreeMoCap", marks: &[&["CAM_0.matrix"], &["CAM_1.matrix"]], unit: Given, cameras: Chosen, read: ini_sets::anipose,
        says: "calibration.toml; rotation and translation: world to camera; unit of the board" },
    Row { name: "COLMAP", marks: &[&["rigs.txt"], &["cameras.txt"], &[".cameras.image_prefix"], &[".cameras.camera_id"]], unit: Given, cameras: Chosen, read: colmap::rig,
        says: "cameras.txt with rigs.txt or rig_config.json; sensor_from_rig; (0, 0) is the corner of the first pixel; unit of the model" },
    Row { name: "openMVG", marks: &[&["sfm_data_version"]], unit: Given, cameras: Chosen, read: models::openmvg,
        says: "sfm_data.json; rotation and center of the poses of two views; unit of the model" },
    Row { name: "OpenSfM", marks: &[&[".shots"], &[".rig_cameras"]], unit: Given, cameras: Chosen, read: models::opensfm,
        says: "reconstruction.json; rotation and translation of two shots: world to camera; unit of the model" },
    Row { name: "nerfstudio", marks: &[&["frames.transform_matrix"]], unit: Given, cameras: Chosen, read: models::nerfstudio,
        says: "transforms.json; transform_matrix of two frames: camera to world, axes of OpenGL; (0, 0) is the corner of the first pixel; unit of the model" },
    Row { name: "Kalibr, OpenVINS", marks: &[&["cam0.intrinsics"], &["cam0.camera_model"], &["cam1.intrinsics"], &["cam1.camera_model"], &["cam1.T_cn_cnm1"]], unit: Own, cameras: Chosen, read: kalibr::rig,
        says: "camchain.yaml, results-cam.txt: T_cn_cnm1 of cam1 takes points of cam0 (left) to cam1 (right); without it T_cam_imu: IMU to camera, or T_imu_cam: camera to IMU; metres" },
    Row { name: "ROS", marks: &[&["camera_matrix"], &["projection_matrix"]], unit: Given, cameras: Both, read: ros::rig,
        says: "left.yaml and right.yaml: R = R_r^T R_l, t = -(first row of R_r) of the rectification matrices, `P[0][3] = -fx b` of the right camera; above each other: `P[1][3]`; metres, or --unit" },
    Row { name: "ROS echo", marks: &[&["P", "K"], &["p", "k"], &["P", "distortion_model"], &["p", "distortion_model"]], unit: Given, cameras: Both, read: ros::echoed,
        says: "left and right camera_info as `ros2 topic echo` or `rostopic echo` print them; as ROS" },
    Row { name: "OpenCV", marks: &opencv::MARKS, unit: Given, cameras: Chosen, read: opencv::rig,
        says: "intrinsics.yml and extrinsics.yml, one file of both, or XML: M1 D1 M2 D2 R T, also as lists under names such as K1 or cameraMatrix1, or whose words say left, right, matrix, distortion, rotation, translation; x_2 = R x_1 + T, the left camera first; without R the rectification R1 R2 P2; unit of the board" },
];

/// The list of the formats, one a line, for the help.
pub fn list() -> String {
    let line = |row: &Row| format!("  {}: {}", row.name, row.says);
    FORMATS.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The rig of files; what only one format has tells the format. If several formats are possible, all of them are tried.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let marked = FORMATS.iter().filter_map(|row| Some((row, row.mark(files)?)));
    let mut read: Vec<(&Row, Result<Meta>)> =
        marked.map(|(row, mark)| (row, row.rig(files, unknowns, &mark))).collect();
    let mut unread: Vec<(&Row, Result<Meta>)> = Vec::new();
    if read.iter().any(|(_, rig)| rig.is_ok()) {
        unread = read.extract_if(.., |(_, rig)| rig.is_err()).collect();
    }
    // The numbers of the raw images win over those of the rectified ones in the same file.
    if read.len() > 1 && read.iter().filter(|(_, rig)| is_raw(rig)).count() == 1 {
        unread.extend(read.extract_if(.., |(_, rig)| !is_raw(rig)));
    }
    let names = |read: &[(&Row, _)]| {
        read.iter().map(|(row, _)| row.name).collect::<Vec<_>>().join("; and of ")
    };
    match read.len() {
        0 => named::rig(files, unknowns).unwrap_or_else(|| Err(unknown(files))),
        1 => {
            let mut meta = read.remove(0).1?;
            if !unread.is_empty() {
                meta.other.insert(Meta::UNREAD.to_owned(), names(&unread).into());
            }
            Ok(meta)
        }
        _ if read.iter().all(|(_, rig)| rig.is_err()) => {
            let why = read.iter().filter_map(|(_, rig)| rig.as_ref().err());
            let why = why.map(|why| format!("{why:#}")).collect::<Vec<_>>().join("; or: ");
            bail!("{files}: these have keys of {}: {why}", names(&read))
        }
        _ => bail!("{files}: these are a rig of {}: give the files of one rig alone", names(&read)),
    }
}

/// Whether a rig belongs to images before rectification.
fn is_raw(rig: &Result<Meta>) -> bool {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let distorts = |meta: &Meta| meta.dist_l.iter().chain(&meta.dist_r).any(|k| *k != 0.0);
    rig.as_ref().is_ok_and(|meta| meta.r != identity || distorts(meta))
}

/// An error for files whose keys belong to no format.
fn unknown(files: &Files) -> Error {
    // Keys of matrices say more than those of single numbers.
    let matrices =
        files.values().flat_map(|file| file.nested()).filter(|(_, value)| value.is_matrix());
    let mut keys: Vec<String> = matrices.map(|(keys, _)| keys.join(".")).collect();
    keys.extend(files.values().flat_map(|file| file.keys()).map(str::to_owned));
    let mut seen = HashSet::new();
    keys.retain(|key| seen.insert(key.clone()));
    keys.truncate(12);
    let keys = if keys.is_empty() {
        "there are no keys with values".to_owned()
    } else {
        format!("the keys ({}) belong to no known format", keys.join(", "))
    };
    let names: Vec<&str> = FORMATS.iter().map(|row| row.name).collect();
    anyhow!(
        "{files}: {keys}. Known formats: {}. Write the numbers as K1 D1 K2 D2 R T, or see `selfcal import --help`",
        names.join("; ")
    )
}

impl Row {
    /// The keys that tell this format, if the files have them.
    fn mark(&self, files: &Files) -> Option<String> {
        let there =
            |keys: &&&[&str]| files.values().any(|file| keys.iter().all(|key| file.has(key)));
        Some(self.marks.iter().find(there)?.join(" and "))
    }

    fn rig(&self, files: &Files, unknowns: Unknowns, mark: &str) -> Result<Meta> {
        ensure!(
            self.cameras == Chosen || unknowns.cameras.is_none(),
            "{files}: --cameras: a file of {} has the cameras of one rig; leave --cameras out",
            self.name
        );
        ensure!(
            self.unit == Given || unknowns.unit_m.to_bits() == 1.0_f64.to_bits(),
            "{files}: --unit {}: a file of {} has its own unit; leave --unit out",
            unknowns.unit_m,
            self.name
        );
        let is = || format!("the rig of {files}, which {} tells to be of {}", mark, self.name);
        (self.read)(files, unknowns).with_context(is)
    }
}
