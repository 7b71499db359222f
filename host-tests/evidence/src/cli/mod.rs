//! The commands `campaign`, `tables`, `evaluate`, `bench` and `picture`: arguments in, text or JSON out.

mod bench;
mod campaign;
mod evaluate;
mod picture;

use anyhow::Result;
use clap::Subcommand;

use bench::BenchArgs;
use campaign::{CampaignArgs, TablesArgs};

pub use campaign::Ablation;
use evaluate::EvaluateArgs;
use picture::PictureArgs;

/// Commands that measure the calibrator.
#[derive(Debug, Subcommand)]
pub enum Command {
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Campaign(CampaignArgs),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Evaluate(EvaluateArgs),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Bench(BenchArgs),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Picture(PictureArgs),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Tables(TablesArgs),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Names the input that is wrong, or the file that cannot be written.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Campaign(args) => campaign::campaign(args),
            Self::Evaluate(args) => evaluate::evaluate_all(args),
            Self::Bench(args) => bench::bench(args),
            Self::Picture(args) => picture::picture(args),
            Self::Tables(args) => campaign::tables(args),
        }
    }
}
