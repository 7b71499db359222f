//! Records that outlast a loss of power: the factory calibration, and the state of a calibrator as a prior.
//!
//! `FORMAT.md` has the bytes of both. Numbers are `f32` in either scalar. A record is refused as a whole if it is
//! damaged, foreign or of another layout, or holds a number out of its range.

pub(crate) mod factory;
mod reader;
pub(crate) mod state;
mod writer;

use crate::error::RestoreError;

/// First bytes of every record.
const MAGIC: [u8; 4] = *b"SCRC";

/// Layout of the records. Any change of a layout changes it.
const LAYOUT: u8 = 7;

/// Bytes of magic, layout, kind and two bytes more, and of the checksum at the end.
const OVERHEAD_BYTES: usize = 12;

/// Kind of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Factory,
    State,
}

impl Kind {
    const fn number(self) -> u8 {
        match self {
            Self::Factory => 1,
            Self::State => 2,
        }
    }
}

/// Refuses a number out of its range.
///
/// # Errors
/// [`RestoreError::Absurd`].
fn believe(is_in_range: bool) -> Result<(), RestoreError> {
    if is_in_range { Ok(()) } else { Err(RestoreError::Absurd) }
}
