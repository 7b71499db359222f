//! Fields of binary messages and records, in their order.
//!
//! ROS 2 writes CDR: a header of 4 bytes, then aligned little-endian fields. ROS 1 and MCAP write the fields without
//! alignment.

use anyhow::{Context, Result, ensure};

/// Layout of numbers in a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// ROS 2.
    Cdr,
    /// ROS 1.
    Packed,
}

/// Reads the fields of a message, in their order.
pub(super) struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl<'a> Fields<'a> {
    pub(super) fn new(bytes: &'a [u8], encoding: Encoding) -> Result<Self> {
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

    /// Fields without alignment.
    pub(super) fn packed(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, encoding: Encoding::Packed }
    }

    /// The bytes after the fields read so far.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
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

    pub(super) fn u8(&mut self) -> Result<u8> {
        Ok(self.take(1, 1)?[0])
    }

    pub(super) fn u16(&mut self) -> Result<u16> {
        Ok(u16::from_le_bytes(self.take(2, 2)?.try_into()?))
    }

    pub(super) fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.take(4, 4)?.try_into()?))
    }

    pub(super) fn u64(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.take(8, 8)?.try_into()?))
    }

    pub(super) fn f64(&mut self) -> Result<f64> {
        Ok(f64::from_le_bytes(self.take(8, 8)?.try_into()?))
    }

    pub(super) fn data(&mut self) -> Result<&'a [u8]> {
        let count = self.u32()? as usize;
        self.take(count, 1)
    }

    pub(super) fn text(&mut self) -> Result<&'a str> {
        let bytes = self.data()?;
        Ok(std::str::from_utf8(bytes.strip_suffix(&[0]).unwrap_or(bytes))?)
    }

    /// Reads the header; returns its time stamp, s.
    pub(super) fn header(&mut self) -> Result<f64> {
        if self.encoding == Encoding::Packed {
            let _sequence = self.u32()?;
        }
        let [seconds, nanoseconds] = [self.u32()?, self.u32()?];
        let _frame = self.text()?;
        Ok(f64::from(seconds) + f64::from(nanoseconds) * 1e-9)
    }
}
