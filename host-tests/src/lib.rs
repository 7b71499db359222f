//! Data sets, generator, simulated link and runs of the calibrator on a host.
//!
//! The commands are in `host-tests/selfcal`, the methods for comparison in `host-tests/rivals`.

pub mod bounds;
pub mod chart;
pub mod data;
pub mod run;
pub mod stats;
pub mod synth;
pub mod wire;

/// The Rust code of the README, compiled.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;

/// Whether an error is due to a closed output, as with `| head`.
#[must_use]
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<std::io::Error>().map(std::io::Error::kind);
    kind == Some(std::io::ErrorKind::BrokenPipe)
}
