//! Writer of MCAP files (<https://mcap.dev/spec>) with images and their calibrations.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use image::GrayImage;

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

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// A bag that is written.
pub(crate) struct Bag {
    path: PathBuf,
    bytes: Vec<u8>,
    /// Records of the chunk that is filled.
    chunk: Vec<u8>,
    /// A chunk ends when it has as many bytes.
    chunk_bytes: usize,
    /// `lz4`, `zstd`, or nothing.
    compression: &'static str,
    topics: u16,
    messages: u64,
}

impl Bag {
    pub(crate) fn create(path: &Path, chunk_bytes: usize, compression: &'static str) -> Self {
        let mut bytes = MAGIC.to_vec();
        record(&mut bytes, 0x01, &[text("ros2"), text("test")]);
        let (path, chunk) = (path.to_owned(), Vec::new());
        Self { path, bytes, chunk, chunk_bytes, compression, topics: 0, messages: 0 }
    }

    /// Adds a topic of `sensor_msgs`, and returns its number.
    pub(crate) fn topic(&mut self, name: &str, kind: &str) -> u16 {
        self.topics += 1;
        let (id, kind) = (self.topics.to_le_bytes().to_vec(), format!("sensor_msgs/msg/{kind}"));
        let no_data = 0_u32.to_le_bytes().to_vec();
        let schema = [id.clone(), text(&kind), text("ros2msg"), no_data.clone()];
        record(&mut self.chunk, 0x03, &schema);
        record(&mut self.chunk, 0x04, &[id.clone(), id, text(name), text("cdr"), no_data]);
        self.topics
    }

    pub(crate) fn write(&mut self, topic: u16, sequence: u32, data: &[u8]) {
        let time = u64::from(sequence).to_le_bytes().to_vec();
        let head = [topic.to_le_bytes().to_vec(), sequence.to_le_bytes().to_vec()];
        record(&mut self.chunk, 0x05, &[head.concat(), time.repeat(2), data.to_vec()]);
        self.messages += 1;
        if self.chunk.len() >= self.chunk_bytes {
            self.end_chunk();
        }
    }

    fn end_chunk(&mut self) {
        let records = std::mem::take(&mut self.chunk);
        let packed = match self.compression {
            "lz4" => {
                let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
                packed.write_all(&records).unwrap();
                packed.finish().unwrap()
            }
            "zstd" => zstd::encode_all(&records[..], 1).unwrap(),
            _ => records.clone(),
        };
        let times = vec![0; 16];
        let length = (records.len() as u64).to_le_bytes().to_vec();
        let sum = crc32fast::hash(&records).to_le_bytes().to_vec();
        let stored = (packed.len() as u64).to_le_bytes().to_vec();
        let body = [times, length, sum, text(self.compression), stored, packed];
        record(&mut self.bytes, 0x06, &body);
    }

    pub(crate) fn finish(mut self) {
        self.end_chunk();
        // Numbers of schemas, channels, attachments, metadata and chunks, first and last time, messages of each channel.
        let counts = [self.messages.to_le_bytes().to_vec(), vec![0; 2 + 4 + 4 + 4 + 4 + 8 + 8 + 4]];
        record(&mut self.bytes, 0x0b, &counts);
        record(&mut self.bytes, 0x0f, &[vec![0; 4]]);
        record(&mut self.bytes, 0x02, &[vec![0; 8 + 8 + 4]]);
        self.bytes.extend(MAGIC);
        fs::write(self.path, self.bytes).unwrap();
    }

    /// Adds a topic with one `camera_info`.
    pub(crate) fn calibration(&mut self, info: &Info) {
        let id = self.topic(&info.topic, "CameraInfo");
        self.write(id, 0, &info.message());
    }
}

/// Adds a record: operation code, length, body.
fn record(to: &mut Vec<u8>, code: u8, body: &[Vec<u8>]) {
    let body = body.concat();
    to.push(code);
    to.extend((body.len() as u64).to_le_bytes());
    to.extend(body);
}

/// A text after its length.
fn text(text: &str) -> Vec<u8> {
    [&u32::try_from(text.len()).unwrap().to_le_bytes(), text.as_bytes()].concat()
}
