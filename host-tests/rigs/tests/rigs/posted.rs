//! Peculiarities of files that people post, each with the answer from its numbers alone. `host-tests/selfcal/README.md`
//! lists their sources.
#![allow(clippy::float_cmp, reason = "numbers of a file come out as they are")]

use rigs::data::{LensModel, Meta};
use rigs::formats::Unknowns;

use crate::known_answers::{named, near, read, with};
use crate::moved;
use crate::samples::{Sample, size};

fn of_one_file(name: &'static str, text: &str, unknowns: Unknowns) -> anyhow::Result<Meta> {
    let files = vec![(name, text.to_owned())];
    read(&Sample { name, files, unknowns, is_the_rig: false })
}

fn refusal(read: anyhow::Result<Meta>) -> String {
    format!("{:#}", read.unwrap_err())
}

/// The sample with a text added at the end of its first file.
fn and(name: &str, more: &str) -> Sample {
    let mut sample = named(name);
    sample.files[0].1.push_str(more);
    sample
}

#[test]
fn the_quaternion_of_a_kalibr_report_gives_the_matrix_of_its_camchain() {
    // One calibration in both files; the report has eight digits.
    let report = named("Kalibr report").files[0].1.clone();
    let (start, _) = report.split_once("\t q: ").unwrap();
    let text = format!(
        "{start}\t q: [-0.00087935 -0.00270995 -0.0008824   0.99999555] +- [0.0015 0.0003 0.0002]\n\t t: [-0.02997144 -0.00027389  \
         0.00036353] +- [0.0001 0.0001 0.0003]\n"
    );
    let meta = of_one_file("results-cam.txt", &text, size(1280, 720)).unwrap();
    let camchain = [
        [0.999_983_755_079_169_1, -0.001_760_025_638_667_948_3, 0.005_421_428_549_592_495_5],
        [0.001_769_557_576_628_475_4, 0.999_996_896_242_077_9, -0.001_753_901_991_758_743_5],
    ];
    for (read, of_chain) in meta.r.iter().flatten().zip(camchain.iter().flatten()) {
        assert!((read - of_chain).abs() < 3e-8, "{read} {of_chain}");
    }
    assert!(near(moved(&meta, [0.0; 3]), [-0.029_971_44, -0.000_273_89, 0.000_363_53]));
    assert_eq!(meta.lenses(), [LensModel::RadialTangential, LensModel::Fisheye]);
    assert_eq!(meta.dist_l, [-0.28, 0.07, 0.0002, 1.8e-05, 0.0]);
    // In a chain of three, the second step is from cam1 to cam2.
    let chain = report.replace("cam1", "cam2").replace("cam0", "cam1").replace("T_1_0", "T_2_1");
    let unknowns = Unknowns { cameras: Some([1, 2]), ..size(752, 480) };
    let meta = of_one_file("results-cam.txt", &chain, unknowns).unwrap();
    assert!(near(moved(&meta, [0.0, 0.0, 5.0]), [-0.12, -2.99, 4.02]));
    let omni = refusal(read(&with("Kalibr report", "python.Distorted", "python.DistortedOmni")));
    assert!(omni.contains("cam0: camera_model: DistortedOmni"), "{omni}");
}

#[test]
fn a_zed_may_have_one_lens_for_all_modes() {
    let lens = "[LEFT_DISTO]\nk1 = 4.9\nk2 = 1.3\np1 = -1e-05\np2 = 1e-04\nk3 = 0.01\nk4 = 5.3\nk5 = 2.9\nk6 = 0.16\n";
    let meta = read(&and("ZED", lens)).unwrap();
    assert_eq!(meta.lenses(), [LensModel::Rational, LensModel::RadialTangential]);
    assert_eq!(meta.dist_l, [4.9, 1.3, -1e-05, 1e-04, 0.01, 5.3, 2.9, 0.16]);
    assert_eq!((meta.k_l[0][0], meta.dist_r[1]), (700.5, 0.026));
    let prism = refusal(read(&and("ZED", &format!("{lens}s1 = 0.01\n"))));
    assert!(prism.contains("LEFT_DISTO") && prism.contains("thin prism, s1"), "{prism}");
    let fisheye = "[LEFT_DISTO]\nk1=0.1\nk2=0.2\nk3=0.3\nk4=0.4\nk5=0\nk6=0\np1=0\np2=0\n";
    let fisheye = refusal(read(&and("ZED", fisheye)));
    assert!(fisheye.contains("LEFT_DISTO") && fisheye.contains("fisheye"), "{fisheye}");
}

