//! The framer of `firmware-sim/fpga/rtl` in simulation, by Verilator.
//!
//! The tests compare its bytes with those of the core's encoder. The program calibrates through its pins.

pub mod bench;
pub mod matches;
pub mod model;
pub mod spi;
