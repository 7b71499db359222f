//! Firmware of a controller that calibrates a stereo rig from the frames of a hardware matcher.
//!
//! [`App`] is the application loop over the core's driver of the matcher ([`stereo_selfcal::link`]) and the
//! calibrator. It needs no heap and no clock. Each call takes at most one read of 256 bytes, or two passes
//! over one batch: the last call of a pair evaluates the pair and both calibrations. With [`App::tracking`] that
//! call also reads the tracks. Scalar: `f32`.
//!
//! [`recording`], frames in flash, simulates the matcher. [`checksums`] shows whether two processors compute the same
//! bits. The module `board` drives the emulated board; it exists on the controller only.

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
#[cfg(all(target_os = "none", feature = "board"))]
#[expect(unsafe_code, reason = "access to registers")]
#[expect(clippy::as_conversions, reason = "addresses of registers")]
pub mod board;
mod checksums;
mod controller;
pub mod recording;
#[cfg(test)]
mod test_frames;

pub use app::{App, Event, PairOutcome};
pub use checksums::checksums;
pub use controller::{CAPACITY, Controller, solve_and_fuse, start};