#[test]
fn the_lists_of_cameras_have_their_own_keys_for_the_same_numbers() {
    let okvis = read(&named("OKVIS")).unwrap();
    assert_eq!((okvis.k_r[0][0], okvis.k_r[1][2], okvis.width), (458.0, 248.0, 752));
    assert_eq!(okvis.dist_l, [-0.28, 0.07, 0.0002, 1.8e-05, 0.0]);
    let maplab = read(&named("maplab")).unwrap();
    assert_eq!((maplab.lens, maplab.dist_r[3], maplab.height), (LensModel::Fisheye, 0.056, 480));
    let spectacular = read(&named("Spectacular AI")).unwrap();
    assert_eq!((spectacular.k_l[1][1], spectacular.dist_l[1]), (285.25, 0.04));
    // The pinhole of Spectacular AI has three radial terms.
    let mut pinhole = with("Spectacular AI", "kannala-brandt4", "pinhole");
    pinhole.files[0].1 = pinhole.files[0].1.replace(", 0.006]", "]");
    assert_eq!(read(&pinhole).unwrap().dist_l, [-0.005, 0.04, 0.0, 0.0, -0.037]);
    let monado = read(&named("Monado")).unwrap();
    assert_eq!(monado.lenses(), [LensModel::Fisheye, LensModel::RadialTangential]);
    assert_eq!((monado.dist_l[3], monado.dist_r[4], monado.k_l[1][1]), (0.004, 0.3, 301.0));
    let other = refusal(read(&with("OKVIS", "type: radialtangential", "type: omni")));
    assert!(other.contains("[0]: distortion_type: omni"), "{other}");
}

#[test]
fn mynt_eye_prints_pinholes_and_fisheyes() {
    let meta = read(&named("MYNT EYE")).unwrap();
    assert_eq!(meta.lenses(), [LensModel::RadialTangential, LensModel::Fisheye]);
    assert_eq!((meta.k_l[0][0], meta.k_r[1][2]), (353.25, 236.5));
    assert_eq!((meta.dist_l[1], meta.dist_r), (0.057, vec![-0.024, 0.002, -0.003, -0.0002]));
    // Some devices print the opposite sign.
    let exchanged = refusal(read(&with("MYNT EYE", "[-120.0, 10.0", "[82.3, 10.0")));
    assert!(exchanged.contains("translation") && exchanged.contains("to the left"), "{exchanged}");
}

#[test]
fn a_calibration_table_of_a_realsense_has_a_camera_for_each_size() {
    let mut sample = named("RealSense table");
    let meta = read(&sample).unwrap();
    assert_eq!((meta.k_l, meta.t), (meta.k_r, [-1.0, 0.0, 0.0]));
    assert_eq!((meta.k_l[0][0], meta.k_l[1][2]), (647.125, 363.714));
    assert!(near([meta.baseline_m.unwrap()], [0.049_949_6]));
    sample.unknowns = Unknowns::default();
    let several = refusal(read(&sample));
    assert!(several.contains("--size 1920,1080 or 1280,720"), "{several}");
    let none = refusal(read(&with("RealSense table", "width", "breadth")));
    assert!(none.contains("no rectified stream has both a size"), "{none}");
    let none = refusal(read(&with("ZED", "LEFT_CAM", "MIDDLE_CAM")));
    assert!(none.contains("expected LEFT_CAM_HD or another"), "{none}");
}

