//! Topics and `camera_info` of bags as drivers write them: rectified, twice, cut out, binned, never calibrated.

use std::path::{Path, PathBuf};

use image::GrayImage;

use crate::call::check;
use crate::images::mcap_bag::{Bag, Info, info, raw_image};
use crate::images::scene::{self, FOCAL, SIZE, moving};

/// A topic of images: its name, the side of its images, their encoding, and the delay of their time stamps, ns.
struct Images<'a> {
    topic: &'a str,
    side: usize,
    encoding: &'a str,
    late_ns: u32,
}

fn images(topic: &str, side: usize) -> Images<'_> {
    Images { topic, side, encoding: "mono8", late_ns: 0 }
}

/// The camera before its rectification: other intrinsics, distorted and turned.
fn raw(mut info: Info) -> Info {
    info.matrices[0] = vec![-0.3, 0.1, 0.001, 0.0, 0.0];
    info.matrices[1] = vec![FOCAL * 1.1, 0.0, 200.0, 0.0, FOCAL * 1.1, 170.0, 0.0, 0.0, 1.0];
    let (sin, cos) = 0.02_f64.sin_cos();
    info.matrices[2] = vec![1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos];
    info
}

/// The pixels of an image in an encoding, and the bytes of a line.
fn encoded(image: &GrayImage, encoding: &str) -> (Vec<u8>, u32) {
    let [width, height] = [image.width(), image.height()];
    let each = |of: &dyn Fn(u32, u32, u8) -> Vec<u8>| -> Vec<u8> {
        (0..height)
            .flat_map(|v| (0..width).flat_map(move |u| of(u, v, image.get_pixel(u, v).0[0])))
            .collect()
    };
    let pixels = match encoding {
        "yuv422" => each(&|u, _, y| vec![if u % 2 == 0 { 90 } else { 170 }, y]),
        "yuv422_yuy2" => each(&|u, _, y| vec![y, if u % 2 == 0 { 90 } else { 170 }]),
        "nv12" => [each(&|_, _, y| vec![y]), vec![128; (width * height / 2) as usize]].concat(),
        // Red is bright and blue is dark, so an unresolved mosaic shows.
        "bayer_rggb8" => each(&|u, v, y| {
            vec![match (u % 2, v % 2) {
                (0, 0) => y.saturating_add(60),
                (1, 1) => y.saturating_sub(60),
                _ => y,
            }]
        }),
        "mono16" => each(&|_, _, y| (u16::from(y) * 16).to_le_bytes().to_vec()),
        "rgb16" => each(&|_, _, y| (u16::from(y) * 257).to_le_bytes().repeat(3)),
        "bgra8" => each(&|_, _, y| vec![y, y, y, 255]),
        _ => each(&|_, _, y| vec![y]),
    };
    let bytes = u32::try_from(pixels.len()).unwrap() / height;
    (pixels, if encoding == "nv12" { width } else { bytes })
}

