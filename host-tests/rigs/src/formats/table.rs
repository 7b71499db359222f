//! The formats that are read: the keys of each, its description, and its reader.

use anyhow::{Context, Result, bail, ensure};

use super::Files;
use super::rig::Unknowns;
use super::{basalt, bouguet, camera_list, colmap, euroc, kalibr, luxonis, mc_calib, mynt};
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

/// A format.
struct Row {
    name: &'static str,
    /// A file with one of these keys is in this format.
    keys: &'static [&'static str],
    unit: Unit,
    read: fn(&Files, Unknowns) -> Result<Meta>,
    /// Files, direction of the extrinsics and unit, for the user.
    says: &'static str,
}

/// All formats. The first whose key is found is taken, so formats whose keys others have too come last.
#[rustfmt::skip]
const FORMATS: [Row; 25] = [
    Row { name: "EuRoC", keys: &["T_BS"], unit: Own, read: euroc::rig,
        says: "two sensor.yaml, left and right; T_BS: camera to body; metres" },
    Row { name: "KITTI", keys: &["P0", "P_rect_00", "P_rect_02", "P_rect_101"], unit: Own, read: rectified_sets::kitti,
        says: "calib.txt, calib_cam_to_cam.txt, perspective.txt; P0 and P1, or --cameras 2,3; rectified; metres. DrivingStereo: P_rect_101 and P_rect_103" },
    Row { name: "Middlebury", keys: &["doffs", "ndisp"], unit: Own, read: rectified_sets::middlebury,
        says: "calib.txt; rectified; millimetres" },
    Row { name: "Cityscapes", keys: &["intrinsic"], unit: Own, read: rectified_sets::cityscapes,
        says: "camera.json; one camera and extrinsic: baseline; rectified; metres" },
    Row { name: "K and baseline", keys: &["K.txt"], unit: Own, read: rectified_sets::bare,
        says: "bare numbers, as in K.txt of FoundationStereo: nine numbers of K, then the baseline; rectified; metres" },
    Row { name: "Luxonis", keys: &["cameraData"], unit: Own, read: luxonis::rig,
        says: "JSON of DepthAI; extrinsics of a chain of sockets; centimetres" },
    Row { name: "RealSense", keys: &["extrinsics"], unit: Own, read: realsense::json,
        says: "JSON: rs2_intrinsics under left and right, rs2_extrinsics (left to right, rotation by columns) under extrinsics; metres" },
    Row { name: "RealSense text", keys: &["rs intrinsics"], unit: Own, read: realsense::printed,
        says: "output of rs-enumerate-devices -c, Infrared or Fisheye 1 and 2; metres" },
    Row { name: "RealSense sensors", keys: &["rs sensors"], unit: Own, read: realsense::sensors,
        says: "output of rs-sensor-control: left stream, right stream, left to right; metres" },
    Row { name: "RealSense table", keys: &realsense::TABLE, unit: Own, read: realsense::table,
        says: "JSON of the calibration table; rectified streams, the size tells the mode; baseline in millimetres" },
    Row { name: "MYNT EYE", keys: &["Intrinsics left"], unit: Own, read: mynt::rig,
        says: "output of get_img_params; Extrinsics right to left hold R and T of OpenCV; millimetres" },
    Row { name: "ORB-SLAM3", keys: &["Camera1.fx", "Camera2.fx", "Stereo.T_c1_c2", "Stereo.b", "Tlr"], unit: Own, read: orbslam::third,
        says: "settings; Stereo.T_c1_c2 (Tlr): right to left; metres" },
    Row { name: "ORB-SLAM2", keys: &["LEFT.K", "Camera.fx", "Camera.bf"], unit: Own, read: orbslam::second,
        says: "settings, also of stella_vslam; LEFT and RIGHT with K D R P, StereoRectifier, or rectified with Camera.bf or focal_x_baseline; metres" },
    Row { name: "VINS-Fusion", keys: &["body_T_cam0", "cam0_calib"], unit: Own, read: vins::rig,
        says: "the configuration, its camera files beside it; body_T_cam: camera to body; metres" },
    Row { name: "Basalt", keys: &["value0"], unit: Own, read: basalt::rig,
        says: "JSON; T_imu_cam: camera to IMU; metres" },
    Row { name: "OKVIS, maplab, Spectacular AI, Monado", keys: &["cameras"], unit: Own, read: camera_list::rig,
        says: "list `cameras`; T_SC, T_B_C: camera to body; imuToCamera: IMU to camera; opencv_stereo_calibrate: as OpenCV; metres" },
    Row { name: "Bouguet", keys: &["fc_left"], unit: Given, read: bouguet::rig,
        says: "Calib_Results_stereo of the MATLAB toolbox; x_r = R(om) x_l + T; unit of the board" },
    Row { name: "MC-Calib", keys: &["camera_0", "camera_1", "nb_camera"], unit: Given, read: mc_calib::rig,
        says: "calibrated_cameras_data.yml; camera_pose_matrix: camera to reference; unit of the board" },
    Row { name: "ZED", keys: &zed::KEYS, unit: Own, read: zed::rig,
        says: "SN*.conf, the size tells the resolution; R of (RX, CV, RZ), T = -(Baseline, TY, TZ); millimetres" },
    Row { name: "COLMAP", keys: &["rigs.txt", "cameras.txt", ""], unit: Given, read: colmap::rig,
        says: "cameras.txt with rigs.txt or rig_config.json; sensor_from_rig; (0, 0) is the corner of the first pixel; unit of the model" },
    Row { name: "Kalibr, OpenVINS", keys: &["cam0", "cam1"], unit: Own, read: kalibr::rig,
        says: "camchain.yaml, results-cam.txt: T_cn_cnm1 of cam1 takes points of cam0 (left) to cam1 (right); without it T_cam_imu: IMU to camera, or T_imu_cam: camera to IMU; metres" },
    Row { name: "ROS", keys: &["camera_matrix", "projection_matrix"], unit: Given, read: ros::rig,
        says: "left.yaml and right.yaml: R = R_r^T R_l, t = -(first row of R_r) of the rectification matrices, `P[0][3] = -fx b` of the right camera; above each other: `P[1][3]`; metres, or --unit" },
    Row { name: "ROS echo", keys: &["P", "p"], unit: Given, read: ros::echoed,
        says: "left and right camera_info as `ros2 topic echo` or `rostopic echo` print them; as ROS" },
    Row { name: "OpenCV", keys: &opencv::KEYS, unit: Given, read: opencv::rig,
        says: "intrinsics.yml and extrinsics.yml, one file of both, or XML: M1 D1 M2 D2 R T; x_2 = R x_1 + T, the left camera first; without R the rectification R1 R2 P2; unit of the board" },
    Row { name: "lists", keys: &opencv::LISTS, unit: Given, read: opencv::rig,
        says: "K1 D1 K2 D2 R T as lists in JSON, YAML or name = [[..]], also as cameraMatrix1, distCoeffs1, ..; as OpenCV" },
];

