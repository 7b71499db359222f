//! Rigs in the files of other tools, against samples with known answers.

mod known_answers;
mod mutated;
mod posted;
mod rectification;
mod samples;

use std::fs;
use std::path::{Path, PathBuf};

use nalgebra::{Rotation3, Vector3};
use rigs::data::{Dataset, LensModel, Meta, rows};
use rigs::formats::{Document, Format, Unknowns, import};
use samples::{KALIBR, OPENCV, ROS};
use stereo_selfcal::geometry::metrics::Deviation;

const SIZE: Unknowns = samples::size(640, 480);

fn written<'a>(
    files: impl IntoIterator<Item = (&'a str, &'a str)>,
) -> (tempfile::TempDir, Vec<PathBuf>) {
    let dir = tempfile::tempdir().unwrap();
    let write = |(name, text): (&str, &str)| {
        let path = dir.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let paths = files.into_iter().map(write).collect();
    (dir, paths)
}

fn read<'a>(
    files: impl IntoIterator<Item = (&'a str, &'a str)>,
    unknowns: Unknowns,
) -> anyhow::Result<Meta> {
    let (_dir, paths) = written(files);
    import(&paths, unknowns)
}

/// Writes the rig and reads it back.
fn journey(format: Format, meta: &Meta) -> (Vec<Document>, Meta) {
    let documents = format.write(meta).unwrap();
    let files = documents.iter().map(|d| (d.name, d.text.as_str()));
    (documents.clone(), read(files, Unknowns::default()).unwrap())
}

/// Bits of the numbers that all formats have: cameras, lens coefficients, `R` and `t`.
fn numbers(meta: &Meta) -> Vec<u64> {
    let of = [meta.k_l.concat(), meta.k_r.concat(), meta.dist_l.clone(), meta.dist_r.clone()];
    of.concat().iter().chain(&meta.r.concat()).chain(&meta.t).map(|x| x.to_bits()).collect()
}

/// A point of the left camera in the frame of the right one, m.
fn moved(meta: &Meta, p: [f64; 3]) -> [f64; 3] {
    let row = |i: usize| {
        let turned: f64 = meta.r[i].iter().zip(p).map(|(r, p)| r * p).sum();
        turned + meta.t[i] * meta.baseline_m.unwrap()
    };
    [row(0), row(1), row(2)]
}

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

/// Rigs with radial-tangential lenses and one with fisheyes, with and without the length of the baseline.
fn rigs() -> Vec<Meta> {
    let mut rigs: Vec<Meta> =
        Dataset::SHIPPED.iter().map(|name| Dataset::find(Path::new(name)).unwrap().meta).collect();
    let [r, t] = [[1.0, -2.0, 0.7], [0.0, 1.5, -0.4]]
        .map(|degrees| Rotation3::new(Vector3::from(degrees.map(f64::to_radians))));
    let mut fisheye = rigs[0].clone();
    fisheye.lens = LensModel::Fisheye;
    [fisheye.dist_l, fisheye.dist_r] = [vec![-0.013, 0.027, -0.031, 0.011], vec![0.0; 4]];
    fisheye.r = rows(r.matrix());
    fisheye.t = (t * -Vector3::x()).into();
    fisheye.baseline_m = Some(0.1);
    rigs.push(fisheye);
    rigs
}

/// A rig of rational lenses.
fn rational() -> Meta {
    let [left, right] = [
        [9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2],
        [-0.28, 0.04, 1e-3, -1e-4, 0.11, 0.0, 0.0, 0.0],
    ];
    let radial = rigs().swap_remove(0);
    Meta { lens: LensModel::Rational, dist_l: left.to_vec(), dist_r: right.to_vec(), ..radial }
}

/// Without `k3`, which Kalibr lacks.
fn without_k3(mut meta: Meta) -> Meta {
    if meta.lens == LensModel::RadialTangential {
        (meta.dist_l[4], meta.dist_r[4]) = (0.0, 0.0);
    }
    meta
}

