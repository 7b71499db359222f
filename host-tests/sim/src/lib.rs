//! Generated scenes, the matcher's side of the link, bounds, and runs of the calibrator on a host.

pub mod bounds;
mod exit;
pub mod run;
pub mod stats;
pub mod synth;
pub mod wire;

pub use exit::exit;

/// The Rust code of the README, compiled.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
pub struct Readme;
