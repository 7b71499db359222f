//! Progress of a run over images: on a terminal a bar with the latest pair, elsewhere a line for each pair, if wanted.

use std::io::{self, Write};

use images::session::Listener;
use indicatif::{ProgressBar, ProgressStyle};
use sim::run::Step;

/// Largest number of skipped pairs that are named; all are counted.
const NAMED: usize = 10;

/// Shows a run on standard error.
pub(crate) struct Live {
    bar: ProgressBar,
    /// Whether no line is printed for a pair.
    quiet: bool,
    skipped: usize,
}

impl Live {
    /// A view of a run.
    ///
    /// * `count`: number of pairs, if known.
    /// * `quiet`: prints no line for a pair; a terminal shows the bar.
    pub(crate) fn new(count: Option<usize>, quiet: bool) -> Self {
        let bar = match count {
            Some(count) => styled(
                ProgressBar::new(count as u64),
                "{bar:10} {pos}/{len}, {eta} left: {wide_msg}",
            ),
            None => styled(ProgressBar::no_length(), "{pos} pairs, {elapsed}: {wide_msg}"),
        };
        Self { bar, quiet, skipped: 0 }
    }

    /// Prints the number of skipped pairs that were not named, and removes the bar from the terminal.
    pub(crate) fn finish(&self) {
        if self.skipped > NAMED {
            self.print(&format!("and {} more skipped", self.skipped - NAMED));
        }
        self.bar.finish_and_clear();
    }

    fn print(&self, line: &str) {
        // A closed standard error does not end the run.
        self.bar.suspend(|| drop(writeln!(io::stderr(), "{line}")));
    }
}

impl Listener for Live {
    fn pair(&mut self, number: usize, step: &Step) {
        self.bar.inc(1);
        if !self.bar.is_hidden() {
            self.bar.set_message(view(step));
        } else if !self.quiet {
            self.print(&format!("{number:>5} {step}"));
        }
    }

    fn skipped(&mut self, why: &str) {
        self.skipped += 1;
        if self.skipped <= NAMED {
            self.print(&format!("skipped: {why}"));
        }
    }
}

fn styled(bar: ProgressBar, template: &str) -> ProgressBar {
    let style =
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.with_style(style)
}

/// The verdict, and the state.
fn view(step: &Step) -> String {
    let Some(estimate) = &step.estimate else { return "no estimate yet".into() };
    let judged = step.checked.map(|checked| format!("{}, ", checked.judged));
    format!("{}{estimate}", judged.unwrap_or_default())
}
