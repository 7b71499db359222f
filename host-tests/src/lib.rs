//! Everything that proves the core on a host: recorded and generated data, independent references,
//! replay, evaluation.
//!
//! Data, generator, runs, charts and the simulated link are always built; baselines, bounds, evidence and
//! the files of other tools with the feature `selfcal`.

#[cfg(feature = "selfcal")]
pub mod baselines;
#[cfg(feature = "selfcal")]
pub mod bounds;
pub mod chart;
pub mod data;
#[cfg(feature = "selfcal")]
pub mod evidence;
pub mod run;
pub mod synth;
pub mod wire;

/// The Rust code of the README, compiled.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;

/// Whether an error comes of a closed output, as by `| head`.
#[must_use]
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<std::io::Error>().map(std::io::Error::kind);
    kind == Some(std::io::ErrorKind::BrokenPipe)
}