#[test]
fn rectified_sets_with_one_camera_have_its_baseline() {
    let meta = read(&named("Cityscapes")).unwrap();
    assert_eq!((meta.k_l[0][0], meta.k_r[1][2], meta.t), (2262.52, 513.137, [-1.0, 0.0, 0.0]));
    assert!(near([meta.baseline_m.unwrap()], [0.209_313]));
    let dsol = read(&named("DSOL")).unwrap();
    assert_eq!((dsol.k_l[1][1], dsol.k_r[0][2], dsol.baseline_m), (435.5, 367.25, Some(0.11)));
    // Shares of the size; DSO's image starts half a pixel before the first centre.
    let dso = read(&named("Stereo-DSO")).unwrap();
    assert_eq!((dso.k_l[0][0], dso.k_l[1][1], dso.k_l[1][2]), (640.0, 300.0, 199.5));
    assert_eq!((dso.sizes(), dso.baseline_m), ([[1280, 400]; 2], Some(0.54)));
    let distorted = refusal(read(&with("Stereo-DSO", "0.5 0.5 0\n", "0.5 0.5 0.9\n")));
    assert!(distorted.contains("rectify them"), "{distorted}");
    let seven = refusal(of_one_file("numbers.txt", "1 2 3\n4 5 6\n7\n", size(9, 9)));
    assert!(seven.contains("7 numbers: expected nine numbers of K"), "{seven}");
    let meta = read(&named("K and baseline")).unwrap();
    assert_eq!((meta.k_l[0][2], meta.k_r[1][1]), (489.375, 754.668));
    assert!(near([meta.baseline_m.unwrap()], [0.063]));
}

#[test]
fn sizes_of_kitti_are_floats_and_cameras_may_be_101_and_103() {
    let meta = read(&named("DrivingStereo")).unwrap();
    assert_eq!(meta.sizes(), [[1762, 800]; 2]);
    assert!(near([meta.baseline_m.unwrap()], [0.54]) && meta.k_r[0][0] == 2000.0);
    let mut kitti = with("DrivingStereo", "_101", "_00");
    kitti.files[0].1 = kitti.files[0].1.replace("_103", "_01");
    let meta = read(&kitti).unwrap();
    assert_eq!(meta.sizes(), [[1762, 800]; 2]);
    let half = refusal(read(&with("DrivingStereo", "S_rect_101: 1.762000e+03", "S_rect_101: 1.5")));
    assert!(half.contains("S_rect_101") && half.contains("width and height"), "{half}");
}

#[test]
fn keys_of_stella_vslam_may_be_nested_or_flat() {
    let nested = read(&named("stella_vslam")).unwrap();
    assert_eq!((nested.lens, nested.k_r[0][0], nested.width), (LensModel::Fisheye, 459.0, 752));
    let text = &named("stella_vslam").files[0].1;
    let mut group = "";
    let mut flat = String::new();
    for line in text.lines() {
        if let Some(key) = line.strip_prefix("  ").filter(|line| !line.starts_with(' ')) {
            flat += &[group, ".", key, "\n"].concat();
        } else if let Some(name) = line.strip_suffix(':') {
            group = name;
        } else {
            flat += &[line, "\n"].concat();
        }
    }
    let flat = of_one_file("stella.yaml", &flat, Unknowns::default()).unwrap();
    assert_eq!((flat.r, flat.t, flat.dist_l), (nested.r, nested.t, nested.dist_l));
}

#[test]
fn millimetres_of_ros_are_metres_with_a_unit() {
    let mut sample = with("ROS echo", "320.0, -48, 0.0", "320.0, -48000.0, 0.0");
    sample.unknowns.unit_m = 0.001;
    assert!(near([read(&sample).unwrap().baseline_m.unwrap()], [0.12]));
    let mut own = named("KITTI");
    own.unknowns.unit_m = 0.001;
    assert!(refusal(read(&own)).contains("leave --unit out"));
}

#[test]
fn a_luxonis_socket_without_rotation_ends_the_chain() {
    // The middle camera was never calibrated: left leads to right, and right with zeros to the middle.
    let mut sample = with(
        "Luxonis",
        "\"toCameraSocket\": 0, \"translation\": {\"x\": -7.0",
        "\"toCameraSocket\": 2, \"translation\": {\"x\": -7.0",
    );
    sample.files[0].1 = sample.files[0].1.replace(
        "[[1, 0, 0], [0, 1, 0], [0, 0, 1]], \"toCameraSocket\": 0",
        "[[0, 0, 0], [0, 0, 0], [0, 0, 0]], \"toCameraSocket\": 0",
    );
    assert!(near(moved(&read(&sample).unwrap(), [0.0; 3]), [-0.07, 0.01, 0.02]));
}

