//! Recorded data sets of stereo rigs, and rigs in the files of other tools.
//!
//! [`data`] has the types and files of a data set: its rig (`meta.json`), its matches, and what a recording may have
//! beside them. [`formats`] reads rigs of other tools and writes three of them; [`read_rig`] reads either.
//!
//! A new rig format: a module in `formats` with a function from `Files` to `Meta` (`vins` is a short example), a row in
//! the table of `formats/table.rs`, and a sample in `tests/samples` with a row in `tests/rigs/samples.rs`.
#![allow(
    clippy::missing_errors_doc,
    clippy::must_use_candidate,
    clippy::return_self_not_must_use,
    reason = "only this workspace uses the package"
)]

mod bounded;
pub mod data;
mod doubts;
pub mod formats;
mod read;

pub use doubts::doubts;
pub use read::read_rig;
