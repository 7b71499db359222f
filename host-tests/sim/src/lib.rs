//! Generated scenes, the matcher's side of the link, bounds, and runs of the calibrator on a host.
//!
//! [`synth`] makes pairs of known rigs: a new scene is a kind of `synth::ScenarioKind`. [`wire`] sends pairs as frames and
//! damages them. [`run`] feeds a data set to the calibrator, and sums up the results. [`bounds`] has the best possible
//! estimates to compare with.
#![allow(
    clippy::missing_errors_doc,
    clippy::must_use_candidate,
    clippy::return_self_not_must_use,
    reason = "only this workspace uses the package"
)]

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
