//! The rig of `samples` in the files of camera vendors' tools.

pub(crate) const ZED: &str = "[LEFT_CAM_HD]
fx=700.5
fy=700.1
cx=640.25
cy=360.5
k1=-0.17
k2=0.027
p1=0.0001
p2=-0.0002
k3=0

[RIGHT_CAM_HD]
fx=701.5
fy=701.1
cx=641.25
cy=361.5
k1=-0.16
k2=0.026
p1=0
p2=0
k3=0

[LEFT_CAM_VGA]
fx=350.25
fy=350.05
cx=336
cy=188
k1=-0.17
k2=0.027

[RIGHT_CAM_VGA]
fx=350.75
fy=350.55
cx=336
cy=188
k1=-0.16
k2=0.026

[STEREO]
Baseline=120
TY=-10
TZ=-20
CV_HD=0
RX_HD=0.6435011087932844
RZ_HD=0
CV_VGA=0
RX_VGA=0.6435011087932844
RZ_VGA=0
";

pub(crate) const REALSENSE: &str = r#"{"left": {"width": 848, "height": 480, "ppx": 424.5, "ppy": 241.0, "fx": 425.0, "fy": 425.5,
  "model": "Brown Conrady", "coeffs": [0.01, -0.02, 0.0001, 0.0, 0.0]},
 "right": {"width": 848, "height": 480, "ppx": 423.5, "ppy": 240.0, "fx": 426.0, "fy": 426.5,
  "model": "Brown Conrady", "coeffs": [0.0, 0.0, 0.0, 0.0, 0.0]},
 "extrinsics": {"rotation": [1.0, 0.0, 0.0, 0.0, 0.8, 0.6, 0.0, -0.6, 0.8], "translation": [-0.12, 0.01, 0.02]}}
"#;

pub(crate) const REALSENSE_TEXT: &str = " Intrinsic of \"Infrared 1\" / 848x480 / {Y8}
  Width:      \t848
  Height:     \t480
  PPX:        \t424.5
  PPY:        \t241
  Fx:         \t425
  Fy:         \t425.5
  Distortion: \tBrown Conrady
  Coeffs:     \t0  \t0  \t0  \t0  \t0
  FOV (deg):  \t89.9 x 58.8

 Intrinsic of \"Infrared 2\" / 848x480 / {Y8}
  Width:      \t848
  Height:     \t480
  PPX:        \t423.5
  PPY:        \t240
  Fx:         \t426
  Fy:         \t426.5
  Distortion: \tBrown Conrady
  Coeffs:     \t0  \t0  \t0  \t0  \t0
  FOV (deg):  \t89.9 x 58.8

Extrinsic from \"Infrared 1\"\t  To\t  \"Infrared 1\" :
 Rotation Matrix:
   1                0                0
   0                1                0
   0                0                1
 Translation Vector: 0  0  0

Extrinsic from \"Infrared 1\"\t  To\t  \"Infrared 2\" :
 Rotation Matrix:
   1                0                0
   0                0.8             -0.6
   0                0.6              0.8
 Translation Vector: -0.12  0.01  0.02
";

pub(crate) const SENSOR_CONTROL: &str = "Principal Point         : 424.5, 241
Focal Length            : 425, 425.5
Distortion Model        : Kannala Brandt4
Distortion Coefficients : [-0.011,0.05,-0.047,0.009,0]
Principal Point         : 423.5, 240
Focal Length            : 426, 426.5
Distortion Model        : Kannala Brandt4
Distortion Coefficients : [-0.009,0.046,-0.043,0.008,0]
Translation Vector : [-0.12,0.01,0.02]
Rotation Matrix    : [1,0,0]
                   : [0,0.8,-0.6]
                   : [0,0.6,0.8]
";

/// Left (1) and right (2) lead to the camera in the middle (0).
pub(crate) const LUXONIS: &str = r#"{"cameraData": [
 [0, {"cameraType": 0, "distortionCoeff": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], "width": 1280, "height": 800,
  "intrinsicMatrix": [[780.0, 0.0, 640.0], [0.0, 780.0, 400.0], [0.0, 0.0, 1.0]],
  "extrinsics": {"rotationMatrix": [[0, 0, 0], [0, 0, 0], [0, 0, 0]], "toCameraSocket": -1, "translation": {"x": 0, "y": 0, "z": 0}}}],
 [1, {"cameraType": 0, "distortionCoeff": [4.9, 1.3, -1e-05, 1e-04, 0.01, 5.3, 2.9, 0.16, 0, 0, 0, 0, 0, 0], "width": 1280, "height": 800,
  "intrinsicMatrix": [[571.0, 0.0, 635.0], [0.0, 571.0, 400.0], [0.0, 0.0, 1.0]],
  "extrinsics": {"rotationMatrix": [[1.0, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]], "toCameraSocket": 0, "translation": {"x": -7.0, "y": 1.0, "z": 2.0}}}],
 [2, {"cameraType": 0, "distortionCoeff": [4.9, 1.3, -1e-05, 1e-04, 0.01, 5.3, 2.9, 0.16, 0, 0, 0, 0, 0, 0], "width": 1280, "height": 800,
  "intrinsicMatrix": [[577.0, 0.0, 627.0], [0.0, 577.0, 410.0], [0.0, 0.0, 1.0]],
  "extrinsics": {"rotationMatrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "toCameraSocket": 0, "translation": {"x": 5.0, "y": 0, "z": 0}}}]],
 "stereoRectificationData": {"leftCameraSocket": 255, "rightCameraSocket": -1}}
"#;

/// Output of `get_img_params`, whose log adds the prefixes.
pub(crate) const MYNT: &str = "I0904 17:05:57.1 12659 utils.cc:43] Only one MYNT EYE device, select index: 0
I0904 17:05:57.2 12659 get_img_params.cc:25] Intrinsics left: {width: 752, height: 480, fx: 353.25, fy: 353.75, cx: 366.5, cy: 231.25, model: 0, coeffs: [-0.27, 0.057, -0.00073, -0.00033, 0.0]}
I0904 17:05:57.2 12659 get_img_params.cc:26] Intrinsics right: {equidistant, width: 752, height: 480, k2: -0.024, k3: 0.002, k4: -0.003, k5: -0.0002, mu: 366.5, mv: 366.75, u0: 388.25, v0: 236.5}
I0904 17:05:57.2 12659 get_img_params.cc:28] Extrinsics right to left: {rotation: [1.0, 0.0, 0.0, 0.0, 0.8, -0.6, 0.0, 0.6, 0.8], translation: [-120.0, 10.0, 20.0]}
";

pub(crate) const REALSENSE_TABLE: &str = r#"{"baseline": "-49.9496", "intrinsic_left.x.x": "0.501421", "intrinsic_right.x.x": "0.500943",
 "rectified.0.fx": "970.688", "rectified.0.fy": "970.688", "rectified.0.height": "1080", "rectified.0.ppx": "955.654",
 "rectified.0.ppy": "545.571", "rectified.0.width": "1920", "rectified.1.fx": "647.125", "rectified.1.fy": "647.125",
 "rectified.1.height": "720", "rectified.1.ppx": "637.103", "rectified.1.ppy": "363.714", "rectified.1.width": "1280",
 "rectified.10.fx": "574.322", "rectified.10.fy": "574.322", "rectified.10.height": "0", "rectified.10.ppx": "367.102",
 "rectified.10.ppy": "352.721", "rectified.10.width": "0"}
"#;
