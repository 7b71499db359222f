//! Runs over images, for the commands `images` and `check`.

mod args;
mod live;
pub(crate) mod page;
mod run;

pub(crate) use args::SourceArgs;
pub(crate) use run::{Ran, name};
