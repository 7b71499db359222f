//! Firmware of a controller that calibrates a stereo rig from what a hardware matcher sends.
//!
//! [`App`]: the application loop over the matcher's driver, which is the core's
//! ([`stereo_selfcal::link`]), and the calibrator. No heap, no clock; every call is bounded by one read
//! of 256 bytes or by two passes over one batch: a pair's last, which judges it and both calibrations.
//! Scalar: `f32`.
//!
//! Two stand in for the matcher: [`baked`], a recording in flash, and [`pil`], a host at the other end
//! of a line. The board of the latter is the module `board`, on the controller alone.

#![no_std]
#![cfg_attr(not(target_os = "none"), forbid(unsafe_code))]
#![cfg_attr(target_os = "none", deny(unsafe_code))]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::unreachable,
    clippy::as_conversions
)]

#[cfg(test)]
extern crate std;

mod app;
pub mod baked;
#[cfg(all(target_os = "none", feature = "board"))]
#[expect(unsafe_code, reason = "registers")]
#[expect(clippy::as_conversions, reason = "their addresses")]
pub mod board;
mod controller;
pub mod pil;
#[cfg(test)]
mod test_bus;

pub use app::{App, Event, PairOutcome};
pub use controller::{CAPACITY, Controller, solve_and_fuse, start, start_automatic};
