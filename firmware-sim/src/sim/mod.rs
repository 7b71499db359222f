//! The simulation: a recorded data set in the matcher's place, what the firmware makes of it on
//! standard output, and a plot.

mod args;
mod matcher;
mod play;
mod report;

use std::io::Write;

use anyhow::{Context, Result};
use firmware_sim::App;
use host_tests::plot;

pub(crate) use args::Args;
use matcher::SimMatcher;

/// Plays the data set and prints what comes of it.
///
/// # Errors
/// If the data set cannot be read, a file cannot be written, or no pair could be fused.
pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let set = args.dataset()?;
    let mut calibrator = Box::new(firmware_sim::start(set.cameras()?));
    let matcher = SimMatcher::default();
    let mut app = App::new(matcher.driver(), &mut calibrator);

    report::heading(out, &set)?;
    let run = play::play(&set, &matcher, &mut app, out)?;
    report::evaluation(out, &set, &run)?;

    let plot = args.plot(&set);
    plot::write_svg(&plot, &set, &run.evaluation)?;
    writeln!(out, "plot               {}", plot.display())?;

    let applied =
        app.apply().with_context(|| format!("nothing to apply after {} pairs", set.pairs.len()))?;
    report::applied(out, &applied, app.calibrator().generation())
}
