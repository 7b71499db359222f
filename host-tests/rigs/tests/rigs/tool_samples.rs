//! The rig of `samples` in the files of SLAM systems, toolboxes and data sets that share few keys with others.

use rigs::formats::Unknowns;

use crate::device_samples::{MYNT, REALSENSE_TABLE};
use crate::samples::{HALF, Sample, TO_BODY};

/// IMU to left camera, IMU to right camera: the inverses of [`TO_BODY`].
const FROM_BODY: [&str; 2] = [
    "[[0, -1, 0, 0.2], [0, 0, -1, 0.3], [1, 0, 0, -0.1], [0, 0, 0, 1]]",
    "[[0, -1, 0, 0.08], [-0.6, 0, -0.8, 0.31], [0.8, 0, -0.6, 0.12], [0, 0, 0, 1]]",
];

fn okvis() -> String {
    let camera = |n: usize| {
        format!(
            "     - {{T_SC:                  # camera to body\n        [{}],\n        image_dimension: [752, 480],\n        \
             distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05],\n        distortion_type: radialtangential,\n        \
             focal_length: [458.0, 457.0],\n        principal_point: [367.0, 248.0]}}\n\n",
            TO_BODY[n]
        )
    };
    format!("%YAML:1.0\ncameras:\n{}{}imu_params:\n    a_max: 176.0\n", camera(0), camera(1))
}

fn maplab() -> String {
    let camera = |n: usize| {
        format!(
            "- camera:\n    label: cam{n}\n    image_height: 480\n    image_width: 752\n    type: pinhole\n    intrinsics:\n      \
             cols: 1\n      rows: 4\n      data: [458.0, 457.0, 367.0, 248.0]\n    distortion:\n      type: equidistant\n      \
             parameters:\n        cols: 1\n        rows: 4\n        data: [-0.05, 0.046, -0.083, 0.056]\n  T_B_C:\n    cols: 4\n    \
             rows: 4\n    data: [{}]\n",
            TO_BODY[n]
        )
    };
    format!("label: rig\nid: 0\ncameras:\n{}{}", camera(0), camera(1))
}

fn spectacular() -> String {
    let camera = |n: usize| {
        format!(
            "{{\"model\": \"kannala-brandt4\", \"focalLengthX\": 285.0, \"focalLengthY\": 285.25, \"principalPointX\": 416.5, \
             \"principalPointY\": 395.75, \"distortionCoefficients\": [-0.005, 0.04, -0.037, 0.006], \"imageWidth\": 848, \
             \"imageHeight\": 800, \"imuToCamera\": {}}}",
            FROM_BODY[n]
        )
    };
    format!("{{\"cameras\": [{}, {}]}}\n", camera(0), camera(1))
}

const MONADO: &str = r#"{"metadata": {"version": 2}, "cameras": [
 {"model": "fisheye_equidistant4", "intrinsics": {"fx": 300.0, "fy": 301.0, "cx": 320.0, "cy": 240.0},
  "distortion": {"k1": 0.01, "k2": 0.02, "k3": -0.03, "k4": 0.004}, "resolution": {"width": 640, "height": 480}},
 {"model": "pinhole_radtan5", "intrinsics": {"fx": 300.0, "fy": 301.0, "cx": 320.0, "cy": 240.0},
  "distortion": {"k1": 0.1, "k2": -0.02, "p1": 0.001, "p2": 0.002, "k3": 0.3}, "resolution": {"width": 640, "height": 480}}],
 "opencv_stereo_calibrate": {"rotation": [1.0, 0.0, 0.0, 0.0, 0.8, -0.6, 0.0, 0.6, 0.8], "translation": [-0.12, 0.01, 0.02]}}
"#;

fn kalibr_report() -> String {
    let [c, s] = HALF;
    let camera = |n: usize, class: &str| {
        format!(
            "\tcam{n} (/cam{n}/image_raw):\n\t type: <class 'aslam_cv.libaslam_cv_python.{class}CameraGeometry'>\n\t distortion: \
             [-0.28 0.07 0.0002 1.8e-05] +- [ 0.1 0.2 0.3 0.4]\n\t projection: [458. 457. 367. 248.] +- [ 0.1 0.2 0.3 0.4]\n\t \
             reprojection error: [0.000121, -0.000036] +- [0.38, 0.32]\n\n"
        )
    };
    format!(
        "Calibration results \n====================\nCamera-system parameters:\n{}{}\tbaseline T_1_0:\n\t q: [-{s} 0. 0. {c}] +- \
         [0.0015 0.0003 0.0001]\n\t t: [-0.12 0.01 0.02] +- [0.0001 0.0001 0.0003]\n\n\n\nTarget configuration\n\
         ====================\n\n  Type: aprilgrid\n  Tags: \n    Rows: 4\n    Size: 0.02 [m]\n",
        camera(0, "DistortedPinhole").replace(" +- [ 0.1 0.2", " +- [ 9.1 9.2"),
        camera(1, "EquidistantDistortedPinhole"),
    )
}

const STELLA: &str = "Camera:
  name: T265
  setup: stereo
  model: perspective
  fx: 400.0
  fy: 400.0
  cx: 367.0
  cy: 252.0
  cols: 752
  rows: 480
  focal_x_baseline: 48.0

StereoRectifier:
  model: fisheye
  K_left: [458.0, 0.0, 367.0, 0.0, 457.0, 248.0, 0.0, 0.0, 1.0]
  D_left: [-0.01, 0.046, -0.044, 0.008]
  R_left: [0.8, 0.6, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 1.0]
  K_right: [459.0, 0.0, 367.0, 0.0, 457.0, 248.0, 0.0, 0.0, 1.0]
  D_right: [-0.01, 0.046, -0.044, 0.008]
  R_right: [1.0, 0.0, 0.0,
            0.0, 1.0, 0.0,
            0.0, 0.0, 1.0]
