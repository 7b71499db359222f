//! The commands that read no images: arguments in, text or JSON out.

mod export;
mod faults;
mod import;
mod input;
mod link;
mod parse;
mod record;
mod replay;
mod rig_args;
mod run;
pub mod setup;
mod source;
mod synth;

use anyhow::Result;
use clap::Subcommand;

use export::ExportArgs;
use import::ImportArgs;
use link::LinkArgs;
use record::RecordArgs;
use replay::ReplayArgs;

pub use rig_args::{RigArgs, read_rig};
use synth::SynthArgs;

/// Commands that read no images.
#[derive(Debug, Subcommand)]
pub enum Command {
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Replay(ReplayArgs),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Record(RecordArgs),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Export(ExportArgs),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Import(ImportArgs),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Synth(Box<SynthArgs>),
    #[allow(missing_docs, reason = "the arguments define the help text")]
    Link(LinkArgs),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Names the input that is wrong, or the file that cannot be written.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Replay(args) => replay::replay(args),
            Self::Record(args) => record::record(args),
            Self::Export(args) => export::export(args),
            Self::Import(args) => import::import(args),
            Self::Synth(args) => synth::synth(args),
            Self::Link(args) => link::link(args),
        }
    }
}
