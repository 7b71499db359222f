//! The link to a matcher: its frames off the wire, into a batch.
//!
//! [`FrameHeader`] and [`MatchRecord`] are the bytes; [`Decoder`] finds whole frames in any stream of them
//! and loses no frame but those that were damaged; [`FrameSink`] is what a frame goes into, a
//! [`Calibrator`](crate::Calibrator) for one. [`FpgaMatcher`] reads from SPI and a data-ready line,
//! [`StreamMatcher`] from a UART or a ring that DMA fills. Nothing of the mathematics depends on it.
#![doc = ""]
#![doc = include_str!("FORMAT.md")]

mod counters;
mod crc;
mod decoder;
mod event;
#[cfg(test)]
mod format_tests;
mod fpga;
mod frame;
mod header;
mod read_buffer;
mod record;
mod sink;
mod stream;
mod window;

pub use counters::Counters;
pub use crc::FrameCrc;
pub use decoder::Decoder;
pub use event::{Damage, Event};
pub use fpga::{FpgaError, FpgaMatcher};
pub use header::{FrameHeader, HeaderError};
pub use read_buffer::ReadStatus;
pub use record::{EncodeError, MatchRecord, RecordError};
pub use sink::{FrameRefusal, FrameSink, Received};
pub use stream::{StreamError, StreamMatcher};
