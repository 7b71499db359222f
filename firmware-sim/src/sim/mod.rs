//! The simulation: a recorded data set or a generated flight in the matcher's place, what the firmware
//! makes of it on standard output, and a plot.

mod args;
mod drive;
mod emulator;
mod flight;
mod pil;
mod play;
mod report;
mod words;

use std::io::{self, Write};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;
use firmware_sim::App;
use host_tests::is_broken_pipe;
use host_tests::run::plot;
use host_tests::wire::{Sender, SimMatcher};

use args::{Cli, Command, ReplayArgs};

/// The program.
pub(crate) fn main() -> ExitCode {
    match run(&Cli::parse(), &mut io::stdout()) {
        Ok(code) => code,
        // Whoever read the output has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Does what the command line asks for.
///
/// # Errors
/// As the parts say.
fn run(cli: &Cli, out: &mut impl Write) -> Result<ExitCode> {
    match &cli.command {
        Some(Command::Flight(args)) => flight::run(args, out)?,
        Some(Command::Pil(args)) => pil::run(args, out)?,
        #[cfg(feature = "logs")]
        Some(Command::Emulate(args)) => {
            return emulator::run(&args.image, args.machine, args.timeout);
        }
        None => replay(&cli.replay, out)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Plays the data set and prints what comes of it.
///
/// # Errors
/// If the data set cannot be read, a file cannot be written, or no pair could be fused.
fn replay(args: &ReplayArgs, out: &mut impl Write) -> Result<()> {
    let set = args.dataset()?;
    let mut calibrator = Box::new(firmware_sim::start(set.cameras()?));
    let matcher = SimMatcher::new(Sender::of(&set)?);
    let mut app = App::new(matcher.driver(), &mut calibrator);

    report::heading(out, &set)?;
    let run = play::play(&set, &matcher, &mut app, out)?;
    report::summary(out, &set, &run)?;

    let plot = args.plot(&set);
    plot::write_svg(&plot, &set, &run.log)?;
    writeln!(out, "plot               {}", plot.display())?;

    match (app.apply(), app.calibrator().proposal()) {
        (Ok(applied), _) => report::applied(out, &applied, app.calibrator().generation()),
        (Err(why), Some(proposal)) => report::not_applied(out, &proposal.extrinsics, why),
        (Err(why), None) => {
            Err(why).with_context(|| format!("nothing to apply after {} pairs", set.pairs.len()))
        }
    }
}
