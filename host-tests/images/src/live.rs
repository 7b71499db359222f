//! The live view of a run: on a terminal, a few lines that change in place; elsewhere, a line for each pair.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use host_tests::run::Step;

use crate::session::Listener;

/// Least time between two drawings.
const PERIOD: Duration = Duration::from_millis(100);

/// Number of lines of the view.
const LINES: usize = 4;

/// Width of the bars, characters.
const WIDTH: usize = 30;

/// Row offset of a full bar, px.
const FULL_PX: f64 = 10.0;

/// Largest number of skipped pairs that are named; all are counted.
const NAMED: usize = 10;

/// Shows a run on standard error.
#[derive(Debug)]
pub struct Live {
    terminal: bool,
    /// Whether only skipped pairs are printed.
    quiet: bool,
    count: Option<usize>,
    started: Instant,
    drawn: Option<Instant>,
    skipped: usize,
}

impl Live {
    /// A view of a run.
    ///
    /// * `count`: number of pairs, if known.
    /// * `quiet`: prints only skipped pairs.
    #[must_use]
    pub fn new(count: Option<usize>, quiet: bool) -> Self {
        let terminal = io::stderr().is_terminal();
        Self { terminal, quiet, count, started: Instant::now(), drawn: None, skipped: 0 }
    }

    /// Prints the number of skipped pairs that were not named, and removes the view from the terminal.
    pub fn finish(&mut self) {
        if self.skipped > NAMED {
            self.print(&format!("and {} more skipped", self.skipped - NAMED));
        }
        self.clear();
    }

    fn clear(&mut self) {
        if self.drawn.take().is_some() {
            // Moves up and clears the lines below. A closed terminal does not end the run.
            let _ = write!(io::stderr(), "\x1b[{LINES}F\x1b[0J");
        }
    }

    fn print(&mut self, line: &str) {
        self.clear();
        let _ = writeln!(io::stderr(), "{line}");
    }
}

impl Listener for Live {
    fn pair(&mut self, number: usize, step: &Step) {
        if self.quiet {
            return;
        }
        if !self.terminal {
            let _ = writeln!(io::stderr(), "{number:>5} {step}");
            return;
        }
        let due = self.drawn.is_none_or(|drawn| drawn.elapsed() >= PERIOD);
        if due || self.count == Some(number + 1) {
            self.clear();
            let view = view(number, self.count, self.started.elapsed(), step);
            let _ = writeln!(io::stderr(), "{view}");
            self.drawn = Some(Instant::now());
        }
    }

    fn skipped(&mut self, why: &str) {
        self.skipped += 1;
        if self.skipped <= NAMED {
            self.print(&format!("skipped: {why}"));
        }
    }
}

/// Four lines: pair, rows in use, rows of the estimate, state and deviations.
fn view(number: usize, count: Option<usize>, elapsed: Duration, step: &Step) -> String {
    let done = number + 1;
    let of = count.map_or(String::new(), |count| {
        let left = elapsed.as_secs_f64() / done as f64 * count.saturating_sub(done) as f64;
        format!("/{count}, {left:.0} s left")
    });
    let rows = |name: &str, px: Option<f64>| match px {
        Some(px) => {
            let full = ((px / FULL_PX).min(1.0) * WIDTH as f64).round() as usize;
            let bar = format!("{}{}", "#".repeat(full), "-".repeat(WIDTH - full));
            format!("{name} {bar} {px:>7.2} px")
        }
        None => format!("{name} {} -", "-".repeat(WIDTH)),
    };
    let health = step.checked.and_then(|checked| checked.health);
    let [in_use, proposed] =
        [health.map(|health| health.in_use_px), health.map(|health| health.proposed_px)];
    let state = match (&step.estimate, &step.running) {
        (Some(estimate), Some(off)) => {
            let [sd_r, sd_t] = [estimate.sd.rotation, estimate.sd.translation].map(f64::to_degrees);
            let [r, t] = [off.rotation, off.translation].map(f64::to_degrees);
            format!(
                "{estimate}: R off by {r:.3} deg (sd {sd_r:.3}), t by {t:.3} deg (sd {sd_t:.3})"
            )
        }
        _ => "no estimate yet".into(),
    };
    format!(
        "pair {done}{of}: {} matches, {}\n{}\n{}\n{state}",
        step.taken,
        step.verdict,
        rows("rows in use  ", in_use),
        rows("rows proposed", proposed),
    )
}
