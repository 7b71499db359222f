//! Examples of the formats, written by hand.

/// `R` turns about x by an angle of the 3-4-5 triangle: the point (0, 0, 5) of the left camera is at
/// (-0.12, -2.99, 4.02) in the right one.
pub(crate) const OPENCV: [(&str, &str); 2] = [
    (
        "intrinsics.yml",
        "%YAML:1.0
---
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3412667313921163e+02, 0., 3.4201548859968050e+02, 0.,
       5.3408516467213916e+02, 2.3483439129759816e+02, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -2.8300779264055888e-01, 4.2876934286209839e-02,
       1.1016608615996648e-03, -9.5459013250555741e-05,
       1.1493819683832095e-01 ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 537., 0., 326., 0., 538., 249., 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 14
   dt: d
   data: [ -0.3, 0.15, -5.0e-04, 2.5e-04, -0.07, 0., 0., 0., 0., 0., 0., 0., 0., 0. ]
",
    ),
    (
        "extrinsics.yml",
        "%YAML:1.0
---
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 0.8, -0.6, 0., 0.6, 0.8 ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.12, 0.01, 0.02 ]
Q: !!opencv-matrix
   rows: 4
   cols: 4
   dt: d
   data: [ 1., 0., 0., -3.2e+02, 0., 1., 0., -2.4e+02, 0., 0., 0., 5.3e+02, 0., 0., 8., 0. ]
",
    ),
];

/// The same pose.
pub(crate) const KALIBR: &str = "cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
  distortion_model: radtan
  intrinsics: [458.654, 457.296, 367.215, 248.375]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.12]
  - [0.0, 0.8, -0.6, 0.01]
  - [0.0, 0.6, 0.8, 0.02]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.28368365, 0.07451284, -0.00010473, -3.555907e-05]
  distortion_model: radtan
  intrinsics: [457.587, 456.134, 379.999, 255.238]
  resolution: [752, 480]
  rostopic: /cam1/image_raw
  timeshift_cam_imu: 0.0
";

/// `R_l` turns about z by an angle of the 3-4-5 triangle, `R_r` not at all: `R = R_l`. `b` = 48 / 400 m.
pub(crate) const ROS: [(&str, &str); 2] = [
    (
        "left.yaml",
        "image_width: 640
image_height: 480
camera_name: narrow_stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [369.344588, 0, 320.739078, 0, 371.866371, 240.0, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.189544, -0.018229, 0.000630, 0.000054, -0.212483]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [400.0, 0, 320.0, 0, 0, 400.0, 240.0, 0, 0, 0, 1, 0]
",
    ),
    (
        "right.yaml",
        "image_width: 640
image_height: 480
camera_name: narrow_stereo/right
camera_matrix:
  rows: 3
  cols: 3
  data: [370.0, 0, 319.0, 0, 371.0, 241.0, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0, 0, 0, 0, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [400.0, 0, 320.0, -48.0, 0, 400.0, 240.0, 0, 0, 0, 1, 0]
",
    ),
];
