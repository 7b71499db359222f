//! The commands: arguments in, text, JSON or files out. One file is one command.

#[cfg(feature = "images")]
mod check;
mod export;
mod generate;
#[cfg(feature = "images")]
mod images;
mod import;
mod record;
mod replay;
mod synth;

use std::process::ExitCode;

use anyhow::Result;
use clap::Subcommand;

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    #[cfg(feature = "images")]
    Images(Box<images::ImagesArgs>),
    #[cfg(feature = "images")]
    Check(Box<check::CheckArgs>),
    Replay(replay::ReplayArgs),
    Import(import::ImportArgs),
    Export(export::ExportArgs),
    Record(record::RecordArgs),
    Synth(synth::SynthArgs),
    Completions(generate::CompletionsArgs),
    Man(generate::ManArgs),
}

impl Command {
    /// Runs the command; returns its exit status.
    ///
    /// # Errors
    /// Names the input that is wrong, or the file that cannot be written.
    pub(crate) fn run(&self) -> Result<ExitCode> {
        match self {
            #[cfg(feature = "images")]
            Self::Images(args) => return images::images(args),
            #[cfg(feature = "images")]
            Self::Check(args) => return check::check(args),
            Self::Replay(args) => return replay::replay(args),
            Self::Import(args) => import::import(args)?,
            Self::Export(args) => export::export(args)?,
            Self::Record(args) => record::record(args)?,
            Self::Synth(args) => synth::synth(args)?,
            Self::Completions(args) => generate::completions(args)?,
            Self::Man(args) => generate::man(args)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// The command line, for a page.
pub(crate) fn called() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("selfcal {}", arguments.join(" "))
}
