//! `selfcal completions` and `selfcal man`, which the help does not list: files for an installation.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::Cli;

/// Print the completions of a shell.
#[derive(Debug, Args)]
#[command(hide = true)]
pub(crate) struct CompletionsArgs {
    shell: Shell,
}

/// Write the man pages of the program and of each command into a folder.
#[derive(Debug, Args)]
#[command(hide = true)]
pub(crate) struct ManArgs {
    #[arg(value_name = "DIR")]
    dir: PathBuf,
}

/// Runs `selfcal completions`.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "selfcal", &mut script);
    Ok(io::stdout().write_all(&script)?)
}

/// Runs `selfcal man`.
pub(crate) fn man(args: &ManArgs) -> Result<()> {
    let place = args.dir.display();
    fs::create_dir_all(&args.dir)
        .and_then(|()| clap_mangen::generate_to(Cli::command(), &args.dir))
        .with_context(|| format!("cannot write into {place}"))
}
