//! Scenes of the tests: a rig that turns in front of the Aloe image, as files.

use std::path::Path;
use std::sync::LazyLock;

use image::{GrayImage, ImageFormat};
use images::pictures::{Grey, turned};
use rigs::data::{Dataset, TurnedView};
use stereo_selfcal::{Camera, Intrinsics, Lens};

use crate::call::check;

/// Size of the small scene, px.
pub(crate) const SIZE: [u32; 2] = [427, 370];

/// Names of the shipped chess images of one side.
pub(crate) fn chess(side: &str) -> Vec<std::path::PathBuf> {
    let folder = Dataset::shipped().join("images/chess");
    let all = [1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14];
    all.iter().map(|n| folder.join(format!("{side}{n:02}.jpg"))).collect()
}

/// The small scene, which most tests read.
static SMALL: LazyLock<[GrayImage; 2]> = LazyLock::new(|| {
    let folder = Dataset::shipped().join("images/aloe");
    ["left.jpg", "right.jpg"].map(|name| {
        let whole = image::open(folder.join(name)).unwrap().into_luma8();
        // The mean of three times three pixels.
        GrayImage::from_fn(SIZE[0], SIZE[1], |u, v| {
            let nine =
                (0..9).map(|i| u32::from(whole.get_pixel(3 * u + i % 3, 3 * v + i / 3).0[0]));
            image::Luma([u8::try_from(nine.sum::<u32>() / 9).unwrap()])
        })
    })
});

/// The small scene: left and right, grey.
pub(crate) fn small() -> [GrayImage; 2] {
    SMALL.clone()
}

/// Principal point of the small scene, px.
pub(crate) const PRINCIPAL: [f64; 2] = [SIZE[0] as f64 / 2.0 - 0.5, SIZE[1] as f64 / 2.0 - 0.5];

/// Focal length of the small scene, px.
pub(crate) const FOCAL: f64 = 3740.0 / 3.0;

fn camera() -> Camera<f64> {
    let [width, height] = SIZE.map(|n| u16::try_from(n).unwrap());
    let intrinsics = Intrinsics { focal: [FOCAL; 2], principal: PRINCIPAL, size: [width, height] };
    Camera::try_new(intrinsics, Lens::Pinhole).unwrap()
}

/// An image after a turn of its camera, degrees; parts that were not visible are grey.
fn turn(image: &GrayImage, view: TurnedView, degrees: f64) -> GrayImage {
    let size = SIZE.map(|n| u16::try_from(n).unwrap());
    let grey = Grey::try_new(size, image.pixels().map(|p| Some(p.0[0])).collect()).unwrap();
    let warped = turned(&grey, &camera(), &view.rotation(degrees));
    let pixels = warped.pixels().iter().map(|pixel| pixel.unwrap_or(128)).collect();
    GrayImage::from_raw(SIZE[0], SIZE[1], pixels).unwrap()
}

/// Left and right images of a rig that turns as a whole, by another angle at each moment, of about a degree.
pub(crate) fn moving(moments: usize) -> Vec<[GrayImage; 2]> {
    turning(moments, 1.0)
}

/// Left and right images of a rig that turns as a whole, by another angle at each moment, of about so many degrees.
pub(crate) fn turning(moments: usize, degrees: f64) -> Vec<[GrayImage; 2]> {
    let [left, right] = small();
    let angles = [0.0, 0.9, -0.6, 1.4, 0.3, -1.1, 0.7, -0.2, 1.2, -0.9];
    let at = |i: usize| {
        let turned = |image| turn(image, TurnedView::Top, degrees * angles[i % angles.len()]);
        [turned(&left), turned(&right)]
    };
    (0..moments).map(at).collect()
}

pub(crate) fn save(image: &GrayImage, path: &Path) {
    image.save_with_format(path, ImageFormat::Pnm).unwrap();
}

/// Folders `left` and `right` of a sequence.
pub(crate) fn folders<'a>(pairs: impl IntoIterator<Item = [&'a GrayImage; 2]>, top: &Path) {
    for side in ["left", "right"] {
        std::fs::create_dir_all(top.join(side)).unwrap();
    }
    for (i, pair) in pairs.into_iter().enumerate() {
        for (image, side) in pair.into_iter().zip(["left", "right"]) {
            save(image, &top.join(format!("{side}/{i:03}.pgm")));
        }
    }
}

/// Intrinsics `fu fv pu pv` of the small scene, px.
pub(crate) const K: [f64; 4] = [FOCAL, FOCAL, PRINCIPAL[0], PRINCIPAL[1]];

/// First three rows of the transform from left to right of cameras side by side.
pub(crate) const SIDE_BY_SIDE: &str = "  - [1, 0, 0, -0.12]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n";

/// Writes a Kalibr file, and returns its path.
///
/// * `cameras`: `fu fv pu pv` and size of each camera, px.
/// * `rows`: the first three rows of the transform from left to right.
pub(crate) fn rig(path: &Path, cameras: [([f64; 4], [u32; 2]); 2], rows: &str) -> String {
    let cam = |n: usize| {
        let (k, size) = cameras[n];
        format!(
            "cam{n}:\n  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  intrinsics: {k:?}\n  resolution: {size:?}\n"
        )
    };
    let text = format!("{}{}  T_cn_cnm1:\n{rows}  - [0, 0, 0, 1]\n", cam(0), cam(1));
    std::fs::write(path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Checks that the rig in use fits the images: enough matches, and rows off by less than a limit, px RMS. Returns standard
/// error.
pub(crate) fn fits(limit_px: f64, place: &Path, more: &[&str]) -> String {
    let (json, said) = check(place, more);
    let number = |of: &serde_json::Value| of.as_f64().unwrap_or(f64::NAN);
    let [rows, matches] = [&json["run"]["rms_px_before"], &json["matches_a_pair"]].map(number);
    assert!(rows < limit_px && matches > 60.0, "{json} {}", said.err);
    said.err
}

/// Matrices of a `camera_info` of the rectified small scene: distortion, K, R, P.
pub(crate) fn camera_info(right: bool) -> [Vec<f64>; 4] {
    let [cx, cy] = PRINCIPAL;
    let shift = if right { -FOCAL * 0.12 } else { 0.0 };
    [
        vec![0.0; 5],
        vec![FOCAL, 0.0, cx, 0.0, FOCAL, cy, 0.0, 0.0, 1.0],
        vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        vec![FOCAL, 0.0, cx, shift, 0.0, FOCAL, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    ]
}
