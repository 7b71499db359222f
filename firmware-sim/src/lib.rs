//! Firmware of a controller that calibrates a stereo rig from what a hardware matcher sends.
//!
//! [`frame`]: the bytes on the bus. [`Matcher`]: the driver that reads them, over `embedded-hal`
//! traits. [`App`]: the application loop over driver and calibrator. No heap, no clock; every call
//! is bounded by the length of one frame or by four passes over one batch: a pair's last, which judges
//! it and both calibrations. Scalar: `f32`.

#![no_std]
#![forbid(unsafe_code)]
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
mod controller;
pub mod frame;
mod matcher;
#[cfg(test)]
mod test_bus;

pub use app::{App, Event, PairOutcome};
pub use controller::{CAPACITY, Controller, solve_and_fuse, start, start_automatic};
pub use matcher::{Matcher, MatcherError};