#[test]
fn opencv_takes_points_of_the_first_camera_to_the_second() {
    let meta = read(OPENCV, SIZE).unwrap();
    // R x + T with R = [1 0 0; 0 0.8 -0.6; 0 0.6 0.8], by hand.
    assert!(close(moved(&meta, [0.0, 0.0, 5.0]), [-0.12, -3.0 + 0.01, 4.0 + 0.02]));
    assert!((meta.baseline_m.unwrap() - 0.014_9_f64.sqrt()).abs() < 1e-15);
    assert_eq!(meta.k_l.concat()[..3], [534.126_673_139_211_7, 0.0, 342.015_488_599_680_5]);
    assert_eq!(meta.dist_l[3].to_bits(), (-9.545_901_325_055_574e-5_f64).to_bits());
    assert_eq!(meta.dist_r, [-0.3, 0.15, -5e-4, 2.5e-4, -0.07]);
    let millimetres = read(OPENCV, Unknowns { unit_m: 0.001, ..SIZE }).unwrap();
    assert!((millimetres.baseline_m.unwrap() - 1e-3 * 0.014_9_f64.sqrt()).abs() < 1e-18);
}

#[test]
fn opencv_may_have_all_keys_in_one_file_without_document_marks() {
    let [(_, a), (_, b)] = OPENCV;
    let both = [a.replacen("---\n", "", 1), b.replacen("%YAML:1.0\n---\n", "", 1)].concat();
    let meta = read([("rig.yml", both.as_str())], SIZE).unwrap();
    assert_eq!(numbers(&meta), numbers(&read(OPENCV, SIZE).unwrap()));
}

#[test]
fn kalibr_takes_points_of_cam0_to_cam1() {
    let meta = read([("camchain.yaml", KALIBR)], Unknowns::default()).unwrap();
    assert!(close(moved(&meta, [0.0, 0.0, 5.0]), [-0.12, -3.0 + 0.01, 4.0 + 0.02]));
    assert_eq!(meta.k_r, [[457.587, 0.0, 379.999], [0.0, 456.134, 255.238], [0.0, 0.0, 1.0]]);
    assert_eq!(meta.dist_l, [-0.283_408_11, 0.073_959_07, 0.000_193_59, 1.761_871_14e-5, 0.0]);
    assert_eq!([meta.width, meta.height], [752, 480]);
}

#[test]
fn ros_has_the_rig_in_its_rectification() {
    let meta = read(ROS, Unknowns::default()).unwrap();
    // R = R_r^T R_l, t = -(first row of R_r) b, by hand: P[0][3] = -48 = -400 * 0.12.
    assert!(close(moved(&meta, [1.0, 0.0, 5.0]), [0.8 - 0.12, -0.6, 5.0]));
    assert!((meta.baseline_m.unwrap() - 0.12).abs() < 1e-15);
    let [left, right] = ROS;
    let exchanged = read([("a.yaml", right.1), ("b.yaml", left.1)], Unknowns::default()).unwrap();
    assert_eq!(numbers(&exchanged), numbers(&meta));
}

#[test]
fn written_files_follow_the_convention_of_their_format() {
    let meta = without_k3(read(OPENCV, SIZE).unwrap());
    let text = |format: Format, name: &str| {
        let documents = format.write(&meta).unwrap();
        documents.into_iter().find(|d| d.name == name).unwrap().text
    };
    let opencv = text(Format::Opencv, "extrinsics.yml");
    assert!(opencv.starts_with("%YAML:1.0\n---\n"), "{opencv}");
    assert!(opencv.contains("data: [ -0.12,\n       0.01,\n       0.02 ]"), "{opencv}");
    let kalibr = text(Format::Kalibr, "camchain.yaml");
    assert!(kalibr.contains("  - [0.0, 0.8, -0.6, 0.01]"), "{kalibr}");
    let ros = text(Format::Ros, "right.yaml");
    let p = ros.lines().next_back().unwrap().trim_start_matches("  data: [").trim_end_matches(']');
    let p: Vec<f64> = p.split(", ").map(|x| x.parse().unwrap()).collect();
    assert!((p[3] + p[0] * meta.baseline_m.unwrap()).abs() < 1e-12 && p[3] < 0.0, "{ros}");
}

#[test]
fn opencv_and_kalibr_give_every_bit_back_but_the_last_of_t() {
    for meta in rigs() {
        for format in [Format::Opencv, Format::Kalibr] {
            let meta =
                if format == Format::Kalibr { without_k3(meta.clone()) } else { meta.clone() };
            let (first, once) = journey(format, &meta);
            let (second, twice) = journey(format, &once);
            assert_eq!(first, second, "{format:?} {}", meta.source);
            assert_eq!(numbers(&once), numbers(&twice));
            assert_eq!([once.lens, twice.lens], [meta.lens; 2]);
            let without_t = |meta: &Meta| numbers(&Meta { t: [0.0; 3], ..meta.clone() });
            assert_eq!(without_t(&once), without_t(&meta), "{format:?} {}", meta.source);
            let ulps = |(a, b): (&f64, &f64)| a.to_bits().abs_diff(b.to_bits());
            assert!(once.t.iter().zip(&meta.t).map(ulps).max() <= Some(16), "{once:?}");
            if meta.baseline_m.is_none() {
                assert_eq!((once.t, once.baseline_m), (meta.t, None));
            }
        }
    }
}

