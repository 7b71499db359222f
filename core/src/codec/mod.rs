//! What survives a loss of power, as bytes: little endian, versioned, with its own checksum.
//!
//! | byte | what |
//! |---|---|
//! | 0 | magic `SCRC` |
//! | 4 | version of the layout |
//! | 5 | kind: 1 factory calibration, 2 state |
//! | 6 | bytes of a number: 4 or 8 |
//! | 7 | method: 0 none, 1 paper, 2 robust |
//! | 8 | fingerprint of cameras and factory extrinsics (kind 2), else 0 |
//! | 12 | the numbers, each type in the order of its fields |
//! | last 4 | CRC-32 of all before it |
//!
//! Version 2 adds the scene of the last pair at the end; a record of version 1 is read without. A later
//! version reads those before it: [`Reader::version`].

pub(crate) mod checksum;
mod reader;
mod writer;

pub(crate) use reader::{Reader, can_be_squares};
pub(crate) use writer::Writer;

use crate::error::RestoreError;
use crate::scalar::Scalar;

const MAGIC: [u8; 4] = *b"SCRC";

/// Version that is written; those from 1 on are read.
const VERSION: u8 = 2;

/// Bytes before the numbers, and after them.
pub(crate) const FRAME_BYTES: usize = 16;

/// What a record is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Factory,
    State,
}

impl Kind {
    fn number(self) -> u8 {
        match self {
            Self::Factory => 1,
            Self::State => 2,
        }
    }
}

/// What a record must be to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Label {
    pub(crate) kind: Kind,
    /// 0 where it does not matter.
    pub(crate) method: u8,
    pub(crate) rig: u32,
}

impl Label {
    pub(crate) const FACTORY: Self = Self { kind: Kind::Factory, method: 0, rig: 0 };

    fn write<T: Scalar>(self, to: &mut Writer<'_>) {
        to.bytes(&MAGIC);
        to.bytes(&[VERSION, self.kind.number(), T::BYTES, self.method]);
        to.word(self.rig);
    }

    /// Checks the first bytes of a record; its version.
    fn check<T: Scalar>(self, from: &mut Reader<'_>) -> Result<u8, RestoreError> {
        let [m0, m1, m2, m3, version, kind, scalar, method] = from.bytes()?;
        if [m0, m1, m2, m3] != MAGIC || kind != self.kind.number() {
            return Err(RestoreError::Foreign);
        }
        if !(1..=VERSION).contains(&version) {
            return Err(RestoreError::Version(version));
        }
        if scalar != T::BYTES {
            return Err(RestoreError::Scalar);
        }
        if method != self.method {
            return Err(RestoreError::Preset);
        }
        if from.word()? != self.rig {
            return Err(RestoreError::OtherRig);
        }
        Ok(version)
    }
}

/// Writes a record; the bytes of it.
///
/// # Errors
/// `Err` with the bytes that are needed, if there is less room.
pub(crate) fn write<T: Scalar>(
    label: Label,
    buffer: &mut [u8],
    body: impl FnOnce(&mut Writer<'_>),
) -> Result<&[u8], usize> {
    let mut writer = Writer::new(buffer);
    label.write::<T>(&mut writer);
    body(&mut writer);
    let needed = writer.finish();
    buffer.get(..needed).ok_or(needed)
}

/// Opens a record for its numbers to be read.
///
/// # Errors
/// [`RestoreError`].
pub(crate) fn open<T: Scalar>(label: Label, record: &[u8]) -> Result<Reader<'_>, RestoreError> {
    let mut reader = Reader::checked(record)?;
    reader.version = label.check::<T>(&mut reader)?;
    Ok(reader)
}
