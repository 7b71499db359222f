//! Processor in the loop: a host plays the matcher over a line, and is told what became of each pair,
//! bit for bit.
//!
//! | who | sends | |
//! |---|---|---|
//! | host | [`Opening`] | cameras, and how many pairs will come |
//! | controller | [`Greeting`] | whether it takes them |
//! | host | a frame, see [`stereo_selfcal::link`] | through the same decoder as the matcher's |
//! | controller | [`PairAnswer`] | after each frame |
//! | controller | [`EndAnswer`] | after the last: what is now in use |
//!
//! All little endian, without padding, for a link without errors.

mod answer;
mod opening;
mod serve;

pub use answer::{EndAnswer, Greeting, PairAnswer, Part};
pub use opening::{Opening, OpeningError};
pub use serve::{ServeError, serve};
