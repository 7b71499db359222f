//! What the core costs on an emulated controller: exact instructions and the depth of the stack.
//!
//! Runs under QEMU with `-icount shift=10`. Prints one `name,unit,value` a line over semihosting; lines
//! that start with `#` tell of each call.

#![no_std]

mod calls;
mod clock;
mod frame;
mod lens;
mod measurement;
mod pair;
mod probe;
mod scene;
mod stack;
mod table;

pub use measurement::survey;
