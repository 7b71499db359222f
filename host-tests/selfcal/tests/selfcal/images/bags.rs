//! Bags: images and calibration out of an MCAP file, whole and cut short.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{GrayImage, ImageFormat};
use mcap::WriteOptions;

use crate::call::check;
use crate::images::mcap_bag::{Bag, Cdr, info, raw_image};
use crate::images::scene::moving;

/// `sensor_msgs/msg/CompressedImage`.
fn compressed(image: &GrayImage, at: (u32, u32)) -> Vec<u8> {
    let mut cdr = Cdr::header(at.0, at.1);
    cdr.text("jpeg");
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
    cdr.data(&bytes.into_inner());
    cdr.0
}

/// A bag of five moments: left raw, right compressed and 2 ms late, one right image lost.
fn bag(path: &Path) {
    // A chunk is read whole or not at all, so the chunks are small: a cut then leaves some.
    let mut bag = Bag::create(path, WriteOptions::new().chunk_size(Some(1 << 16)));
    let left = bag.topic("/stereo/left/image_raw", "Image");
    let right = bag.topic("/stereo/right/image_raw/compressed", "CompressedImage");
    bag.calibration(&info("/stereo/left/camera_info", false));
    bag.calibration(&info("/stereo/right/camera_info", true));
    for (i, [l, r]) in (0..).zip(&moving(5)) {
        // Lines are longer than the image is wide.
        let lines = l.rows().flat_map(|row| row.map(|p| p.0[0]).chain([255; 5])).collect();
        bag.write(left, i, &raw_image(l, (100 + i, 0), "mono8", (lines, l.width() + 5)));
        if i != 1 {
            bag.write(right, i, &compressed(r, (100 + i, 2_000_000)));
        }
    }
    bag.0.finish().unwrap();
}

#[test]
fn a_bag_gives_its_pairs_and_its_rig_and_a_cut_bag_its_whole_pairs() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("whole.mcap");
    bag(&path);
    let (json, said) = check(&path, &[]);
    assert_eq!(json["run"]["pairs"], 4, "{}", said.err);
    assert_eq!(json["skipped"], "1 without a partner", "{}", said.err);
    assert_eq!(json["rig_guessed"], false);

    let bytes = fs::read(&path).unwrap();
    let cut = dir.path().join("cut.mcap");
    fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let (json, said) = check(&cut, &[]);
    assert!(said.err.contains("the rest of") && said.err.contains("cut.mcap"), "{}", said.err);
    let kept = json["run"]["pairs"].as_u64();
    assert!(kept.is_some_and(|pairs| (1..4).contains(&pairs)), "{json} {}", said.err);
    fs::write(&cut, b"nothing").unwrap();
    let err = check(&cut, &[]).1.err;
    assert!(err.contains("error") && err.contains("cut.mcap"), "{err}");
}
