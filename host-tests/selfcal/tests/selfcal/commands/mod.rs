//! The commands over recorded matches and rig files.

mod compensated;
mod import_export;
mod output;
mod page;
mod piped;
mod reference;
mod stream;
mod synth;
