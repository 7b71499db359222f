//! Images and calibrations in the messages of ROS: `sensor_msgs` `Image`, `CompressedImage`, `CameraInfo`.
//!
//! ROS 2 writes CDR (aligned, little endian after a header of 4 bytes), ROS 1 packs.

use std::fmt::Write;

use anyhow::{Context, Result, bail, ensure};

use crate::picture::Picture;

/// How numbers lie in a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// ROS 2.
    Cdr,
    /// ROS 1.
    Packed,
}

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

/// Reads the fields of a message, in their order.
struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl<'a> Fields<'a> {
    fn new(bytes: &'a [u8], encoding: Encoding) -> Result<Self> {
        let bytes = match encoding {
            Encoding::Packed => bytes,
            Encoding::Cdr => {
                let (start, rest) = bytes.split_at_checked(4).context("shorter than its header")?;
                ensure!(matches!(start, [0, 1, ..]), "not CDR in little endian");
                rest
            }
        };
        Ok(Self { bytes, at: 0, encoding })
    }

    fn take(&mut self, count: usize, align: usize) -> Result<&'a [u8]> {
        if self.encoding == Encoding::Cdr {
            self.at = self.at.next_multiple_of(align);
        }
        let end = self.at.checked_add(count).context("a length out of range")?;
        let bytes = self.bytes.get(self.at..end).context("the message is cut short")?;
        self.at = end;
        Ok(bytes)
    }

    fn u8(&mut self) -> Result<u8> {
        Ok(self.take(1, 1)?[0])
    }

    fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.take(4, 4)?.try_into()?))
    }

    fn f64(&mut self) -> Result<f64> {
        Ok(f64::from_le_bytes(self.take(8, 8)?.try_into()?))
    }

    fn data(&mut self) -> Result<&'a [u8]> {
        let count = self.u32()? as usize;
        self.take(count, 1)
    }

    fn text(&mut self) -> Result<&'a str> {
        let bytes = self.data()?;
        Ok(std::str::from_utf8(bytes.strip_suffix(&[0]).unwrap_or(bytes))?)
    }

    /// Time stamp, s.
    fn header(&mut self) -> Result<f64> {
        if self.encoding == Encoding::Packed {
            let _sequence = self.u32()?;
        }
        let [seconds, nanoseconds] = [self.u32()?, self.u32()?];
        let _frame = self.text()?;
        Ok(f64::from(seconds) + f64::from(nanoseconds) * 1e-9)
    }
}

impl ImageMessage {
    /// Takes a message over.
    ///
    /// # Errors
    /// If it has no header.
    pub fn new(topic: &str, encoding: Encoding, compressed: bool, bytes: Vec<u8>) -> Result<Self> {
        let stamp = Fields::new(&bytes, encoding)?.header()?;
        Ok(Self { topic: topic.to_owned(), stamp, encoding, compressed, bytes })
    }

    /// Decodes it.
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
        let (channels, bytes) = match encoding {
            "mono8" | "8UC1" => (1, 1),
            "mono16" | "16UC1" => (1, 2),
            "rgb8" | "bgr8" | "8UC3" => (3, 1),
            "rgba8" | "bgra8" => (4, 1),
            // The mosaic is kept: its pattern is the same left and right.
            other if other.starts_with("bayer_") && other.ends_with('8') => (1, 1),
            other => bail!(
                "encoding {other}: mono, rgb, bgr and bayer of 8 bits, and mono16 are handled"
            ),
        };
        let line = width.checked_mul(channels * bytes).context("a width out of range")?;
        ensure!(step >= line && line > 0, "lines of {step} bytes for {width} px of {encoding}");
        let whole = height.checked_mul(step).context("a height out of range")?;
        ensure!(data.len() >= whole, "{} bytes of {width} x {height} px {encoding}", data.len());
        let lines = data.chunks_exact(step).take(height).map(|bytes| &bytes[..line]);
        let size = [width, height];
        if bytes == 2 {
            let order = if big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
            let pixel = |two: &[u8]| order([two[0], two[1]]);
            let pixels: Vec<u16> = lines.flat_map(|line| line.chunks_exact(2).map(pixel)).collect();
            return Picture::of_16_bits(size, &pixels);
        }
        // ITU-R BT.601; the order of red and blue hardly matters to corners.
        let weights = if encoding.starts_with("bgr") { [29, 150, 77] } else { [77, 150, 29] };
        let grey = |pixel: &[u8]| match pixel {
            [grey] => *grey,
            colours => {
                let sum: u32 = colours.iter().zip(weights).map(|(c, w)| u32::from(*c) * w).sum();
                (sum >> 8) as u8
            }
        };
        Picture::try_new(
            size,
            lines.flat_map(|line| line.chunks_exact(channels).map(grey)).collect(),
        )
    }
}

/// A `CameraInfo` as the YAML file that ROS keeps of it; `None` if it is not calibrated (`K` is 0).
///
/// # Errors
/// If the message is damaged.
pub(super) fn camera_info(bytes: &[u8], encoding: Encoding) -> Result<Option<String>> {
    let mut fields = Fields::new(bytes, encoding)?;
    fields.header()?;
    let [height, width] = [fields.u32()?, fields.u32()?];
    let model = fields.text()?.to_owned();
    let count = fields.u32()? as usize;
    ensure!(count <= 32, "{count} lens coefficients");
    let mut numbers = |count: usize| (0..count).map(|_| fields.f64()).collect::<Result<Vec<f64>>>();
    let (d, k, r, p) = (numbers(count)?, numbers(9)?, numbers(9)?, numbers(12)?);
    if k[0] == 0.0 {
        return Ok(None);
    }
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
    Ok(Some(text))
}
