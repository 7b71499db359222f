//! Cargo's runner for controller images.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use clap::Parser;
use emulator::{Emulator, Machine, seconds};

/// Run a controller image in QEMU and print its log.
#[derive(Debug, Parser)]
#[command(version, after_help = "Exit status: that of the firmware, or 1 after the timeout.")]
struct Args {
    /// Image to run.
    image: PathBuf,

    /// Board that QEMU emulates.
    #[arg(long, value_enum, default_value_t)]
    machine: Machine,

    /// Timeout of the run, s.
    #[arg(long, value_name = "S", default_value = "300", value_parser = seconds)]
    timeout: Duration,
}

fn main() -> ExitCode {
    run(&Args::parse()).unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}

fn run(args: &Args) -> Result<ExitCode> {
    let status = Emulator::start(args.machine, &args.image, "null")?.wait(args.timeout)?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}
