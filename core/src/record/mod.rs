//! Records that outlast a loss of power: their bytes, and the record of a factory calibration. `calibrator::record` has
//! the record of the state of a calibrator, as a prior.
//!
//! `FORMAT.md` defines the bytes of both records. Numbers are `f32`, also for a calibrator in `f64`. A record is refused
//! as a whole if it is damaged, of another kind, layout or rig, or beyond what the configuration allows, or if a number
//! is out of its range.

pub(crate) mod codec;
pub(crate) mod factory;

use crate::error::RestoreError;

/// First bytes of every record.
const MAGIC: [u8; 4] = *b"SCRC";

/// Number of the layout of the records. Any change of a layout changes this number.
const LAYOUT: u8 = 7;

/// Kinds of records.
const FACTORY: u8 = 1;
pub(crate) const STATE: u8 = 2;

/// Length of the header, bytes: magic, layout, kind and two more bytes.
pub(crate) const HEADER_BYTES: usize = 8;
/// Length of header and checksum together, bytes.
pub(crate) const OVERHEAD_BYTES: usize = HEADER_BYTES + 4;

/// Refuses a number out of its range.
///
/// # Errors
/// [`RestoreError::Absurd`].
pub(crate) fn believe(is_in_range: bool) -> Result<(), RestoreError> {
    if is_in_range { Ok(()) } else { Err(RestoreError::Absurd) }
}
