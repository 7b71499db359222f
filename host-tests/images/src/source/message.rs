//! Images and calibrations in the messages of ROS: `sensor_msgs` `Image`, `CompressedImage`, `CameraInfo`.

use std::fmt::Write;

use anyhow::{Context, Result, bail, ensure};

use super::fields::{Encoding, Fields};
use crate::picture::Picture;

/// A message of an image, not decoded.
#[derive(Debug, Clone)]
pub struct ImageMessage {
    /// Its topic.
    pub topic: String,
    /// Time stamp of the header, s.
    pub stamp: f64,
    encoding: Encoding,
    compressed: bool,
    bytes: Vec<u8>,
}

impl ImageMessage {
    /// A message from its bytes.
    ///
    /// # Errors
    /// If it has no header.
    pub fn new(topic: &str, encoding: Encoding, compressed: bool, bytes: Vec<u8>) -> Result<Self> {
        let stamp = Fields::new(&bytes, encoding)?.header()?;
        Ok(Self { topic: topic.to_owned(), stamp, encoding, compressed, bytes })
    }

    /// Decodes the image.
    ///
    /// # Errors
    /// Names the topic and the time.
    pub fn picture(&self) -> Result<Picture> {
        let decoded = if self.compressed { self.decode() } else { self.raw() };
        decoded.with_context(|| format!("{} at {:.3} s", self.topic, self.stamp))
    }

    fn decode(&self) -> Result<Picture> {
        let mut fields = Fields::new(&self.bytes, self.encoding)?;
        fields.header()?;
        let _format = fields.text()?;
        Picture::decode(fields.data()?)
    }

    fn raw(&self) -> Result<Picture> {
        let mut fields = Fields::new(&self.bytes, self.encoding)?;
        fields.header()?;
        let [height, width] = [fields.u32()? as usize, fields.u32()? as usize];
        let encoding = fields.text()?;
        let big_endian = fields.u8()? != 0;
        let step = fields.u32()? as usize;
        let data = fields.data()?;
        let Pixels { channels, bytes, weights, is_mosaic } = Pixels::of(encoding)?;
        let line = width.checked_mul(channels * bytes).context("a width out of range")?;
        ensure!(step >= line && line > 0, "lines of {step} bytes for {width} px of {encoding}");
        let whole = height.checked_mul(step).context("a height out of range")?;
        ensure!(data.len() >= whole, "{} bytes of {width} x {height} px {encoding}", data.len());
        let lines = data.chunks_exact(step).take(height).map(|bytes| &bytes[..line]);
        let size = [width, height];
        let order = if big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
        let value = |value: &[u8]| match value {
            [one] => u32::from(*one),
            [one, two] => u32::from(order([*one, *two])),
            _ => 0,
        };
        let grey = |pixel: &[u8]| -> u16 {
            let sum: u32 = pixel.chunks_exact(bytes).zip(weights).map(|(c, w)| value(c) * w).sum();
            (sum >> 8) as u16
        };
        let pixel = channels * bytes;
        let mut pixels: Vec<u16> =
            lines.flat_map(|line| line.chunks_exact(pixel).map(grey)).collect();
        if is_mosaic {
            pixels = without_mosaic(&pixels, size);
        }
        if bytes == 2 {
            return Picture::of_16_bits(size, &pixels);
        }
        Picture::try_new(size, pixels.into_iter().map(|grey| grey as u8).collect())
    }
}

/// Layout of the pixels of an encoding, and grey weights of its channels in 256ths.
struct Pixels {
    channels: usize,
    /// Bytes of one channel of a pixel.
    bytes: usize,
    weights: [u32; 4],
    is_mosaic: bool,
}

