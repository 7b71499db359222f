//! A sample of each format, most of them of one made-up rig.
//!
//! `R` turns about x by an angle of the 3-4-5 triangle, `T` = (-0.12, 0.01, 0.02) m: the point (0, 0, 5) of the left
//! camera is at (-0.12, -2.99, 4.02) in the right one, whose centre is (0.12, -0.02, -0.01) in the left frame. If a
//! file has a body frame, the left camera is at (0.1, 0.2, 0.3) in it, with its z along the body's x.

use rigs::formats::Unknowns;

use crate::device_samples::{LUXONIS, REALSENSE, REALSENSE_TEXT, SENSOR_CONTROL, ZED};
use crate::examples::{KALIBR, OPENCV, ROS};
use crate::tool_samples;

/// A format: its name, its files, the values that they lack, and whether it has `R` and `T` of the rig above.
pub(crate) struct Sample {
    pub(crate) name: &'static str,
    pub(crate) files: Vec<(&'static str, String)>,
    pub(crate) unknowns: Unknowns,
    pub(crate) is_the_rig: bool,
}

/// Left camera to body, right camera to body.
pub(crate) const TO_BODY: [&str; 2] = [
    "0.0, 0.0, 1.0, 0.1, -1.0, 0.0, 0.0, 0.2, 0.0, -1.0, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0",
    "0.0, -0.6, 0.8, 0.09, -1.0, 0.0, 0.0, 0.08, 0.0, -0.8, -0.6, 0.32, 0.0, 0.0, 0.0, 1.0",
];

/// Right camera to the left one.
const TO_LEFT: &str =
    "1.0, 0.0, 0.0, 0.12, 0.0, 0.8, 0.6, -0.02, 0.0, -0.6, 0.8, -0.01, 0.0, 0.0, 0.0, 1.0";

/// Cosine and sine of half of the angle.
pub(crate) const HALF: [&str; 2] = ["0.9486832980505138", "0.31622776601683794"];

fn rows(sixteen: &str) -> String {
    let numbers: Vec<&str> = sixteen.split(", ").collect();
    let row = |four: &[&str]| format!("  - [{}]\n", four.join(", "));
    numbers.chunks(4).map(row).collect()
}

fn storage(name: &str, [r, c]: [usize; 2], data: &str) -> String {
    format!("{name}: !!opencv-matrix\n   rows: {r}\n   cols: {c}\n   dt: d\n   data: [ {data} ]\n")
}

fn openvins() -> String {
    let cam = |n: usize| {
        format!(
            "cam{n}:\n  T_imu_cam:\n{}  camera_model: pinhole\n  distortion_coeffs: [-0.2, 0.07, 1e-4, 2e-5]\n  \
             distortion_model: radtan\n  intrinsics: [458.0, 457.0, 367.0, 248.0]\n  resolution: [752, 480]\n",
            rows(TO_BODY[n]).replace("  -", "    -")
        )
    };
    format!("%YAML:1.0\n{}{}", cam(0), cam(1))
}

fn orbslam3() -> String {
    let camera = |name: &str, fx: f64| {
        format!(
            "{name}.fx: {fx}\n{name}.fy: 457.0\n{name}.cx: 367.0\n{name}.cy: 248.0\n{name}.k1: -0.28\n{name}.k2: 0.07\n\
             {name}.p1: 0.0002\n{name}.p2: 1.8e-05\n"
        )
    };
    format!(
        "%YAML:1.0\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\n{}{}Camera.width: 752\nCamera.height: 480\n{}",
        camera("Camera1", 458.0),
        camera("Camera2", 459.0),
        storage("Stereo.T_c1_c2", [4, 4], TO_LEFT)
    )
}

fn orbslam2() -> String {
    let side = |name: &str, r: &str, shift: f64| {
        [
            format!("{name}.height: 480\n{name}.width: 752\n"),
            storage(&format!("{name}.D"), [1, 5], "-0.28, 0.07, 0.0002, 1.8e-05, 0.0"),
            storage(
                &format!("{name}.K"),
                [3, 3],
                "458.0, 0.0, 367.0, 0.0, 457.0, 248.0, 0.0, 0.0, 1.0",
            ),
            storage(&format!("{name}.R"), [3, 3], r),
            storage(
                &format!("{name}.P"),
                [3, 4],
                &format!("400.0, 0.0, 367.0, {shift}, 0.0, 400.0, 252.0, 0.0, 0.0, 0.0, 1.0, 0.0"),
            ),
        ]
        .concat()
    };
    let turned = "0.8, 0.6, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 1.0";
    let plain = "1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0";
    format!(
        "%YAML:1.0\nCamera.bf: 48.0\n{}{}",
        side("LEFT", turned, 0.0),
        side("RIGHT", plain, -48.0)
    )
}

fn vins_camera(k1: &str) -> String {
    format!(
        "%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: camera\nimage_width: 752\nimage_height: 480\n\
         distortion_parameters:\n   k1: {k1}\n   k2: 0.07\n   p1: 0.0002\n   p2: 1.8e-05\n\
         projection_parameters:\n   fx: 458.0\n   fy: 457.0\n   cx: 367.0\n   cy: 248.0\n"
    )
}

fn basalt() -> String {
    let [c, s] = HALF;
    let camera = |fx: f64| {
        format!(
            "{{\"camera_type\": \"kb4\", \"intrinsics\": {{\"fx\": {fx}, \"fy\": 380.0, \"cx\": 510.0, \"cy\": 514.0, \"k1\": 0.01, \
             \"k2\": -0.013, \"k3\": 0.02, \"k4\": -0.01}}}}"
        )
    };
    format!(
        "{{\"value0\": {{\"T_imu_cam\": [{{\"px\": 0.0, \"py\": 0.0, \"pz\": 0.0, \"qx\": 0.0, \"qy\": 0.0, \"qz\": 0.0, \"qw\": 1.0}}, \
         {{\"px\": 0.12, \"py\": -0.02, \"pz\": -0.01, \"qx\": -{s}, \"qy\": 0.0, \"qz\": 0.0, \"qw\": {c}}}], \
         \"intrinsics\": [{}, {}], \"resolution\": [[1024, 1024], [1024, 1024]]}}}}",
        camera(380.0),
        camera(381.0)
    )
}

const COLMAP_CAMERAS: &str = "# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 2
1 OPENCV 752 480 458.0 457.0 367.5 248.5 -0.28 0.07 0.0002 1.8e-05
2 OPENCV 752 480 459.0 458.0 380.5 255.5 -0.28 0.07 0.0002 1.8e-05
";

fn colmap_rigs() -> String {
    let [c, s] = HALF;
    format!(
        "# Rig calib list with one line of data per calib:\n1 2 CAMERA 1 CAMERA 2 1 {c} {s} 0 0 -0.12 0.01 0.02\n"
    )
}

fn colmap_config() -> String {
    let [c, s] = HALF;
    format!(
        "[\n{{\"cameras\": [{{\"image_prefix\": \"left/\", \"ref_sensor\": true}}, {{\"image_prefix\": \"right/\", \
         \"cam_from_rig_rotation\": [{c}, {s}, 0.0, 0.0], \"cam_from_rig_translation\": [-0.12, 0.01, 0.02]}}]}}\n]\n"
    )
}

fn mc_calib() -> String {
    let camera = |n: usize, pose: &str| {
        let indent = |text: String| format!("   {}\n", text.trim_end().replace('\n', "\n   "));
        format!(
            "camera_{n}:\n{}{}   distortion_type: 0\n   camera_group: 0\n   img_width: 1280\n   img_height: 800\n{}",
            indent(storage(
                "camera_matrix",
                [3, 3],
                "900.0, 0.0, 640.0, 0.0, 901.0, 400.0, 0.0, 0.0, 1.0"
            )),
            indent(storage("distortion_vector", [1, 5], "-0.1, 0.02, 0.0001, 0.0002, 0.0")),
            indent(storage("camera_pose_matrix", [4, 4], pose)),
        )
    };
    let here = "1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0";
    let there =
        "1.0, 0.0, 0.0, 120.0, 0.0, 0.8, 0.6, -20.0, 0.0, -0.6, 0.8, -10.0, 0.0, 0.0, 0.0, 1.0";
    format!("%YAML:1.0\n---\nnb_camera: 2\n{}{}", camera(0, here), camera(1, there))
}

const XML: &str = "<?xml version=\"1.0\"?>
<opencv_storage>
<M1 type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>
    458. 0. 367. 0. 457. 248. 0. 0. 1.</data></M1>
<D1 type_id=\"opencv-matrix\"><rows>1</rows><cols>5</cols><dt>d</dt><data>
    -0.28 7.0e-02 2.0e-04 1.8e-05 0.</data></D1>
<M2 type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>
    459. 0. 380. 0. 458. 255. 0. 0. 1.</data></M2>
<D2 type_id=\"opencv-matrix\"><rows>1</rows><cols>5</cols><dt>d</dt><data>
    -0.28 7.0e-02 2.0e-04 1.8e-05 0.</data></D2>
<R type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>
    1. 0. 0. 0. 0.8 -0.6 0. 0.6 0.8</data></R>
<T type_id=\"opencv-matrix\"><rows>3</rows><cols>1</cols><dt>d</dt><data>
    -0.12 0.01 0.02</data></T>
<image_width>752</image_width>
<image_height>480</image_height>
</opencv_storage>
";

const LISTS: &str = r#"{"image_size": [752, 480],
 "K1": [[458.0, 0.0, 367.0], [0.0, 457.0, 248.0], [0.0, 0.0, 1.0]], "D1": [[-0.28, 0.07, 0.0002, 1.8e-05, 0.0]],
 "K2": [[459.0, 0.0, 380.0], [0.0, 458.0, 255.0], [0.0, 0.0, 1.0]], "D2": [-0.28, 0.07, 0.0002, 1.8e-05],
 "R": [[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]], "T": [[-0.12], [0.01], [0.02]]}
