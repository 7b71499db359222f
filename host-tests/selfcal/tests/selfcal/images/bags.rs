//! Bags: images and calibration out of an MCAP file, whole and cut short.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{GrayImage, ImageFormat};
use mcap::WriteOptions;
use mcap::records::MessageHeader;

use crate::call::check;
use crate::images::scene::{SIZE, camera_info, moving};

/// CDR, little endian: numbers at multiples of their size after the header of 4 bytes.
pub(crate) struct Cdr(Vec<u8>);

impl Cdr {
    pub(crate) fn header(seconds: u32, nanoseconds: u32) -> Self {
        let mut cdr = Self(vec![0, 1, 0, 0]);
        cdr.number(&seconds.to_le_bytes());
        cdr.number(&nanoseconds.to_le_bytes());
        cdr.text("camera");
        cdr
    }

    pub(crate) fn number(&mut self, bytes: &[u8]) {
        while !(self.0.len() - 4).is_multiple_of(bytes.len()) {
            self.0.push(0);
        }
        self.0.extend(bytes);
    }

    pub(crate) fn u32(&mut self, n: u32) {
        self.number(&n.to_le_bytes());
    }

    pub(crate) fn data(&mut self, bytes: &[u8]) {
        self.u32(u32::try_from(bytes.len()).unwrap());
        self.0.extend(bytes);
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.data(&[text.as_bytes(), &[0]].concat());
    }

    pub(crate) fn numbers(&mut self, numbers: &[f64]) {
        for x in numbers {
            self.number(&x.to_le_bytes());
        }
    }

    pub(crate) fn byte(&mut self, byte: u8) {
        self.0.push(byte);
    }

    pub(crate) fn bytes(self) -> Vec<u8> {
        self.0
    }
}

/// `sensor_msgs/msg/Image`, its lines longer than the image is wide.
fn raw(image: &GrayImage, at: (u32, u32)) -> Vec<u8> {
    let mut cdr = Cdr::header(at.0, at.1);
    cdr.u32(image.height());
    cdr.u32(image.width());
    cdr.text("mono8");
    cdr.0.push(0);
    cdr.u32(image.width() + 5);
    let lines = image.rows().flat_map(|row| row.map(|p| p.0[0]).chain([255; 5]));
    cdr.data(&lines.collect::<Vec<u8>>());
    cdr.0
}

/// `sensor_msgs/msg/CompressedImage`.
fn compressed(image: &GrayImage, at: (u32, u32)) -> Vec<u8> {
    let mut cdr = Cdr::header(at.0, at.1);
    cdr.text("jpeg");
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
    cdr.data(&bytes.into_inner());
    cdr.0
}

/// `sensor_msgs/msg/CameraInfo` of a rectified camera.
fn info(right: bool) -> Vec<u8> {
    let mut cdr = Cdr::header(0, 0);
    let [width, height] = SIZE;
    cdr.u32(height);
    cdr.u32(width);
    cdr.text("plumb_bob");
    cdr.u32(5);
    for numbers in camera_info(right) {
        cdr.numbers(&numbers);
    }
    cdr.0
}

/// A bag of five moments: left raw, right compressed and 2 ms late, one right image lost.
fn bag(path: &Path) {
    // A chunk is read whole or not at all, so the chunks are small: a cut then leaves some.
    let options = WriteOptions::new().chunk_size(Some(1 << 16));
    let mut out = options.create(fs::File::create(path).unwrap()).unwrap();
    let mut channel = |topic: &str, kind: &str| {
        let schema = out.add_schema(&format!("sensor_msgs/msg/{kind}"), "ros2msg", b"").unwrap();
        out.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap()
    };
    let left = channel("/stereo/left/image_raw", "Image");
    let right = channel("/stereo/right/image_raw/compressed", "CompressedImage");
    let infos =
        ["left", "right"].map(|side| channel(&format!("/stereo/{side}/camera_info"), "CameraInfo"));
    let mut write = |channel_id, sequence: u32, data: &[u8]| {
        let time = u64::from(sequence);
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        out.write_to_known_channel(&header, data).unwrap();
    };
    write(infos[0], 0, &info(false));
    write(infos[1], 0, &info(true));
    for (i, [l, r]) in (0..).zip(&moving(5)) {
        write(left, i, &raw(l, (100 + i, 0)));
        if i != 1 {
            write(right, i, &compressed(r, (100 + i, 2_000_000)));
        }
    }
    out.finish().unwrap();
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
