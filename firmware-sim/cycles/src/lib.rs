//! A plugin of QEMU that counts the cycles of a Cortex-M4.
//!
//! QEMU translates a program in blocks of instructions and calls the plugin before each execution of a block. The plugin
//! adds the cycles of the block, and the refill of the pipeline if a branch led to it. The sum is in the last word of
//! flash, where the program reads it. The word counts down from `u32::MAX`, as the timer of the board does; without the
//! plugin it is zero.

#![cfg(any(target_os = "linux", test))]

mod decode;
mod model;
#[cfg(not(test))]
mod plugin;