"#;

const PYTHON: &str = "width = 752
height = 480
cameraMatrix1 = np.array([[458., 0., 367.],
 [0., 457., 248.],
 [0., 0., 1.]])
distCoeffs1 = [-0.28, 0.07, 0.0002, 1.8e-05, 0.]
cameraMatrix2 = [[459. 0. 380.]
 [0. 458. 255.]
 [0. 0. 1.]]
distCoeffs2 = [-0.28, 0.07, 0.0002, 1.8e-05, 0.]
R = [[1. 0. 0.]
 [0. 0.8 -0.6]
 [0. 0.6 0.8]]
T = [[-0.12], [0.01], [0.02]]
";

fn euroc(side: usize) -> String {
    let lens = "camera_model: pinhole\nintrinsics: [458.0, 457.0, 367.0, 248.0]\ndistortion_model: radial-tangential\n\
                distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]\n";
    format!(
        "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [{}]\nresolution: [752, 480]\n{lens}",
        TO_BODY[side]
    )
}

fn echo(right: bool) -> String {
    let shift = if right { -48.0 } else { 0.0 };
    let r = if right {
        "[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]"
    } else {
        "[0.8, 0.6, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 1.0]"
    };
    format!(
        "header:\n  stamp:\n    sec: 1\n    nanosec: 0\n  frame_id: cam\nheight: 480\nwidth: 640\ndistortion_model: plumb_bob\n\
         d:\n- 0.1\n- -0.02\n- 0.001\n- -0.001\n- 0.0\nk: [400.0, 0.0, 320.0, 0.0, 401.0, 240.0, 0.0, 0.0, 1.0]\nr: {r}\n\
         p: [400.0, 0.0, 320.0, {shift}, 0.0, 400.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]\nbinning_x: 0\nbinning_y: 0\nroi:\n  x_offset: 0\n  \
         do_rectify: false\n---\nheader:\n  stamp:\n    sec: 2\n---\n"
    )
}

