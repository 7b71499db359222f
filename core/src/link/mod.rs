//! Link to a matcher: receives its frames into a batch.
//!
//! [`FrameHeader`] and [`MatchRecord`] encode and decode the wire format; [`Encoder`] makes whole frames of them.
//! [`Decoder`] finds whole frames in a byte stream and resynchronises after damage. [`FrameSink`] receives the matches:
//! a [`Calibrator`](crate::Calibrator), a [`Tracking`] calibrator, or a buffer of the caller. [`FpgaMatcher`] drives
//! SPI with a data-ready pin, [`StreamMatcher`] a UART or a DMA ring. The estimator does not depend on this module.
#![doc = ""]
#![doc = include_str!("FORMAT.md")]

mod counters;
mod crc;
mod decoder;
mod encoder;
mod event;
mod fpga;
mod frame;
mod header;
mod held;
mod layout;
mod read_buffer;
mod receiver;
mod record;
mod sink;
mod stream;
mod tracking;

pub use counters::Counters;
pub use crc::FrameCrc;
pub use decoder::Decoder;
pub use encoder::Encoder;
pub use event::Event;
pub use fpga::FpgaMatcher;
pub use header::{FrameHeader, HeaderError};
pub use receiver::{FrameReceiver, ReadStatus, ReceiveError};
pub use record::{EncodeError, MatchRecord};
pub use sink::{FrameRefusal, FrameSink, Received};
pub use stream::StreamMatcher;
pub use tracking::Tracking;
