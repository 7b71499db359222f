//! Codec of the records that survive a loss of power: little endian, versioned, with a checksum.
//!
//! Reading a written record restores every number bit-identical. A record is refused as a whole:
//! nothing is restored from a damaged or foreign one.
//!
//! | byte | content |
//! |---|---|
//! | 0 | magic `SCRC` |
//! | 4 | layout version |
//! | 5 | kind: 1 factory calibration, 2 state |
//! | 6 | bytes per number: 4 or 8 |
//! | 7 | method: 0 none, 1 paper, 2 robust |
//! | 8 | fingerprint of cameras and factory extrinsics (kind 2), else 0 |
//! | 12 | numbers, each type in the order of its fields |
//! | last 4 | CRC-32 of all bytes before |
//!
//! Version 2 appends the scene of the last pair; version 1 is read without it. Version 3 has the lens coordinates
//! (twelve in the moments, formerly nine), the noise of disparities in moments and image halves, the correction of the
//! cameras that each of the extrinsics belongs to, and the lens that the rays of the pairs are corrected by. Version
//! 4 has the sums of a rig that vibrates in each hypothesis, and the vibration at the end. Version 5 has the second crowd
//! of matches and the matches of high leverage in each hypothesis. Version 6 has mount yaw and apparent yaw of the lens
//! at the end.

pub(crate) mod checksum;
mod reader;
mod writer;

pub(crate) use reader::{NEGATIVE, Reader, believe, check_sums_of_squares};
pub(crate) use writer::Writer;

use crate::error::RestoreError;
use crate::scalar::Scalar;

/// First bytes of every record.
const MAGIC: [u8; 4] = *b"SCRC";

/// Layout version of written records; versions 1 up to this one are read.
const VERSION: u8 = 6;

/// Length of header and checksum, bytes.
pub(crate) const OVERHEAD_BYTES: usize = 16;

/// Kind of a stored record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RecordKind {
    /// Factory calibration, written once in production.
    Factory,
    /// State of the calibrator: everything estimated since.
    State,
}

impl RecordKind {
    /// Every kind.
    pub(crate) const ALL: [Self; 2] = [Self::Factory, Self::State];

    /// Number on flash; fixed, because records of earlier firmware hold it.
    pub(crate) const fn number(self) -> u8 {
        match self {
            Self::Factory => 1,
            Self::State => 2,
        }
    }
}

/// Header that a record must hold to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RecordHeader {
    /// Kind of the record.
    pub(crate) kind: RecordKind,
    /// Method of the estimator; 0 for factory calibration.
    pub(crate) method: u8,
    /// Fingerprint of cameras and factory extrinsics; 0 for factory calibration.
    pub(crate) rig: u32,
}

impl RecordHeader {
    /// Header of the factory calibration.
    pub(crate) const FACTORY: Self = Self { kind: RecordKind::Factory, method: 0, rig: 0 };

    /// Writes the first 12 bytes.
    fn write<T: Scalar>(self, to: &mut Writer<'_>) {
        to.bytes(&MAGIC);
        to.bytes(&[VERSION, self.kind.number(), T::BYTES, self.method]);
        to.word(self.rig);
    }

    /// Checks the header of a record and returns its layout version.
    ///
    /// # Errors
    /// [`RestoreError`] names the first field that differs.
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

/// Writes a record: header, numbers by `body`, checksum. Returns its bytes.
///
/// # Errors
/// Length that the record needs, in bytes, if the buffer is shorter.
pub(crate) fn write<T: Scalar>(
    header: RecordHeader,
    buffer: &mut [u8],
    body: impl FnOnce(&mut Writer<'_>),
) -> Result<&[u8], usize> {
    let mut writer = Writer::new(buffer);
    header.write::<T>(&mut writer);
    body(&mut writer);
    let needed = writer.finish();
    buffer.get(..needed).ok_or(needed)
}

/// Checks a record and returns a reader of its numbers.
///
/// # Errors
/// [`RestoreError`]: damaged, or its header differs from `header`.
pub(crate) fn open<T: Scalar>(
    header: RecordHeader,
    record: &[u8],
) -> Result<Reader<'_>, RestoreError> {
    let mut reader = Reader::checked(record)?;
    reader.version = header.check::<T>(&mut reader)?;
    Ok(reader)
}
