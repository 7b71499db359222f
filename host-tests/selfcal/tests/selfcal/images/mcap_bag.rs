//! Writer of MCAP files with images and their calibrations.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use image::GrayImage;
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};

use crate::images::scene::{SIZE, camera_info};

/// CDR, little endian: numbers at multiples of their size after the header of 4 bytes.
pub(crate) struct Cdr(pub(crate) Vec<u8>);

impl Cdr {
    pub(crate) fn header(seconds: u32, nanoseconds: u32) -> Self {
        let mut cdr = Self(vec![0, 1, 0, 0]);
        cdr.number(&seconds.to_le_bytes());
        cdr.number(&nanoseconds.to_le_bytes());
        cdr.text("camera");
        cdr
    }

    fn number(&mut self, bytes: &[u8]) {
        while !(self.0.len() - 4).is_multiple_of(bytes.len()) {
            self.0.push(0);
        }
        self.0.extend(bytes);
    }

    fn u32(&mut self, n: u32) {
        self.number(&n.to_le_bytes());
    }

    pub(crate) fn data(&mut self, bytes: &[u8]) {
        self.u32(u32::try_from(bytes.len()).unwrap());
        self.0.extend(bytes);
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.data(&[text.as_bytes(), &[0]].concat());
    }

    fn numbers(&mut self, numbers: &[f64]) {
        for x in numbers {
            self.number(&x.to_le_bytes());
        }
    }
}

/// A `camera_info`.
#[derive(Clone)]
pub(crate) struct Info {
    pub(crate) topic: String,
    pub(crate) size: [u32; 2],
    pub(crate) model: String,
    pub(crate) matrices: [Vec<f64>; 4],
    pub(crate) binning: [u32; 2],
    pub(crate) roi: [u32; 4],
}

/// The `camera_info` of a rectified camera.
pub(crate) fn info(topic: &str, right: bool) -> Info {
    Info {
        topic: topic.into(),
        size: SIZE,
        model: "plumb_bob".into(),
        matrices: camera_info(right),
        binning: [0; 2],
        roi: [0; 4],
    }
}

impl Info {
    pub(crate) fn message(&self) -> Vec<u8> {
        let mut cdr = Cdr::header(0, 0);
        let [width, height] = self.size;
        cdr.u32(height);
        cdr.u32(width);
        cdr.text(&self.model);
        cdr.u32(u32::try_from(self.matrices[0].len()).unwrap());
        for numbers in &self.matrices {
            cdr.numbers(numbers);
        }
        let [x, y, w, h] = self.roi;
        for number in [self.binning[0], self.binning[1], x, y, h, w] {
            cdr.u32(number);
        }
        cdr.0.push(0);
        cdr.0
    }
}

/// `sensor_msgs/msg/Image`.
///
/// * `at`: time stamp, s and ns.
/// * `pixels`, `step`: all lines, and the bytes of a line.
pub(crate) fn raw_image(
    image: &GrayImage,
    at: (u32, u32),
    encoding: &str,
    (pixels, step): (Vec<u8>, u32),
) -> Vec<u8> {
    let mut cdr = Cdr::header(at.0, at.1);
    cdr.u32(image.height());
    cdr.u32(image.width());
    cdr.text(encoding);
    cdr.0.push(0);
    cdr.u32(step);
    cdr.data(&pixels);
    cdr.0
}

/// A bag that is written.
pub(crate) struct Bag(pub(crate) Writer<BufWriter<File>>);

impl Bag {
    pub(crate) fn create(path: &Path, options: WriteOptions) -> Self {
        Self(options.create(BufWriter::new(File::create(path).unwrap())).unwrap())
    }

    /// Adds a topic of `sensor_msgs`, and returns its number.
    pub(crate) fn topic(&mut self, name: &str, kind: &str) -> u16 {
        let schema = format!("sensor_msgs/msg/{kind}");
        let schema = self.0.add_schema(&schema, "ros2msg", b"").unwrap();
        self.0.add_channel(schema, name, "cdr", &BTreeMap::new()).unwrap()
    }

    pub(crate) fn write(&mut self, channel_id: u16, sequence: u32, data: &[u8]) {
        let time = u64::from(sequence);
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        self.0.write_to_known_channel(&header, data).unwrap();
    }

    /// Adds a topic with one `camera_info`.
    pub(crate) fn calibration(&mut self, info: &Info) {
        let id = self.topic(&info.topic, "CameraInfo");
        self.write(id, 0, &info.message());
    }
}
