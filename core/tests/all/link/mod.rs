//! Wire format, decoder and drivers: undamaged frames are received exactly, whatever the damage of other frames.

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