#[test]
fn sockets_and_kinds_of_cameras_may_be_named() {
    let numbers = read(&named("Luxonis")).unwrap();
    let mut sample = with("Luxonis", "\"toCameraSocket\": 0", "\"toCameraSocket\": \"CAM_A\"");
    sample.files[0].1 =
        sample.files[0].1.replace("\"cameraType\": 0", "\"cameraType\": \"Perspective\"");
    let names = read(&sample).unwrap();
    assert_eq!((names.r, names.t, names.lens), (numbers.r, numbers.t, numbers.lens));
    let none = with("Luxonis", "\"toCameraSocket\": 0", "\"toCameraSocket\": \"CAM_Z\"");
    assert!(refusal(read(&none)).contains("toCameraSocket: CAM_Z: expected a finite number"));
}

#[test]
fn a_distortion_model_makes_fisheyes_of_an_opencv_file() {
    let five = [", 1.8e-05, 0.0]]", ", 1.8e-05]]"];
    let mut sample = with("lists in JSON", five[0], five[1]);
    let fisheye = "{\"distortion_model\": \"fisheye\", \"image_size\"";
    sample.files[0].1 = sample.files[0].1.replace("{\"image_size\"", fisheye);
    assert_eq!(read(&sample).unwrap().lenses(), [LensModel::Fisheye; 2]);
    sample.files[0].1 = sample.files[0].1.replace("fisheye", "Brown-Conrady");
    assert_eq!(read(&sample).unwrap().lenses(), [LensModel::RadialTangential; 2]);
    sample.files[0].1 = sample.files[0].1.replace("Brown-Conrady", "omni");
    let other = refusal(read(&sample));
    assert!(other.contains("rig.json: distortion_model: omni"), "{other}");
}

#[test]
fn a_transposed_camera_matrix_is_named() {
    let why = refusal(read(&with(
        "numpy",
        "[[458.   0. 367.]\n [  0. 457. 248.]\n [  0.   0.   1.]]",
        "[[458. 0. 0.]\n [-1.9 457. 0.]\n [367. 248. 1.]]",
    )));
    assert!(why.contains("rig.txt: K1") && why.contains("K is transposed, as MATLAB"), "{why}");
}

#[test]
fn printed_lists_and_tags_without_a_space_are_read() {
    let numpy = read(&named("numpy")).unwrap();
    assert_eq!(
        (numpy.k_r[0][2], numpy.dist_l[3], numpy.sizes()),
        (380.0, 1.8e-05, [[752, 480]; 2])
    );
    // MATLAB prints words before the name and a deviation behind the numbers.
    let mut printed = with(
        "Bouguet",
        "fc_left = [ 767.5 764.25 ];",
        "Focal Length:          fc_left = [ 767.5 764.25 ] ± [ 1.5 1.25 ]",
    );
    assert_eq!(read(&printed).unwrap().k_l[1][1], 764.25);
    printed.files[0].1 = printed.files[0].1.replace("[ 0.000000 ]; % Skew", "[ 0.001 ]; % Skew");
    assert!(refusal(read(&printed)).contains("alpha_c_left: 0.001: a skew is not supported"));
    let tag = with("VINS-Fusion", ": !!opencv-matrix", ":!!opencv-matrix");
    assert!(near(moved(&read(&tag).unwrap(), [0.0, 0.0, 5.0]), [-0.12, -2.99, 4.02]));
    // A rotation vector in place of a matrix.
    let vector = with(
        "OpenCV XML",
        "<rows>3</rows><cols>3</cols><dt>d</dt><data>\n    1. 0. 0. 0. 0.8 -0.6 0. 0.6 0.8",
        "<rows>3</rows><cols>1</cols><dt>d</dt><data>\n    0.6435011087932844 0. 0.",
    );
    assert!(near(moved(&read(&vector).unwrap(), [0.0, 0.0, 5.0]), [-0.12, -2.99, 4.02]));
}

