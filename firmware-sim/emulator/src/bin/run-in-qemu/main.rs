//! Cargo's runner for controller images.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod log;

use std::path::PathBuf;
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::Parser;
use emulator::{Board, Emulator, seconds};

/// Run a controller image in QEMU and print its log.
#[derive(Debug, Parser)]
#[command(version, after_help = "Exit status: that of the firmware, or 1 after the timeout.")]
struct Args {
    /// Image to run.
    image: PathBuf,

    /// Board that QEMU emulates.
    #[arg(long, default_value = "m4f", value_parser = Board::parser())]
    board: &'static Board,

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
    let table = log::table(&args.image).with_context(|| args.image.display().to_string())?;
    let mut emulator = Emulator::start(args.board, &args.image, &[])?;
    let stdout = emulator.stdout()?;
    let status = thread::scope(|scope| {
        scope.spawn(|| log::print(&table, stdout));
        let status = emulator.wait(args.timeout);
        // Ends QEMU after a timeout, and with it the log.
        drop(emulator);
        status
    })?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}
