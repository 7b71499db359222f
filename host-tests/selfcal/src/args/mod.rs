//! Arguments that several commands have, and their parsers.

mod choice;
pub(crate) mod faults;
#[cfg(feature = "images")]
pub(crate) mod images;
mod input;
pub(crate) mod numbers;
pub(crate) mod recording;
pub(crate) mod rig;
#[cfg(feature = "images")]
mod rig_files;
pub(crate) mod run;
pub(crate) mod setup;

pub(crate) use choice::choice;