#[test]
fn texts_and_arrays_that_are_not_read_are_refused_with_the_names_to_use() {
    let text = "[Left Camera Intrinsic]\n578.457 0 346.077\n0 571.928 250.389\n0 0 1\n[Right to Left Camera Translate]\n-24.8819 0.138074 -0.203578\n";
    let why = refusal(of_one_file("camera.txt", text, Unknowns::default()));
    assert!(why.contains("camera.txt") && why.contains("K1 D1 K2 D2 R T"), "{why}");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("stereo.npz");
    std::fs::write(&path, b"PK\x03\x04\xff\xfe").unwrap();
    let why = refusal(rigs::formats::import(&[path], Unknowns::default()));
    assert!(why.contains("stereo.npz") && why.contains("K1 D1 K2 D2 R T"), "{why}");
}

#[test]
fn models_of_structure_from_motion_have_the_lenses_of_their_tools() {
    let mvg = read(&named("openMVG")).unwrap();
    assert_eq!(mvg.dist_l, [-0.1, 0.02, 0.0, 0.0, 0.003]);
    assert_eq!(mvg.dist_r, [-0.2, 0.03, 0.0005, 0.0006, 0.004]);
    let sfm = read(&named("OpenSfM")).unwrap();
    assert_eq!((sfm.k_l[0][0], sfm.k_l[0][2], sfm.k_l[1][2]), (0.85 * 1920.0, 959.5, 539.5));
    assert_eq!(sfm.dist_r, [-0.02, 0.003, 0.0004, 0.0005, 0.006]);
    assert_eq!((sfm.k_r[1][1], sfm.k_r[1][2]), (0.87 * 1920.0, 539.5 - 0.02 * 1920.0));
    let nerf = read(&named("nerfstudio")).unwrap();
    assert_eq!((nerf.k_l[0][0], nerf.k_r[0][0], nerf.k_r[0][2]), (900.5, 910.5, 639.5));
    // More views than two are chosen by their numbers.
    let more = "{\"file_path\": \"images/left.png\",";
    let three = with("nerfstudio", more, &format!("{{\"transform_matrix\": 0}}, {more}"));
    let why = refusal(read(&three));
    assert!(why.contains("3 cameras: choose the left and the right one from 0 to 2"), "{why}");
    let chosen = Unknowns { cameras: Some([1, 2]), ..three.unknowns };
    let chosen = read(&Sample { unknowns: chosen, ..three }).unwrap();
    assert!(near(moved(&chosen, [0.0; 3]), [-0.12, 0.01, 0.02]));
}

#[test]
fn a_chain_of_cameras_under_extrinsics_is_composed_between_the_chosen_ones() {
    let mut sample = with(
        "DSEC",
        "intrinsics:\n",
        "  T_21:\n  - [1, 0, 0, -0.5]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\nintrinsics:\n",
    );
    let (start, right) = sample.files[0].1.split_once("  cam1:\n").unwrap();
    sample.files[0].1 = format!("{start}  cam1:\n{right}  cam2:\n{right}");
    assert!(refusal(read(&sample)).contains("3 cameras: choose"));
    sample.unknowns.cameras = Some([0, 2]);
    assert!(near(moved(&read(&sample).unwrap(), [0.0; 3]), [-0.62, 0.01, 0.02]));
}

#[test]
fn a_key_of_several_formats_tells_none_and_two_candidates_are_named() {
    // `extrinsics` alone tells no format.
    let why = refusal(of_one_file("rig.yaml", "extrinsics: {rotation_lr: 1}\n", size(9, 9)));
    assert!(why.contains("(extrinsics) belong to no known format"), "{why}");
    let both = and("ORB-SLAM3", "T_BS: [1]\nT_cn: 1\n");
    assert!(read(&both).is_ok(), "the one that can be read");
    let none = refusal(of_one_file("rig.yaml", "T_BS: 1\nfc_left: 2\n", size(9, 9)));
    assert!(none.contains("keys of EuRoC; and of Bouguet") && none.contains("; or: "), "{none}");
}

#[test]
fn a_rotation_of_few_digits_is_made_orthonormal_and_noted() {
    let few = read(&with("OpenVINS", "0.6", "0.599")).unwrap();
    let off = few.other[Meta::ROUNDED].as_f64().unwrap();
    assert!((1e-3..2e-3).contains(&off), "{off}");
    let row = few.r[1].iter().map(|x| x * x).sum::<f64>();
    assert!((row - 1.0).abs() < 1e-12, "{row}");
    assert_eq!(read(&named("OpenVINS")).unwrap().other.get(Meta::ROUNDED), None);
    let mirrored = refusal(read(&with("DSEC", "[1, 0, 0, -0.12]", "[-1, 0, 0, -0.12]")));
    assert!(mirrored.contains("left-handed, as those of Unity"), "{mirrored}");
}