#[test]
fn a_rational_lens_is_read_where_a_file_has_its_coefficients() {
    let [(name, intrinsics), extrinsics] = OPENCV;
    let text = intrinsics.replace("-0.07, 0., 0., 0.,", "-0.07, 0.2, 0.1, 0.05,");
    assert_ne!(text, intrinsics);
    let meta = read([(name, text.as_str()), extrinsics], SIZE).unwrap();
    assert_eq!(meta.lenses(), [LensModel::RadialTangential, LensModel::Rational]);
    assert_eq!(meta.dist_r, [-0.3, 0.15, -5e-4, 2.5e-4, -0.07, 0.2, 0.1, 0.05]);
    // The other lens is unchanged.
    let plain = read(OPENCV, SIZE).unwrap();
    assert_eq!(meta.dist_l, plain.dist_l);
    let pixel = [[20.0, 30.0], [600.0, 400.0]];
    for [a, b] in
        pixel.map(|at| [&meta, &plain].map(|m| m.cameras::<f64>().unwrap().left.ray(at).unwrap()))
    {
        assert!((a - b).norm() < 1e-12, "{a} {b}");
    }
    for format in [Format::Opencv, Format::Ros] {
        let (_, back) = journey(format, &rational());
        assert_eq!((back.lens, back.dist_l), (LensModel::Rational, rational().dist_l));
    }
    let error = Format::Kalibr.write(&rational()).unwrap_err().to_string();
    assert!(error.contains("rational") && error.contains("ros"), "{error}");
}

#[test]
fn ros_gives_the_rig_back_to_rounding() {
    for meta in rigs() {
        let (_, back) = journey(Format::Ros, &meta);
        let off =
            Deviation::between(&back.extrinsics::<f64>().unwrap(), &meta.extrinsics().unwrap());
        assert!(off.rotation < 1e-15 && off.translation < 1e-15, "{off:?}");
        let [a, b] = [&back, &meta].map(|meta| meta.baseline_m.unwrap_or(1.0));
        assert!((a - b).abs() < 1e-15, "{a} {b}");
        let elsewhere = |meta: &Meta| numbers(&Meta { r: back.r, t: back.t, ..meta.clone() });
        assert_eq!(elsewhere(&back), elsewhere(&meta));
    }
}

#[test]
fn an_unknown_baseline_is_said_in_the_file() {
    let chess = &without_k3(rigs().swap_remove(0));
    assert_eq!(chess.baseline_m, None);
    for format in Format::ALL {
        let says = |meta: &Meta| {
            format.write(meta).unwrap().iter().any(|d| d.text.contains("baseline is unknown"))
        };
        assert!(says(chess), "{format:?}");
        assert!(!says(&Meta { baseline_m: Some(0.1), ..chess.clone() }), "{format:?}");
    }
}

/// Replaces `from` by `to` once in each file, and checks that the error has all `words`.
fn refused<'a>(
    files: impl IntoIterator<Item = (&'a str, &'a str)>,
    from: &str,
    to: &str,
    words: &[&str],
) {
    let files: Vec<(&str, String)> =
        files.into_iter().map(|(name, text)| (name, text.replacen(from, to, 1))).collect();
    let borrowed = files.iter().map(|(name, text)| (*name, text.as_str()));
    let unknowns = if files[0].0 == "intrinsics.yml" { SIZE } else { Unknowns::default() };
    let error = format!("{:#}", read(borrowed, unknowns).expect_err(from));
    for word in words {
        assert!(error.contains(word), "`{from}` to `{to}`: no `{word}` in: {error}");
    }
}

