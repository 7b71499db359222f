//! The commands: arguments in, text, JSON or files out. One file is one command.

#[cfg(feature = "images")]
mod check;
mod event_file;
mod export;
mod generate;
#[cfg(feature = "images")]
mod images;
mod import;
mod record;
mod replay;
mod synth;

use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

use anyhow::{Error, Result};
use clap::Subcommand;
use serde_json::Value;

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

    /// Whether the answer is one JSON object, and an error comes without it.
    fn is_json(&self) -> bool {
        match self {
            #[cfg(feature = "images")]
            Self::Images(args) => args.json,
            #[cfg(feature = "images")]
            Self::Check(args) => args.json,
            _ => false,
        }
    }

    /// Says an error as JSON too, where the answer is JSON.
    pub(crate) fn say_error(&self, error: &Error) {
        if self.is_json() {
            // A closed output has no reader.
            let _ = writeln!(io::stdout(), "{:#}", json_of(error));
        }
    }
}

/// An error as JSON.
fn json_of(error: &Error) -> Value {
    serde_json::json!({ "error": format!("{error:#}") })
}

/// The command line for a page, as a shell reads it.
pub(crate) fn called() -> String {
    in_shell(std::env::args_os().skip(1))
}

fn in_shell(arguments: impl IntoIterator<Item = OsString>) -> String {
    let quoted = |argument: OsString| {
        let text = argument.to_string_lossy();
        // A character 0 cannot be in an argument.
        shlex::try_quote(&text).map_or_else(|_| text.to_string(), |quoted| quoted.to_string())
    };
    let words = arguments.into_iter().map(quoted);
    std::iter::once("selfcal".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_of_a_page_is_read_by_a_shell_as_it_was_given() {
        let given = ["images", "cam 1/left*.png", "it's", "$HOME", "", "--pairs=4"];
        let line = in_shell(given.map(OsString::from));
        let read = shlex::split(&line).unwrap();
        assert_eq!(read[0], "selfcal");
        assert_eq!(read[1..], given);
    }

    #[cfg(unix)]
    #[test]
    fn an_argument_that_is_not_text_is_shown_with_a_mark() {
        use std::os::unix::ffi::OsStringExt;
        let line = in_shell([OsString::from_vec(b"left\xff.png".to_vec())]);
        assert!(line.contains("left\u{fffd}.png"), "{line}");
    }
}
