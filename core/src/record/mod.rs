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
//! A later version may only add to the end of what one type writes, and reads what is not there as
//! nothing: [`Reader::version`].

mod reader;
mod writer;

pub(crate) use reader::Reader;
pub(crate) use writer::Writer;

use crate::error::RestoreError;
use crate::scalar::Scalar;

const MAGIC: [u8; 4] = *b"SCRC";

/// Version that is written; those from 1 on are read.
const VERSION: u8 = 1;

/// Bytes before the numbers, and after them.
pub(crate) const FRAME_BYTES: usize = 16;

/// What a record is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Factory,
    State,
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

    fn write<T: Scalar>(&self, to: &mut Writer<'_>) {
        let kind = match self.kind {
            Kind::Factory => 1,
            Kind::State => 2,
        };
        to.bytes(&MAGIC);
        to.bytes(&[VERSION, kind, T::BYTES, self.method]);
        to.word(self.rig);
    }

    /// Checks the first bytes of a record; its version.
    fn check<T: Scalar>(&self, from: &mut Reader<'_>) -> Result<u8, RestoreError> {
        let mut own = [0; 12];
        let mut writer = Writer::new(&mut own);
        self.write::<T>(&mut writer);
        let [.., kind, scalar, method, _, _, _, _] = own;
        let [m0, m1, m2, m3, version, its_kind, its_scalar, its_method] = from.bytes::<8>()?;
        if [m0, m1, m2, m3] != MAGIC || its_kind != kind {
            return Err(RestoreError::Foreign);
        }
        if !(1..=VERSION).contains(&version) {
            return Err(RestoreError::Version(version));
        }
        if its_scalar != scalar {
            return Err(RestoreError::Scalar);
        }
        if its_method != method {
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
pub(crate) fn write<'b, T: Scalar>(
    label: &Label,
    buffer: &'b mut [u8],
    body: impl FnOnce(&mut Writer<'_>),
) -> Result<&'b [u8], usize> {
    let mut writer = Writer::new(buffer);
    label.write::<T>(&mut writer);
    body(&mut writer);
    let needed = writer.finish();
    let room = buffer.len();
    buffer.get(..needed).filter(|_| needed <= room).ok_or(needed)
}

/// Opens a record for its numbers to be read.
///
/// # Errors
/// [`RestoreError`].
pub(crate) fn open<'r, T: Scalar>(
    label: &Label,
    record: &'r [u8],
) -> Result<Reader<'r>, RestoreError> {
    let mut reader = Reader::checked(record)?;
    reader.version = label.check::<T>(&mut reader)?;
    Ok(reader)
}