#[test]
fn texts_of_utf_16_are_read_and_a_parser_keeps_its_words() {
    let text = &named("DSEC").files[0].1;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("cam_to_cam.yaml");
    for (mark, bytes) in [
        ([0xff, 0xfe], u16::to_le_bytes as fn(u16) -> [u8; 2]),
        ([0xfe, 0xff], u16::to_be_bytes as fn(u16) -> [u8; 2]),
    ] {
        let wide: Vec<u8> = text.encode_utf16().flat_map(bytes).collect();
        std::fs::write(&path, [&mark[..], &wide].concat()).unwrap();
        assert!(rigs::formats::import(&[&path], Unknowns::default()).is_ok());
    }
    std::fs::write(&path, text.replace('8', "\0")).unwrap();
    assert!(refusal(rigs::formats::import(&[&path], Unknowns::default())).contains("not text"));
    for (name, text, said) in [
        ("a.json", "{\"a\": [1, }", "not JSON: line 1 cannot be read at column 11;"),
        ("a.yaml", "a: [1\nb: }\n", "cannot be read; give"),
        ("a.xml", "<a>\n<b></a>", "not XML: line 2 cannot be read;"),
    ] {
        let why = refusal(of_one_file(name, text, Unknowns::default()));
        assert!(why.contains(said), "{why}");
    }
}

#[test]
fn four_mebibytes_of_document_marks_are_refused_at_once() {
    // Counted in passes over the text: a second pass for each mark would be 10^12 steps.
    let why = refusal(of_one_file("rig.yaml", &"---\n".repeat(1 << 20), Unknowns::default()));
    assert!(why.contains("rig.yaml"), "{why}");
}

