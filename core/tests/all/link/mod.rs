//! Wire format, decoder and drivers: undamaged frames are received exactly, for any damage of others.

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