const KITTI: &str = "P0: 7.0e+02 0.0 6.0e+02 0.0 0.0 7.0e+02 1.7e+02 0.0 0.0 0.0 1.0 0.0
P1: 7.0e+02 0.0 6.0e+02 -3.78e+02 0.0 7.0e+02 1.7e+02 0.0 0.0 0.0 1.0 0.0
P2: 7.0e+02 0.0 6.0e+02 4.2e+01 0.0 7.0e+02 1.7e+02 0.0 0.0 0.0 1.0 0.0
P3: 7.0e+02 0.0 6.0e+02 -3.36e+02 0.0 7.0e+02 1.7e+02 2.1e+00 0.0 0.0 1.0 0.0
";

const MIDDLEBURY: &str = "cam0=[1000 0 300; 0 1000 250; 0 0 1]
cam1=[1000 0 320; 0 1000 250; 0 0 1]
doffs=20
baseline=160
width=640
height=480
ndisp=64
";

/// All formats.
pub(crate) fn samples() -> Vec<Sample> {
    let lacking = |size: [u16; 2]| Unknowns { sizes: Some([size; 2]), ..Unknowns::default() };
    let none = Unknowns::default();
    let sample = |name, files: &[(&'static str, String)], unknowns, is_the_rig| Sample {
        name,
        files: files.to_vec(),
        unknowns,
        is_the_rig,
    };
    let pair = |files: [(&'static str, &str); 2]| files.map(|(name, text)| (name, text.to_owned()));
    let vins = [
        (
            "config.yaml",
            [
                "%YAML:1.0\nnum_of_cam: 2\ncam0_calib: \"cam0.yaml\"\ncam1_calib: \"cam1.yaml\"\n",
                &storage("body_T_cam0", [4, 4], TO_BODY[0]),
                &storage("body_T_cam1", [4, 4], TO_BODY[1]),
            ]
            .concat(),
        ),
        ("cam0.yaml", vins_camera("-0.28")),
        ("cam1.yaml", vins_camera("-0.29")),
    ];
    let mut all = vec![
        sample("OpenCV", &pair(OPENCV), lacking([640, 480]), true),
        sample("OpenCV XML", &[("stereo.xml", XML.into())], none, true),
        sample("lists in JSON", &[("rig.json", LISTS.into())], none, true),
        sample("lists in text", &[("rig.txt", PYTHON.into())], none, true),
        sample("Kalibr", &[("camchain.yaml", KALIBR.into())], none, true),
        sample("OpenVINS", &[("kalibr_imucam_chain.yaml", openvins())], none, true),
        sample("ROS", &pair(ROS), none, false),
        sample("ROS echo", &[("left.yaml", echo(false)), ("right.yaml", echo(true))], none, false),
        sample("EuRoC", &[("cam0.yaml", euroc(0)), ("cam1.yaml", euroc(1))], none, true),
        sample("ORB-SLAM3", &[("stereo.yaml", orbslam3())], none, true),
        sample("ORB-SLAM2", &[("EuRoC.yaml", orbslam2())], none, false),
        sample("VINS-Fusion", &vins, none, true),
        sample("Basalt", &[("calibration.json", basalt())], none, true),
        sample(
            "MC-Calib",
            &[("calibrated_cameras_data.yml", mc_calib())],
            Unknowns { unit_m: 0.001, ..none },
            true,
        ),
        sample("ZED", &[("SN1234.conf", ZED.into())], lacking([1280, 720]), true),
        sample(
            "COLMAP",
            &[("cameras.txt", COLMAP_CAMERAS.into()), ("rigs.txt", colmap_rigs())],
            none,
            true,
        ),
        sample(
            "COLMAP JSON",
            &[("rig_config.json", colmap_config()), ("cameras.txt", COLMAP_CAMERAS.into())],
            none,
            true,
        ),
        sample("RealSense", &[("realsense.json", REALSENSE.into())], none, true),
        sample("RealSense text", &[("rs.txt", REALSENSE_TEXT.into())], none, true),
        sample(
            "RealSense sensors",
            &[("rs.txt", SENSOR_CONTROL.into())],
            lacking([848, 800]),
            true,
        ),
        sample("Luxonis", &[("calib.json", LUXONIS.into())], none, true),
        sample("KITTI", &[("calib.txt", KITTI.into())], lacking([1241, 376]), false),
        sample("Middlebury", &[("calib.txt", MIDDLEBURY.into())], none, false),
    ];
    all.extend(tool_samples::samples());
    all
}