/// A bag of some moments.
fn bag(path: &Path, all: &[Images<'_>], infos: &[Info], moments: usize) {
    let mut bag = Bag::create(path, 1 << 20, "zstd");
    let topics: Vec<u16> = all.iter().map(|images| bag.topic(images.topic, "Image")).collect();
    for info in infos {
        bag.calibration(info);
    }
    for (i, pair) in (0..).zip(&moving(moments)) {
        for (id, images) in topics.iter().zip(all) {
            let image = &pair[images.side];
            let pixels = encoded(image, images.encoding);
            let at = (100 + i, images.late_ns);
            bag.write(*id, i, &raw_image(image, at, images.encoding, pixels));
        }
    }
    bag.finish();
}

struct Made {
    _dir: tempfile::TempDir,
    path: PathBuf,
}

fn made(all: &[Images<'_>], infos: &[Info], moments: usize) -> Made {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("made.mcap");
    bag(&path, all, infos, moments);
    Made { _dir: dir, path }
}

fn infos(change: impl Fn(Info) -> Info) -> [Info; 2] {
    [
        change(info("/stereo/left/camera_info", false)),
        change(info("/stereo/right/camera_info", true)),
    ]
}

const RAW: [&str; 2] = ["/stereo/left/image_raw", "/stereo/right/image_raw"];
const RECT: [&str; 2] = ["/stereo/left/image_rect", "/stereo/right/image_rect"];

fn fits(made: &Made, more: &[&str]) {
    scene::fits(0.6, &made.path, more);
}

fn refused(made: &Made, more: &[&str], words: &[&str]) {
    let (_, said) = check(&made.path, more);
    assert_eq!(said.status, 1, "{}", said.err);
    for word in words {
        assert!(said.err.contains(word), "no {word} in: {}", said.err);
    }
}

#[test]
fn p_is_the_camera_of_rectified_topics() {
    let made = made(&[images(RECT[0], 0), images(RECT[1], 1)], &infos(raw), 3);
    fits(&made, &[]);
    let none = |mut info: Info| {
        (info.matrices[1], info.matrices[2]) = (vec![0.0; 9], vec![f64::NAN; 9]);
        info
    };
    fits(&self::made(&[images(RECT[0], 0), images(RECT[1], 1)], &infos(none), 1), &[]);
    let (_, said) = check(&made.path, &[]);
    assert!(said.err.contains(RECT[0]) && said.err.contains(RECT[1]), "{}", said.err);
}

#[test]
fn ambiguous_topics_are_refused_with_the_list_and_can_be_chosen() {
    // The right topic comes first: the order of messages decides nothing.
    let all = [images(RECT[1], 1), images(RAW[0], 0), images(RECT[0], 0), images(RAW[1], 1)];
    let made = made(&all, &infos(raw), 3);
    refused(&made, &[], &[RAW[0], RAW[1], RECT[0], RECT[1], "--left-topic", "--right-topic"]);
    fits(&made, &["--left-topic", RECT[0], "--right-topic", RECT[1]]);
    fits(&made, &["--left-topic", RECT[0]]);
    refused(&made, &["--left-topic", RAW[0], "--right-topic", RECT[1]], &["is rectified", RECT[1]]);
    refused(&made, &["--left-topic", "/none"], &["no topic /none", RAW[0]]);
}

#[test]
fn left_raw_is_not_paired_with_right_rectified() {
    let made = made(&[images(RAW[0], 0), images(RECT[1], 1)], &infos(raw), 3);
    refused(&made, &[], &[RAW[0], RECT[1], "--left-topic"]);
}

#[test]
fn a_given_rig_overrides_an_invalid_camera_info() {
    let focal = FOCAL.to_string();
    let pair = [images(RAW[0], 0), images(RAW[1], 1)];
    let zero = |mut info: Info| {
        info.matrices = [vec![], vec![0.0; 9], vec![0.0; 9], vec![0.0; 12]];
        info
    };
    let mono = |mut info: Info| {
        info.matrices[3][3] = 0.0;
        info
    };
    let garbage = |mut info: Info| {
        info.matrices[1] = vec![f64::NAN; 9];
        info
    };
    let blank = |mut info: Info| {
        (info.model, info.matrices[1]) = (String::new(), vec![0.0; 9]);
        info
    };
    for (infos, why) in [
        (infos(zero), "never calibrated"),
        (infos(mono), "one by one"),
        (infos(garbage), "finite"),
        (infos(blank), "never calibrated"),
    ] {
        let made = made(&pair, &infos, 3);
        refused(&made, &[], &[why, "--rig", "--focal", "/stereo/left/camera_info"]);
        fits(&made, &["--focal", &focal]);
    }
    let none = made(&pair, &[], 3);
    refused(&none, &[], &["no camera_info on /stereo/left/camera_info", "--rig", "--focal"]);
    fits(&none, &["--focal", &focal]);
}

#[test]
fn region_of_interest_and_binning_follow_camera_info() {
    let pair = [images(RAW[0], 0), images(RAW[1], 1)];
    let region = |mut info: Info| {
        info.size = [SIZE[0] + 200, SIZE[1] + 100];
        info.roi = [120, 30, SIZE[0], SIZE[1]];
        for i in [1, 3] {
            info.matrices[i][2] += 120.0;
            info.matrices[i][if i == 1 { 5 } else { 6 }] += 30.0;
        }
        info
    };
    let binned = |mut info: Info| {
        info.size = SIZE.map(|n| 2 * n);
        info.binning = [2, 2];
        for i in [1, 3] {
            info.matrices[i].iter_mut().take(if i == 1 { 6 } else { 8 }).for_each(|x| *x *= 2.0);
        }
        info
    };
    for infos in [infos(region), infos(binned)] {
        let made = made(&pair, &infos, 3);
        fits(&made, &[]);
        let (json, said) = check(&made.path, &[]);
        assert!(!said.err.contains("note:"), "{}", said.err);
        assert_eq!(json["rig_guessed"], false);
    }
}

#[test]
fn pixels_are_read_in_the_encodings_of_cameras() {
    for encoding in ["yuv422", "yuv422_yuy2", "nv12", "bayer_rggb8", "mono16", "rgb16", "bgra8"] {
        let pair = [0, 1].map(|side| Images { encoding, ..images(RAW[side], side) });
        let made = made(&pair, &infos(|info| info), 1);
        let (json, said) = check(&made.path, &[]);
        let matches = json["matches_a_pair"].as_f64();
        assert!(matches.is_some_and(|n| n > 100.0), "{encoding}: {json} {}", said.err);
        fits(&made, &[]);
    }
    let pair = [0, 1].map(|side| Images { encoding: "32FC1", ..images(RAW[side], side) });
    refused(&made(&pair, &infos(|info| info), 1), &[], &["32FC1", "mono8", RAW[0]]);
}

#[test]
fn stamps_too_far_apart_are_reported_with_a_sufficient_tolerance() {
    let pair = [images(RAW[0], 0), Images { late_ns: 8_000_000, ..images(RAW[1], 1) }];
    let made = made(&pair, &infos(|info| info), 2);
    refused(&made, &[], &["8.0 ms apart", "--tolerance 0.010"]);
    fits(&made, &["--tolerance", "0.010"]);
}

#[test]
fn one_topic_may_have_both_cameras() {
    // One left image. `--side-by-side` cuts it into two halves, which fit no rig. The test only shows that the halves
    // are read.
    let made = made(&[images("/zed/image", 0)], &[], 1);
    refused(&made, &[], &["which topics are left and right", "/zed/image"]);
    let (_, said) = check(&made.path, &["--side-by-side", "--focal", "600"]);
    assert!(
        said.err.contains("left half of /zed/image") || said.err.contains("halves"),
        "{}",
        said.err
    );
}
