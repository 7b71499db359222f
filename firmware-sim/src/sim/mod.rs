//! The simulation on a host: a recorded data set or a generated flight instead of the matcher. The results go to
//! standard output and into a plot.

mod args;
mod flight;
mod labels;
mod pil;
mod polling;
mod recorded;
mod replay;
mod report;

use std::io::{self, Write};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;
use firmware_sim::App;
use page::run::plot;
use stereo_selfcal::Scalar;
use test_support::wire::Wire;

use args::{Cli, Command, ReplayArgs};
use polling::driver;

/// Runs the program with the arguments of the process.
pub(crate) fn main() -> ExitCode {
    ::sim::exit(run(&Cli::parse(), &mut io::stdout()))
}

/// Runs the command of the command line.
///
/// # Errors
/// Errors of the command.
fn run(cli: &Cli, out: &mut impl Write) -> Result<ExitCode> {
    match &cli.command {
        Some(Command::Flight(args)) => flight::run(args, out)?,
        Some(Command::Pil(args)) => pil::run(args, out)?,
        None => replay(&cli.replay, out)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Replays the data set and prints the results.
///
/// # Errors
/// If the data set cannot be read, a file cannot be written, or no pair could be fused.
fn replay(args: &ReplayArgs, out: &mut impl Write) -> Result<()> {
    let set = args.dataset()?;
    let mut calibrator = Box::new(firmware_sim::start(set.cameras()?));
    let wire = Wire::default();
    let mut app = App::new(driver(&wire), &mut calibrator);

    report::heading(out, &set)?;
    let run = replay::replay(&set, &wire, &mut app, out)?;
    report::evaluation(out, &set, &run)?;

    let plot = args.plot(&set);
    plot::write_svg(&plot, &set, &run.log)?;
    writeln!(out, "plot               {}", plot.display())?;

    let baseline_m = set.meta.baseline_m.map(f32::lit);
    let weakest = app.calibrator().proposal().map(|found| found.weakest());
    report::verdict(out, app.calibrator().verdict(), weakest)?;
    match (app.apply(), app.calibrator().proposal()) {
        (Ok(applied), _) => {
            report::applied(out, &applied.extrinsics, app.calibrator().in_use().generation)?;
            let details = app.calibrator().details();
            details.map_or(Ok(()), |details| report::details(out, &details, baseline_m))
        }
        (Err(why), Some(proposal)) => report::not_applied(out, &proposal.extrinsics, why),
        (Err(why), None) => Err(why)
            .with_context(|| format!("no estimate to apply after {} pairs", set.pairs.len())),
    }
}
