//! The commands: arguments in, text, JSON or files out.

mod campaign;
mod evaluate;
mod link;
mod matcher;
mod picture;
mod tables;

use anyhow::Result;
use clap::Subcommand;

/// Commands that measure the calibrator.
#[derive(Debug, Subcommand)]
#[allow(missing_docs, reason = "the arguments define the help text")]
#[allow(private_interfaces, reason = "the program only parses and runs a command")]
pub enum Command {
    Campaign(campaign::CampaignArgs),
    Tables(tables::TablesArgs),
    Evaluate(evaluate::EvaluateArgs),
    Link(link::LinkArgs),
    Matcher(matcher::MatcherArgs),
    Picture(picture::PictureArgs),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Names the input that is wrong, or the file that cannot be written.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Campaign(args) => campaign::campaign(args),
            Self::Tables(args) => tables::tables(args),
            Self::Evaluate(args) => evaluate::evaluate_all(args),
            Self::Link(args) => link::link(args),
            Self::Matcher(args) => matcher::matcher(args),
            Self::Picture(args) => picture::picture(args),
        }
    }
}
