//! Image files as cameras and phones write them: turned by EXIF, side by side, BMP and `WebP`, KITTI's colour cameras.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, GrayImage, ImageFormat, imageops};
use test_support::runs;

use crate::call::check;
use crate::images::scene::{
    FOCAL, K, PRINCIPAL, SIDE_BY_SIDE, SIZE, fits, folders, moving, rig, small,
};

fn focal() -> [String; 2] {
    ["--focal".to_owned(), FOCAL.to_string()]
}

/// A JPEG with an orientation in its EXIF data.
fn photograph(image: &GrayImage, orientation: u8, path: &Path) {
    let mut jpeg = Cursor::new(Vec::new());
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95);
    encoder.encode_image(image).unwrap();
    // One entry: tag 0x112, type 3 (16 bits), count 1.
    let tiff = [
        &b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"[..],
        &[orientation, 0, 0, 0, 0, 0, 0, 0],
    ]
    .concat();
    let segment = [&b"Exif\0\0"[..], &tiff].concat();
    let length = u16::try_from(segment.len() + 2).unwrap().to_be_bytes();
    let (start, rest) = jpeg.get_ref().split_at(2);
    fs::write(path, [start, &[0xff, 0xe1], &length, &segment, rest].concat()).unwrap();
}

/// The image as stored by a camera with this orientation.
fn stored(image: &GrayImage, orientation: u8) -> GrayImage {
    match orientation {
        3 => imageops::rotate180(image),
        6 => imageops::rotate270(image),
        8 => imageops::rotate90(image),
        _ => image.clone(),
    }
}

fn photographs(top: &Path, orientations: [u8; 2]) {
    for (side, name) in ["left", "right"].iter().enumerate() {
        fs::create_dir_all(top.join(name)).unwrap();
        for (i, pair) in moving(3).iter().enumerate() {
            let image = stored(&pair[side], orientations[side]);
            photograph(&image, orientations[side], &top.join(format!("{name}/{i:03}.jpg")));
        }
    }
}

#[test]
fn photographs_are_turned_as_their_exif_data_say() {
    // Each orientation once; in a campaign also those of two equal cameras.
    let all = [[1, 3], [6, 8], [3, 3], [6, 6], [8, 8]];
    for &orientations in &all[..runs(2, all.len())] {
        let dir = tempfile::tempdir().unwrap();
        photographs(dir.path(), orientations);
        let [option, px] = focal();
        let said = fits(0.7, dir.path(), &[&option, &px]);
        assert!(said.contains("EXIF orientation"), "{orientations:?}: {said}");
        // A rig for the upright images.
        let rig = rig(&dir.path().join("rig.yaml"), [(K, SIZE); 2], SIDE_BY_SIDE);
        fits(0.7, dir.path(), &["--rig", &rig]);
    }
}

#[test]
fn photographs_stay_as_stored_where_the_rig_is_of_them_or_the_user_says_so() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["left", "right"] {
        fs::create_dir_all(dir.path().join(name)).unwrap();
    }
    // The camera is upright in spite of the tag: the stored images fit the rig.
    for (i, pair) in moving(3).iter().enumerate() {
        for (image, name) in pair.iter().zip(["left", "right"]) {
            photograph(image, 6, &dir.path().join(format!("{name}/{i:03}.jpg")));
        }
    }
    let rig = rig(&dir.path().join("rig.yaml"), [(K, SIZE); 2], SIDE_BY_SIDE);
    let said = fits(0.7, dir.path(), &["--rig", &rig]);
    assert!(said.contains("left as stored"), "{said}");
    let [option, px] = focal();
    fits(0.7, dir.path(), &[&option, &px, "--exif", "stored"]);
}