/// The list of the formats, one a line, for the help.
pub fn list() -> String {
    let line = |row: &Row| format!("  {}: {}", row.name, row.says);
    FORMATS.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The rig of files; their keys tell the format.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let found = FORMATS.iter().find(|row| !files.with(row.keys).is_empty());
    let Some(row) = found else {
        let keys: Vec<String> = files
            .values()
            .flat_map(|file| file.keys().into_iter().map(str::to_owned).collect::<Vec<_>>())
            .take(12)
            .collect();
        let known = FORMATS.iter().map(|row| {
            let keys = row.keys.iter().copied().filter(|key| !key.is_empty()).take(3);
            format!("{} ({})", row.name, keys.collect::<Vec<_>>().join(", "))
        });
        bail!(
            "{files}: the keys ({}) belong to no known format. Known formats: {}. Write the numbers as K1 D1 K2 D2 R T, \
             or see `selfcal import --help`",
            keys.join(", "),
            known.collect::<Vec<_>>().join("; ")
        );
    };
    ensure!(
        row.unit == Given || unknowns.unit_m.to_bits() == 1.0_f64.to_bits(),
        "{files}: --unit {}: a file of {} has its own unit; leave --unit out",
        unknowns.unit_m,
        row.name
    );
    (row.read)(files, unknowns).with_context(|| format!("the rig of {files} ({})", row.name))
}
