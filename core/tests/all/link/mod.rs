//! Wire format, decoder and drivers: frames are received exactly, or not at all.

#[cfg(feature = "async")]
mod asynchronous;
mod calibrator;
mod counters;
mod damage;
mod encoder;
mod format;
mod fpga;
mod roundtrip;
mod sink;
mod stream;
mod tracking;
mod uart;
mod vectors;
