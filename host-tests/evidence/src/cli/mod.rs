//! The commands `campaign`, `evaluate` and `bench`: arguments in, text or JSON out.

mod bench;
mod campaign;
mod evaluate;

use anyhow::Result;
use clap::Subcommand;

use bench::BenchArgs;
use campaign::CampaignArgs;

pub use campaign::Ablation;
use evaluate::EvaluateArgs;

/// Commands that measure the calibrator.
#[derive(Debug, Subcommand)]
pub enum Command {
    #[allow(missing_docs, reason = "the help text is that of the arguments")]
    Campaign(CampaignArgs),
    #[allow(missing_docs, reason = "the help text is that of the arguments")]
    Evaluate(EvaluateArgs),
    #[allow(missing_docs, reason = "the help text is that of the arguments")]
    Bench(BenchArgs),
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
        }
    }
}