impl Pixels {
    fn of(encoding: &str) -> Result<Self> {
        // ITU-R BT.601.
        let (rgb, bgr) = ([77, 150, 29, 0], [29, 150, 77, 0]);
        let first = [256, 0, 0, 0];
        let is_mosaic = encoding.starts_with("bayer_");
        let (channels, bytes, weights) = match encoding {
            // Brightness comes first in the planes of NV12, and first or second in the pairs of 4:2:2.
            "mono8" | "8UC1" | "8SC1" | "nv12" | "nv21" | "NV12" | "NV21" | "nv24" | "yuv420"
            | "i420" => (1, 1, first),
            "mono16" | "16UC1" | "16SC1" => (1, 2, first),
            "rgb8" | "8UC3" => (3, 1, rgb),
            "bgr8" => (3, 1, bgr),
            "rgba8" | "8UC4" => (4, 1, rgb),
            "bgra8" => (4, 1, bgr),
            "rgb16" | "16UC3" => (3, 2, rgb),
            "bgr16" => (3, 2, bgr),
            "rgba16" | "16UC4" => (4, 2, rgb),
            "bgra16" => (4, 2, bgr),
            "yuv422" | "uyvy" | "UYVY" | "yuv422_uyvy" => (2, 1, [0, 256, 0, 0]),
            "yuv422_yuy2" | "yuyv" | "YUYV" | "yuy2" | "8UC2" => (2, 1, first),
            _ if is_mosaic && encoding.ends_with("16") => (1, 2, first),
            _ if is_mosaic && encoding.ends_with('8') => (1, 1, first),
            _ => bail!(
                "encoding {encoding}: mono, rgb, bgr, rgba, bgra and bayer of 8 and 16 bits, yuv422, yuv422_yuy2, nv12 and nv21 are \
                 handled; convert the topic to mono8 (image_proc, cv_bridge)"
            ),
        };
        Ok(Self { channels, bytes, weights, is_mosaic })
    }
}

/// A colour mosaic as grey, smoothed with the weights 1 2 1 along rows and columns. At any place of the pattern, the
/// result is half green, a quarter red and a quarter blue.
fn without_mosaic(pixels: &[u16], [width, height]: [usize; 2]) -> Vec<u16> {
    // The neighbour beyond a border is replaced by the neighbour on the other side, which has the same colour.
    let near = |i: usize, length: usize| {
        let after = if i + 1 < length { i + 1 } else { i.saturating_sub(1) };
        [i.checked_sub(1).unwrap_or(after), i, after]
    };
    let at = |x: usize, y: usize| u32::from(pixels[y * width + x]);
    let across = |x: usize, y: usize| {
        let [a, b, c] = near(x, width);
        at(a, y) + 2 * at(b, y) + at(c, y)
    };
    let grey = |x: usize, y: usize| {
        let [a, b, c] = near(y, height);
        ((across(x, a) + 2 * across(x, b) + across(x, c) + 8) / 16) as u16
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| grey(x, y)).collect()
}

/// A `CameraInfo`: its calibration as the YAML file that ROS writes, and the part of the sensor that the images cover.
#[derive(Debug, Clone)]
pub(super) struct CameraInfo {
    /// The calibration as YAML.
    pub(super) text: String,
    /// Number of pixels combined into one, across and down; 0 means 1.
    pub(super) binning: [u32; 2],
    /// Region of interest before binning: x, y, width, height, px; width or height 0 means the whole sensor.
    pub(super) roi: [u32; 4],
}

/// Reads a `CameraInfo`.
///
/// # Errors
/// If the message is damaged.
pub(super) fn camera_info(bytes: &[u8], encoding: Encoding) -> Result<CameraInfo> {
    let mut fields = Fields::new(bytes, encoding)?;
    fields.header()?;
    let [height, width] = [fields.u32()?, fields.u32()?];
    let model = fields.text()?.to_owned();
    let count = fields.u32()? as usize;
    ensure!(count <= 32, "{count} lens coefficients");
    let mut numbers = |count: usize| (0..count).map(|_| fields.f64()).collect::<Result<Vec<f64>>>();
    let (d, k, r, p) = (numbers(count)?, numbers(9)?, numbers(9)?, numbers(12)?);
    let mut text =
        format!("image_width: {width}\nimage_height: {height}\ndistortion_model: {model}\n");
    for (name, rows, numbers) in [
        ("camera_matrix", 3, &k),
        ("distortion_coefficients", 1, &d),
        ("rectification_matrix", 3, &r),
        ("projection_matrix", 3, &p),
    ] {
        let cols = numbers.len() / rows;
        writeln!(text, "{name}:\n  rows: {rows}\n  cols: {cols}\n  data: {numbers:?}")?;
    }
    let mut four = || [0, 1, 2, 3].map(|_| fields.u32().unwrap_or(0));
    // If the message ends before these fields, they count as 0: no binning, and the whole sensor.
    let [binning_x, binning_y, x, y] = four();
    let [roi_height, roi_width, ..] = four();
    Ok(CameraInfo { text, binning: [binning_x, binning_y], roi: [x, y, roi_width, roi_height] })
}
