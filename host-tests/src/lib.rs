//! Everything that proves the core on a host: recorded and generated data, independent references,
//! replay, evaluation.

pub mod abuse;
pub mod dataset;
pub mod evaluation;
pub mod oracle;
pub mod plot;
pub mod progress;
pub mod reference;
pub mod replay;
pub mod synth;
pub mod view;
