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

/// A format.
struct Row {
    name: &'static str,
    /// A file with one of these keys is in this format.
    keys: &'static [&'static str],
    /// Files, direction of the extrinsics and unit, for the user.
    says: &'static str,
    unit: Unit,
    read: fn(&Files, Unknowns) -> Result<Meta>,
}

/// All formats. The first whose key is found is taken, so formats whose keys others have too come last.
const FORMATS: [Row; 25] = [
    Row {
        name: "EuRoC",
        keys: &["T_BS"],
        says: "two sensor.yaml, left and right; T_BS: camera to body; metres",
        unit: Unit::Own,
        read: euroc::rig,
    },
    Row {
        name: "KITTI",
        keys: &["P0", "P_rect_00", "P_rect_02", "P_rect_101"],
        says: "calib.txt, calib_cam_to_cam.txt, perspective.txt; P0 and P1, or --cameras 2,3; rectified; metres. DrivingStereo: P_rect_101 and P_rect_103",
        unit: Unit::Own,
        read: rectified_sets::kitti,
    },
    Row {
        name: "Middlebury",
        keys: &["doffs", "ndisp"],
        says: "calib.txt; rectified; millimetres",
        unit: Unit::Own,
        read: rectified_sets::middlebury,
    },
    Row {
        name: "Cityscapes",
        keys: &["intrinsic"],
        says: "camera.json; one camera and extrinsic: baseline; rectified; metres",
        unit: Unit::Own,
        read: rectified_sets::cityscapes,
    },
    Row {
        name: "K and baseline",
        keys: &["K.txt"],
        says: "bare numbers, as in K.txt of FoundationStereo: nine numbers of K, then the baseline; rectified; metres",
        unit: Unit::Own,
        read: rectified_sets::bare,
    },
    Row {
        name: "Luxonis",
        keys: &["cameraData"],
        says: "JSON of DepthAI; extrinsics of a chain of sockets; centimetres",
        unit: Unit::Own,
        read: luxonis::rig,
    },
    Row {
        name: "RealSense",
        keys: &["extrinsics"],
        says: "JSON: rs2_intrinsics under left and right, rs2_extrinsics (left to right, rotation by columns) under extrinsics; metres",
        unit: Unit::Own,
        read: realsense::json,
    },
    Row {
        name: "RealSense text",
        keys: &["rs intrinsics"],
        says: "output of rs-enumerate-devices -c, Infrared or Fisheye 1 and 2; metres",
        unit: Unit::Own,
        read: realsense::printed,
    },
    Row {
        name: "RealSense sensors",
        keys: &["rs sensors"],
        says: "output of rs-sensor-control: left stream, right stream, left to right; metres",
        unit: Unit::Own,
        read: realsense::sensors,
    },
    Row {
        name: "RealSense table",
        keys: &realsense::TABLE,
        says: "JSON of the calibration table; rectified streams, the size tells the mode; baseline in millimetres",
        unit: Unit::Own,
        read: realsense::table,
    },
    Row {
        name: "MYNT EYE",
        keys: &["Intrinsics left"],
        says: "output of get_img_params; Extrinsics right to left hold R and T of OpenCV; millimetres",
        unit: Unit::Own,
        read: mynt::rig,
    },
    Row {
        name: "ORB-SLAM3",
        keys: &["Camera1.fx", "Camera2.fx", "Stereo.T_c1_c2", "Stereo.b", "Tlr"],
        says: "settings; Stereo.T_c1_c2 (Tlr): right to left; metres",
        unit: Unit::Own,
        read: orbslam::third,
    },
    Row {
        name: "ORB-SLAM2",
        keys: &["LEFT.K", "Camera.fx", "Camera.bf"],
        says: "settings, also of stella_vslam; LEFT and RIGHT with K D R P, StereoRectifier, or rectified with Camera.bf or focal_x_baseline; metres",
        unit: Unit::Own,
        read: orbslam::second,
    },
    Row {
        name: "VINS-Fusion",
        keys: &["body_T_cam0", "cam0_calib"],
        says: "the configuration, its camera files beside it; body_T_cam: camera to body; metres",
        unit: Unit::Own,
        read: vins::rig,
    },
    Row {
        name: "Basalt",
        keys: &["value0"],
        says: "JSON; T_imu_cam: camera to IMU; metres",
        unit: Unit::Own,
        read: basalt::rig,
    },
    Row {
        name: "OKVIS, maplab, Spectacular AI, Monado",
        keys: &["cameras"],
        says: "list `cameras`; T_SC, T_B_C: camera to body; imuToCamera: IMU to camera; opencv_stereo_calibrate: as OpenCV; metres",
        unit: Unit::Own,
        read: camera_list::rig,
    },
    Row {
        name: "Bouguet",
        keys: &["fc_left"],
        says: "Calib_Results_stereo of the MATLAB toolbox; x_r = R(om) x_l + T; unit of the board",
        unit: Unit::Given,
        read: bouguet::rig,
    },
    Row {
        name: "MC-Calib",
        keys: &["camera_0", "camera_1", "nb_camera"],
        says: "calibrated_cameras_data.yml; camera_pose_matrix: camera to reference; unit of the board",
        unit: Unit::Given,
        read: mc_calib::rig,
    },
    Row {
        name: "ZED",
        keys: &[
            "LEFT_CAM_HD",
            "LEFT_CAM_FHD",
            "LEFT_CAM_2K",
            "LEFT_CAM_VGA",
            "LEFT_CAM_FHD1200",
            "LEFT_CAM_SVGA",
            "STEREO",
        ],
        says: "SN*.conf, the size tells the resolution; R of (RX, CV, RZ), T = -(Baseline, TY, TZ); millimetres",
        unit: Unit::Own,
        read: zed::rig,
    },
    Row {
        name: "COLMAP",
        keys: &["rigs.txt", "cameras.txt", ""],
        says: "cameras.txt with rigs.txt or rig_config.json; sensor_from_rig; (0, 0) is the corner of the first pixel; unit of the model",
        unit: Unit::Given,
        read: colmap::rig,
    },
    Row {
        name: "Kalibr, OpenVINS",
        keys: &["cam0", "cam1"],
        says: "camchain.yaml, results-cam.txt: T_cn_cnm1 of cam1 takes points of cam0 (left) to cam1 (right); without it T_cam_imu: IMU to camera, or T_imu_cam: camera to IMU; metres",
        unit: Unit::Own,
        read: kalibr::rig,
    },
    Row {
        name: "ROS",
        keys: &["camera_matrix", "projection_matrix"],
        says: "left.yaml and right.yaml: R = R_r^T R_l, t = -(first row of R_r) of the rectification matrices, `P[0][3] = -fx b` of the right camera; above each other: `P[1][3]`; metres, or --unit",
        unit: Unit::Given,
        read: ros::rig,
    },
    Row {
        name: "ROS echo",
        keys: &["P", "p"],
        says: "left and right camera_info as `ros2 topic echo` or `rostopic echo` print them; as ROS",
        unit: Unit::Given,
        read: ros::echoed,
    },
    Row {
        name: "OpenCV",
        keys: &opencv::KEYS,
        says: "intrinsics.yml and extrinsics.yml, one file of both, or XML: M1 D1 M2 D2 R T; x_2 = R x_1 + T, the left camera first; without R the rectification R1 R2 P2; unit of the board",
        unit: Unit::Given,
        read: opencv::rig,
    },
    Row {
        name: "lists",
        keys: &opencv::LISTS,
        says: "K1 D1 K2 D2 R T as lists in JSON, YAML or name = [[..]], also as cameraMatrix1, distCoeffs1, ..; as OpenCV",
        unit: Unit::Given,
        read: opencv::rig,
    },
];

/// The list of the formats, one a line, for the help.
#[must_use]
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
            format!(
                "{} ({})",
                row.name,
                row.keys
                    .iter()
                    .filter(|key| !key.is_empty())
                    .take(3)
                    .copied()
                    .collect::<Vec<_>>()
                    .join(", ")
            )
        });
        bail!(
            "{files}: the keys ({}) belong to no known format. Known formats: {}. Write the numbers as K1 D1 K2 D2 R T, \
             or see `selfcal import --help`",
            keys.join(", "),
            known.collect::<Vec<_>>().join("; ")
        );
    };
    ensure!(
        row.unit == Unit::Given || unknowns.unit_m.to_bits() == 1.0_f64.to_bits(),
        "{files}: --unit {}: a file of {} has its own unit; leave --unit out",
        unknowns.unit_m,
        row.name
    );
    (row.read)(files, unknowns).with_context(|| format!("the rig of {files} ({})", row.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_format_has_a_name_keys_and_a_line_in_the_list() {
        let list = list();
        for row in &FORMATS {
            assert!(
                !row.keys.is_empty() && list.contains(row.name) && list.contains(row.says),
                "{}",
                row.name
            );
        }
    }
}