#[test]
fn errors_in_an_opencv_file_are_named() {
    refused(OPENCV, "M2:", "M9:", &["intrinsics.yml", "M2", "3 x 3"]);
    refused(OPENCV, "data: [ -0.12", "data: [ .nan", &["extrinsics.yml", "T", "finite"]);
    refused(OPENCV, "data: [ -0.12, ", "data: [ ", &["T:", "2 numbers: expected 3 x 1"]);
    refused(OPENCV, "data: [ -0.12", "data: [ 0.12", &["exchange"]);
    refused(OPENCV, "0.8, -0.6", "0.8, 0.6", &["extrinsics.yml", "not a rotation"]);
    let with = |k4_and_on: &str| format!("-0.07, {k4_and_on}");
    let zeros = "-0.07, 0., 0., 0., 0., 0., 0., 0., 0., 0.";
    let prism = with("0.1, 0., 0., 0.001, 0., 0., 0., 0., 0.");
    refused(OPENCV, zeros, &prism, &["D2", "thin prism", "s1", "k4 k5 k6"]);
    let tilt = with("0., 0., 0., 0., 0., 0., 0., 0., 0.02");
    refused(OPENCV, zeros, &tilt, &["D2", "tau_y", "k4 k5 k6"]);
    let absurd = with("0.1, 0., 2e6, 0., 0., 0., 0., 0., 0.");
    refused(OPENCV, zeros, &absurd, &["right camera", "distortion"]);
    refused(OPENCV, "537., 0., 326.", "537., 3., 326.", &["intrinsics.yml: M2", "skew 3"]);
    refused(OPENCV, "rows: 3", "rows: three", &["intrinsics.yml", "rows: three"]);
    let error = format!("{:#}", read(OPENCV, Unknowns::default()).unwrap_err());
    assert!(error.contains("image_width") && error.contains("--size"), "{error}");
}

#[test]
fn errors_in_a_kalibr_file_are_named() {
    let files = || [("camchain.yaml", KALIBR)];
    refused(files(), "camera_model: pinhole", "camera_model: omni", &["cam0", "omni", "pinhole"]);
    refused(files(), "model: radtan", "model: fov", &["camchain.yaml", "fov", "equidistant"]);
    refused(files(), "T_cn_cnm1", "T_cam_imu", &["cam1", "T_cn_cnm1 is missing"]);
    refused(files(), "  - [0.0, 0.0, 0.0, 1.0]\n", "", &["T_cn_cnm1", "4 x 4 numbers"]);
    refused(files(), "0.0, 0.0, 0.0, 1.0", "0.0, 0.0, 1.0", &["T_cn_cnm1", "4 x 4 numbers"]);
    refused(files(), "0.8, -0.6", "0.9, -0.6", &["T_cn_cnm1", "not a rotation"]);
    refused(files(), "[458.654, ", "[", &["cam0", "intrinsics", "3 numbers"]);
    refused(files(), "[458.654", "[.nan", &["camchain.yaml", "intrinsics", "finite"]);
    refused(files(), "cam1:", "cam2:", &["camchain.yaml", "cam1"]);
}

#[test]
fn errors_in_a_ros_file_are_named() {
    refused(ROS, "plumb_bob", "omni", &["left.yaml", "distortion_model: omni"]);
    refused(ROS, "[0.8, 0.6, 0,", "[0.8, 0.7, 0,", &["rectification", "not a rotation"]);
    refused(ROS, "-48.0", "48.0", &["P[0][3]"]);
    refused(ROS, "cols: 4", "cols: 3", &["projection_matrix", "3 x 4"]);
    refused(ROS, "camera_matrix", "matrix", &["left.yaml", "camera_matrix"]);
    let error = format!("{:#}", read([ROS[0]], Unknowns::default()).unwrap_err());
    assert!(error.contains("two files"), "{error}");
}

#[test]
fn a_file_cut_off_anywhere_is_refused_or_still_whole_and_never_panics() {
    for files in [&OPENCV[..], &[("camchain.yaml", KALIBR)], &ROS] {
        let last = files.len() - 1;
        let whole = files[last].1;
        for end in (0..whole.len()).step_by(7) {
            let mut cut = files.to_vec();
            cut[last].1 = &whole[..end];
            let unknowns =
                if files.len() == 2 && whole.contains("Q:") { SIZE } else { Unknowns::default() };
            if let Err(error) = read(cut, unknowns) {
                let error = format!("{error:#}");
                assert!(error.contains(".y"), "no file in: {error}");
            }
        }
    }
}

#[test]
fn a_rig_that_a_format_cannot_express_is_refused() {
    let chess = &rigs()[0];
    let error = Format::Kalibr.write(chess).unwrap_err().to_string();
    assert!(error.contains("k3") && error.contains("opencv"), "{error}");
    let turned = Meta { r: [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], ..chess.clone() };
    for format in Format::ALL {
        assert!(format.write(&turned).unwrap_err().to_string().contains("not a rotation"));
    }
}
