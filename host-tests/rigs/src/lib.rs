//! Recorded data sets of stereo rigs, and rigs in the files of other tools.

pub mod data;
pub mod formats;
mod read;

pub use read::read_rig;