";

/// `R1`, `R2` and `P2` in place of `R` and `T`.
const RECTIFICATION: &str = "image_width: 800
image_height: 592
M1: [654.5, 0.0, 408.5, 0.0, 654.0, 298.5, 0.0, 0.0, 1.0]
D1: [-0.066, 0.11, 0.0003, 0.001, -0.048]
M2: [655.5, 0.0, 409.5, 0.0, 655.0, 301.5, 0.0, 0.0, 1.0]
D2: [-0.066, 0.11, 0.0003, 0.001, -0.048]
R1: [0.8, 0.6, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 1.0]
R2: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P1: [400.0, 0.0, 397.5, 0.0, 0.0, 400.0, 296.0, 0.0, 0.0, 0.0, 1.0, 0.0]
P2: [400.0, 0.0, 397.5, -48.0, 0.0, 400.0, 296.0, 0.0, 0.0, 0.0, 1.0, 0.0]
";

const BOUGUET: &str = "% Stereo calibration parameters:

% Intrinsic parameters of left camera:
fc_left = [ 767.5 764.25 ]; % Focal Length
cc_left = [ 314.0 205.25 ]; % Principal point
alpha_c_left = [ 0.000000 ]; % Skew
kc_left = [ -0.29 0.1 0.0008 -0.0003 0.000000 ]; % Distortion

% Intrinsic parameters of right camera:
fc_right = [ 780.0 777.75 ]; % Focal Length
cc_right = [ 287.75 188.75 ]; % Principal point
alpha_c_right = [ 0.000000 ]; % Skew
kc_right = [ -0.29 0.11 -0.0006 0.0001 0.000000 ]; % Distortion

% Extrinsic parameters (position of right camera wrt left camera):
om = [ 0.6435011087932844 0.000000 0.000000 ]; % Rotation vector
T = [ -120.0 10.0 20.0 ]; % Translation vector
";

const NUMPY: &str = "image_size: [752 480]
K1:
[[458.   0. 367.]
 [  0. 457. 248.]
 [  0.   0.   1.]]
D1:
[[-2.8e-01  7.0e-02  2.0e-04  1.8e-05  0.0e+00]]
K2:
[[459.   0. 380.]
 [  0. 458. 255.]
 [  0.   0.   1.]]
D2:
[[-0.28 0.07 0.0002 1.8e-05 0.]]
R:
[[ 1.   0.   0. ]
 [ 0.   0.8 -0.6]
 [ 0.   0.6  0.8]]
T:
[[-0.12]
 [ 0.01]
 [ 0.02]]
";

const CITYSCAPES: &str = r#"{"extrinsic": {"baseline": 0.209313, "pitch": 0.038, "roll": 0.0, "x": 1.7, "y": 0.1, "yaw": -0.0195, "z": 1.22},
 "intrinsic": {"fx": 2262.52, "fy": 2265.25, "u0": 1096.98, "v0": 513.137}}
"#;

const K_TXT: &str = "754.668 0.0 489.375 0.0 754.668 265.125 0.0 0.0 1.0\n0.063\n";

/// Rectified cameras 101 and 103, sizes as floats.
const DRIVING: &str = "S_101: 1.762000e+03 8.000000e+02
S_rect_101: 1.762000e+03 8.000000e+02
P_rect_101: 2.0e+03 0.0 9.0e+02 0.0 0.0 2.0e+03 4.0e+02 0.0 0.0 0.0 1.0 0.0
S_rect_103: 1.762000e+03 8.000000e+02
P_rect_103: 2.0e+03 0.0 9.0e+02 -1.08e+03 0.0 2.0e+03 4.0e+02 0.0 0.0 0.0 1.0 0.0
";

/// The formats of these files, each with the size that it lacks.
pub(crate) fn samples() -> Vec<Sample> {
    let sample = |name, file, text: String, size: Option<[u16; 2]>, is_the_rig| Sample {
        name,
        files: vec![(file, text)],
        unknowns: Unknowns { sizes: size.map(|size| [size; 2]), ..Unknowns::default() },
        is_the_rig,
    };
    let mut bouguet =
        sample("Bouguet", "Calib_Results_stereo.txt", BOUGUET.into(), Some([640, 480]), true);
    bouguet.unknowns.unit_m = 0.001;
    vec![
        sample("DrivingStereo", "calib.txt", DRIVING.into(), None, false),
        sample("Cityscapes", "camera.json", CITYSCAPES.into(), Some([2048, 1024]), false),
        sample("K and baseline", "K.txt", K_TXT.into(), Some([960, 540]), false),
        sample("RealSense table", "table.json", REALSENSE_TABLE.into(), Some([1280, 720]), false),
        sample("MYNT EYE", "params.txt", MYNT.into(), None, true),
        sample("OKVIS", "config.yaml", okvis(), None, true),
        sample("maplab", "ncamera.yaml", maplab(), None, true),
        sample("Spectacular AI", "calibration.json", spectacular(), None, true),
        sample("Monado", "calibration.json", MONADO.into(), None, true),
        sample("Kalibr report", "results-cam.txt", kalibr_report(), Some([752, 480]), true),
        sample("stella_vslam", "stella.yaml", STELLA.into(), None, false),
        sample("OpenCV rectification", "rig.yaml", RECTIFICATION.into(), None, false),
        sample("numpy", "rig.txt", NUMPY.into(), None, true),
        bouguet,
    ]
}
