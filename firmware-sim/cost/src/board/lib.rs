//! Measures instructions and stack of the core's calls on an emulated controller.
//!
//! Runs in QEMU with `-icount shift=10`. Prints one `name,unit,value` per line over semihosting.

#![no_std]
#![cfg(target_os = "none")]

mod calls;
mod clock;
mod frame;
mod lens;
mod measurement;
mod pair;
mod probe;
mod scene;
mod stack;
mod states;
mod store;
mod table;
mod whole_way;

pub use measurement::measure;