#[test]
fn a_picture_of_both_cameras_is_cut_in_two() {
    let dir = tempfile::tempdir().unwrap();
    let [option, px] = focal();
    for (i, [left, right]) in moving(3).iter().enumerate() {
        let mut both = GrayImage::new(2 * SIZE[0], SIZE[1]);
        imageops::replace(&mut both, left, 0, 0);
        imageops::replace(&mut both, right, SIZE[0].into(), 0);
        both.save(dir.path().join(format!("{i:03}.png"))).unwrap();
    }
    let said = fits(0.7, dir.path(), &[&option, &px, "--side-by-side"]);
    assert!(said.contains("halves"), "{said}");
    // A picture of 2.3 to 1 may be one wide picture.
    let (_, said) = check(dir.path(), &[&option, &px]);
    assert!(said.status == 1 && said.err.contains("--side-by-side"), "{}", said.err);
}

#[test]
fn bmp_and_webp_are_read() {
    let [left, right] = small();
    for (ending, format) in [("bmp", ImageFormat::Bmp), ("webp", ImageFormat::WebP)] {
        let dir = tempfile::tempdir().unwrap();
        for (image, name) in [(&left, "left"), (&right, "right")] {
            let rgb = DynamicImage::ImageLuma8(image.clone()).into_rgb8();
            rgb.save_with_format(dir.path().join(format!("{name}.{ending}")), format).unwrap();
        }
        let [option, px] = focal();
        fits(0.7, dir.path(), &[&option, &px]);
    }
}

#[test]
fn the_colour_cameras_of_kitti_have_their_own_projections() {
    let dir = tempfile::tempdir().unwrap();
    let [left, right] = small();
    let [cx, cy] = PRINCIPAL;
    for (folder, image) in [("image_2", &left), ("image_3", &right)] {
        fs::create_dir_all(dir.path().join(folder)).unwrap();
        image.save(dir.path().join(folder).join("000000_10.png")).unwrap();
    }
    // The grey cameras differ: the principal point of the right one is 40 px lower.
    let p = |n: u8, cy: f64, x: f64| format!("P{n}: {FOCAL} 0 {cx} {x} 0 {FOCAL} {cy} 0 0 0 1 0\n");
    let text = [p(0, cy, 0.0), p(1, cy + 40.0, -200.0), p(2, cy, 40.0), p(3, cy, -300.0)].concat();
    fs::write(dir.path().join("calib.txt"), text).unwrap();
    fits(0.7, dir.path(), &[]);
    let [left, right, rig] = ["image_2", "image_3", "calib.txt"]
        .map(|name| dir.path().join(name).to_str().unwrap().to_owned());
    fits(0.7, left.as_ref(), &[&right, "--rig", &rig]);
}

#[test]
fn cropped_images_are_told_from_scaled_ones_or_asked_about() {
    let dir = tempfile::tempdir().unwrap();
    let all = moving(3);
    folders(all.iter().map(|[l, r]| [l, r]), dir.path());
    // The sensor has twice the size in each direction: after cropping, the focal length stays.
    let [fx, fy, cx, cy] = K;
    let [x, y] = SIZE.map(|n| f64::from(n / 2));
    let sensor = ([fx, fy, cx + x, cy + y], SIZE.map(|n| 2 * n));
    let rig = &rig(&dir.path().join("rig.yaml"), [sensor; 2], SIDE_BY_SIDE);
    let said = fits(0.7, dir.path(), &["--rig", rig, "--cut", "centre"]);
    assert!(said.contains("cropped from the middle"), "{said}");
    let (_, said) = check(dir.path(), &["--rig", rig]);
    assert!(said.err.contains("--cut"), "{}", said.err);
}

#[test]
fn three_pairs_of_different_moments_are_detected_and_two_are_reported_as_untested() {
    let all = moving(4);
    let dir = tempfile::tempdir().unwrap();
    folders(all[..3].iter().zip(&all[1..]).map(|([l, _], [_, r])| [l, r]), dir.path());
    let [option, px] = focal();
    let (json, said) = check(dir.path(), &[&option, &px]);
    assert!(json["reasons"].to_string().contains("different moments"), "{json} {}", said.err);
    let dir = tempfile::tempdir().unwrap();
    folders(all[..2].iter().map(|[l, r]| [l, r]), dir.path());
    let (json, said) = check(dir.path(), &[&option, &px]);
    assert!(json["reasons"].to_string().contains("show one moment"), "{json} {}", said.err);
}
