//! Everything that proves the core on a host: recorded and generated data, independent references,
//! replay, evaluation.

pub mod baselines;
pub mod bounds;
pub mod chart;
pub mod data;
pub mod evidence;
pub mod run;
pub mod synth;
pub mod wire;

/// Whether an error comes of a closed output, as by `| head`.
#[must_use]
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<std::io::Error>().map(std::io::Error::kind);
    kind == Some(std::io::ErrorKind::BrokenPipe)
}
