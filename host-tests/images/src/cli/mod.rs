//! The subcommands: arguments in, text or JSON out.

mod check;
mod images;
mod matcher;
mod source;

pub(crate) use check::{CheckArgs, check};
pub(crate) use images::{ImagesArgs, images};
pub(crate) use matcher::{MatcherArgs, matcher};
