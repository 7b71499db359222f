//! Wire format, decoder and drivers: undamaged frames are received exactly, whatever happens to others.
#![allow(
    clippy::unwrap_used,
    clippy::as_conversions,
    clippy::cast_possible_truncation,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a test that panics is a test that fails"
)]

#[cfg(feature = "async")]
mod asynchronous;
mod bus;
mod calibrator;
mod counters;
mod damage;
mod encoder;
mod format;
mod fpga;
mod roundtrip;
mod stream;
mod uart;
mod vectors;
