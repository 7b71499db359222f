//! Everything that proves the core on a host: recorded and generated data, independent references,
//! replay, evaluation.

pub mod bench;
pub mod campaign;
pub mod conventions;
pub mod dataset;
pub mod depth;
pub mod estimate;
pub mod evaluate;
pub mod evaluation;
pub mod grid;
pub mod oracle;
pub mod pictures;
pub mod plot;
pub mod progress;
pub mod recording;
pub mod rectified;
pub mod reference;
pub mod replay;
pub mod report;
pub mod rivals;
pub mod scenario;
pub mod synth;
pub mod view;
pub mod wire;

/// Whether an error comes of a closed output, as by `| head`.
#[must_use]
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<std::io::Error>().map(std::io::Error::kind);
    kind == Some(std::io::ErrorKind::BrokenPipe)
}