#[test]
fn four_coefficients_without_a_name_are_doubted() {
    let file = |more: &str| {
        let lists = r#"{"image_size": [960, 600], "K1": [227, 0, 472, 0, 227, 307, 0, 0, 1], "D1": [0.01, 0.003, -0.006, 0.001],
            "K2": [227, 0, 478, 0, 227, 307, 0, 0, 1], "D2": [0.01, 0.003, -0.006, 0.001],
            "R": [1, 0, 0, 0, 1, 0, 0, 0, 1], "T": [-0.11, 0, 0]"#;
        of_one_file("stereo.json", &format!("{lists}{more}}}"), Unknowns::default()).unwrap()
    };
    let unnamed = file("");
    assert_eq!(unnamed.lenses(), [LensModel::RadialTangential; 2]);
    let told = rigs::doubts(&unnamed);
    assert!(told.len() == 1 && told[0].contains("distortion_model: equidistant"), "{told:?}");
    for key in ["distortion_model", "lens_model", "camera_model", "model", "lens"] {
        let named = file(&format!(r#", "{key}": "fisheye""#));
        assert_eq!(
            (named.lenses(), rigs::doubts(&named)),
            ([LensModel::Fisheye; 2], vec![]),
            "{key}"
        );
    }
    for key in ["fisheye", "is_fisheye", "fisheye_model"] {
        assert_eq!(file(&format!(r#", "{key}": true"#)).lenses(), [LensModel::Fisheye; 2], "{key}");
        assert_eq!(file(&format!(r#", "{key}": 0"#)).lenses(), [LensModel::RadialTangential; 2]);
    }
    let omni = r#"{"K1": [1], "distortion_model": "omni"}"#;
    let omni = refusal(of_one_file("a.json", omni, size(9, 9)));
    assert!(omni.contains("calibrate with one of them"), "{omni}");
    // A product is no lens model.
    let product = file(r#", "model": "D435", "camera_model": "Brio""#);
    assert_eq!(rigs::doubts(&product).len(), 1);
}

#[test]
fn raw_numbers_win_over_rectified_ones_of_the_same_file_and_the_others_are_told() {
    let mut both = named("lists in JSON");
    both.files[0].1 = both.files[0].1.replacen('{', r#"{"Camera.fx": 400, "Camera.fy": 400, "Camera.cx": 367, "Camera.cy": 252, "Camera.width": 752, "Camera.height": 480, "Camera.bf": 48, "#, 1);
    let meta = read(&both).unwrap();
    assert!(
        meta.source.starts_with("OpenCV")
            && near(moved(&meta, [0.0, 0.0, 5.0]), [-0.12, -2.99, 4.02])
    );
    let told = rigs::doubts(&meta);
    assert!(told.len() == 1 && told[0].contains("keys of ORB-SLAM3, ORB-SLAM2"), "{told:?}");
}

#[test]
fn cameras_of_opencv_may_be_numbered_from_0_and_exchanged() {
    let mut from_0 = named("lists in JSON");
    for (one, other) in [("K1", "K0"), ("K2", "K1"), ("D1", "D0"), ("D2", "D1")] {
        from_0.files[0].1 =
            from_0.files[0].1.replace(&format!("\"{one}\""), &format!("\"{other}\""));
    }
    let meta = read(&from_0).unwrap();
    assert_eq!([meta.k_l[0][0], meta.k_r[0][0]], [458.0, 459.0]);
    let mut exchanged =
        with("lists in JSON", "[[-0.12], [0.01], [0.02]]", "[[0.12], [0.01], [0.02]]");
    let why = refusal(read(&exchanged));
    assert!(why.contains("to the left") && why.ends_with("(--cameras 1,0)"), "{why}");
    exchanged.unknowns.cameras = Some([1, 0]);
    let meta = read(&exchanged).unwrap();
    assert_eq!([meta.k_l[0][0], meta.k_r[0][0]], [459.0, 458.0]);
    // The first camera is the right one: x_r = R^T (x_l - T).
    assert!(near(moved(&meta, [0.12, 0.01, 5.02]), [0.0, 3.0, 4.0]), "{:?}", meta.t);
    let exchanged = Unknowns { cameras: Some([1, 0]), ..Unknowns::default() };
    let words = with("named keys", "[-120.0, 10.0, 20.0]", "[120.0, 10.0, 20.0]");
    let meta = read(&Sample { unknowns: exchanged, ..words }).unwrap();
    assert_eq!([meta.k_l[0][0], meta.k_r[0][0]], [459.0, 458.0]);
    let euroc = Sample {
        unknowns: Unknowns { cameras: Some([1, 0]), ..Unknowns::default() },
        ..named("EuRoC")
    };
    let why = refusal(read(&euroc));
    assert!(why.contains("leave --cameras out"), "{why}");
}

#[test]
fn keys_whose_words_tell_them_are_named_and_two_candidates_refused() {
    let meta = read(&named("named keys")).unwrap();
    let told = rigs::doubts(&meta);
    assert!(
        told.len() == 1 && told[0].contains("stereo.rotation_matrix, stereo.translation_mm"),
        "{told:?}"
    );
    let two = with(
        "named keys",
        "\"stereo\": {",
        "\"stereo\": {\"rotation\": [1, 0, 0, 0, 1, 0, 0, 0, 1], ",
    );
    let why = refusal(read(&two));
    assert!(why.contains("stereo.rotation; or stereo.rotation_matrix"), "{why}");
    let none = refusal(read(&with("named keys", "translation_mm", "offset")));
    assert!(none.contains("T (3 x 1): no key tells which these are"), "{none}");
}

#[test]
fn an_error_of_unknown_keys_names_those_of_matrices_first() {
    let text = r#"{"a": 1, "b": 2, "c": 3, "d": 4, "e": 5, "f": 6, "g": 7, "h": 8, "i": 9, "j": 10, "k": 11, "l": 12,
        "pose": {"matrix_of_both": [1, 0, 0, 0, 1, 0, 0, 0, 1]}}"#;
    let why = refusal(of_one_file("rig.json", text, Unknowns::default()));
    assert!(why.contains("the keys (pose.matrix_of_both, a, b"), "{why}");
    let why = refusal(of_one_file("rig.txt", "Left image at night\n", Unknowns::default()));
    assert!(!why.contains("keys ()"), "{why}");
}
