//! Bags: images and calibration out of MCAP files, whole, cut short, split and in their folder.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{GrayImage, ImageFormat};

use crate::call::check;
use crate::images::mcap_bag::{Bag, Cdr, info, raw_image};
use crate::images::scene::moving;
use crate::images::sqlite_bag;

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
    let mut bag = Bag::create(path, 1 << 16, "lz4");
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
    bag.finish();
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
    assert!(said.err.contains("cut.mcap: the rest is lost"), "{}", said.err);
    let kept = json["run"]["pairs"].as_u64();
    assert!(kept.is_some_and(|pairs| (1..4).contains(&pairs)), "{json} {}", said.err);
    fs::write(&cut, b"nothing").unwrap();
    let err = check(&cut, &[]).1.err;
    assert!(err.contains("error") && err.contains("cut.mcap"), "{err}");
}

/// Writes the messages of the moments of a range into a bag.
fn part(path: &Path, pairs: &[[GrayImage; 2]], first: u32) {
    let mut bag = Bag::create(path, 1 << 20, "zstd");
    let topics = ["left", "right"].map(|side| {
        bag.calibration(&info(&format!("/stereo/{side}/camera_info"), side == "right"));
        bag.topic(&format!("/stereo/{side}/image_raw"), "Image")
    });
    for (i, pair) in (first..).zip(pairs) {
        for (topic, image) in topics.iter().zip(pair) {
            let pixels = (image.as_raw().clone(), image.width());
            bag.write(*topic, i, &raw_image(image, (100 + i, 0), "mono8", pixels));
        }
    }
    bag.finish();
}

/// `metadata.yaml` of a folder, with parts that are named as early versions name them.
fn metadata(dir: &Path, files: &[&str], messages: usize, compression: &str) {
    let files: Vec<String> = files.iter().map(|name| format!("    - bag/{name}\n")).collect();
    let text = format!(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  relative_file_paths:\n{}  message_count: {messages}\n  \
         compression_format: \"{compression}\"\n  compression_mode: \"{}\"\n",
        files.concat(),
        if compression.is_empty() { "" } else { "FILE" }
    );
    fs::write(dir.join("metadata.yaml"), text).unwrap();
}

#[test]
fn the_folder_of_a_split_recording_is_read_in_the_order_of_its_files() {
    let dir = tempfile::tempdir().unwrap();
    let bag = dir.path().join("bag");
    fs::create_dir(&bag).unwrap();
    let moments = moving(4);
    // In the order of names, 10 would come before 9.
    part(&bag.join("bag_9.mcap"), &moments[..2], 0);
    part(&bag.join("bag_10.mcap"), &moments[2..], 2);
    let pairs = |more: &[&str], count: usize| {
        let (json, said) = check(&bag, more);
        assert_eq!(json["run"]["pairs"], count, "{more:?} {}", said.err);
        said.err
    };
    let lost = |err: &str| err.contains("damaged") || err.contains("states");
    // A recorder that was killed writes no metadata.
    assert!(!lost(&pairs(&[], 4)));
    metadata(&bag, &["bag_9.mcap", "bag_10.mcap"], 12, "");
    assert!(!lost(&pairs(&[], 4)));
    // The images are a second apart.
    pairs(&["--start", "0.5"], 3);
    pairs(&["--start", "1", "--end", "2.5"], 2);
    pairs(&["--end", "0"], 1);
    let err = check(&bag, &["--start", "60"]).1.err;
    assert!(err.contains("between --start and --end"), "{err}");
    metadata(&bag, &["bag_9.mcap", "bag_10.mcap"], 13, "");
    assert!(pairs(&[], 4).contains("12 messages, where metadata.yaml states 13"));
    metadata(&bag, &["bag_9.mcap", "bag_11.mcap"], 12, "");
    let err = check(&bag, &[]).1.err;
    assert!(err.contains("metadata.yaml") && err.contains("bag_11.mcap"), "{err}");
    metadata(&bag, &["bag_9.mcap"], 6, "zstd");
    assert!(check(&bag, &[]).1.err.contains("compressed as a whole"));
    fs::write(bag.join("metadata.yaml"), "rosbag2_bagfile_information: [").unwrap();
    assert!(check(&bag, &[]).1.err.contains("ros2 bag reindex"));
}

#[test]
fn the_default_bag_of_humble_is_read() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bag_0.db3");
    sqlite_bag::write(&path, &moving(3));
    let (json, said) = check(&path, &[]);
    assert_eq!(json["run"]["pairs"], 3, "{}", said.err);
    assert_eq!((&json["rig_guessed"], &json["skipped"]), (&false.into(), &"".into()), "{json}");
    let other = dir.path().join("other.db3");
    rusqlite::Connection::open(&other).unwrap().execute_batch("CREATE TABLE a (b)").unwrap();
    let err = check(&other, &[]).1.err;
    assert!(err.contains("other.db3") && err.contains("is no ROS 2 bag"), "{err}");
}
