//! The commands `images`, `check` and `matcher`: arguments in, text or JSON out.

mod check;
mod images;
mod matcher;
mod rig_files;
mod source;

use std::process::ExitCode;

use anyhow::Result;
use clap::Subcommand;

use check::CheckArgs;
use images::ImagesArgs;
use matcher::MatcherArgs;

/// Commands that read images.
#[derive(Debug, Subcommand)]
pub enum Command {
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Images(Box<ImagesArgs>),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Check(Box<CheckArgs>),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Matcher(MatcherArgs),
}

impl Command {
    /// Runs the command; the exit status of `check` is its verdict.
    ///
    /// # Errors
    /// Names the input that is wrong, or the file that cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        match self {
            Self::Images(args) => images::images(args).map(|()| ExitCode::SUCCESS),
            Self::Check(args) => check::check(args),
            Self::Matcher(args) => matcher::matcher(args).map(|()| ExitCode::SUCCESS),
        }
    }
}
