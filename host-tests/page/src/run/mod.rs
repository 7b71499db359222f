//! The page of one replayed recording: pair by pair, and as a whole.

mod coverage;
mod depth;
mod outcome;
mod pair_by_pair;
pub mod plot;
mod rig;
mod sphere;
mod states;
pub mod timeline;

use std::path::{Path, PathBuf};

use anyhow::Result;

pub use sphere::{Estimates, Reach, sphere_figure};

use crate::report::{Page, Section};
use rigs::data::Dataset;
use rigs::formats::Document;
use sim::run::{DepthErrors, Reference, RunLog, Step, Summary};

/// A replayed recording.
#[derive(Debug, Clone, Copy)]
pub struct Replayed<'a> {
    /// The data set.
    pub set: &'a Dataset,
    /// Log of the replay.
    pub log: &'a RunLog,
    /// Measured error of depth, if true depths are known.
    pub depth: Option<DepthErrors>,
    /// The command that replays it.
    pub command: &'a str,
}

impl Replayed<'_> {
    /// The page.
    ///
    /// # Errors
    /// If the data set's cameras are not valid.
    pub fn page(&self) -> Result<Page> {
        let summary = self.log.summary(self.set)?;
        let mut page = Page::new(format!("Calibration of {}", self.set.name), lead(&summary));
        page.sections.push(outcome::section(self, &summary));
        page.sections.extend(depth::section(self, &summary));
        page.sections.push(pair_by_pair::section(self, summary.reference));
        page.sections.push(coverage::section(self));
        page.sections.push(self.spheres(summary.reference));
        page.sections.push(rig::section(self));
        Ok(page)
    }

    /// Writes [`Self::page`] as [`Self::write_page`] does.
    ///
    /// # Errors
    /// As [`Replayed::page`], or if a file cannot be written: names it.
    pub fn write(&self, dir: &Path) -> Result<PathBuf> {
        self.write_page(&self.page()?, dir)
    }

    /// Writes `index.html`, `csv/*.csv` and, if there is an estimate, its rig as files of other tools into `rig/`;
    /// earlier files of these names are replaced. Returns the path of the page.
    ///
    /// # Errors
    /// If a file cannot be written: names it.
    pub fn write_page(&self, page: &Page, dir: &Path) -> Result<PathBuf> {
        for (format, documents) in rig::files(self) {
            let folder = dir.join("rig").join(format.to_string());
            // The page says why a format is missing.
            for Document { name, text } in documents.unwrap_or_default() {
                crate::write(&folder.join(name), &text)?;
            }
        }
        page.write(dir)
    }

    fn spheres(&self, known: Reference) -> Section {
        let mut section = Section::new("Estimates on their spheres");
        let Some(&reference) = self.log.truth() else {
            section.text("Not drawn: the pictures need a reference, and meta.json has no R and t.");
            return section;
        };
        if known == Reference::Start {
            section.text("The reference is the start of the run.");
        }
        let steps = self.log.steps().iter();
        let estimates = Estimates {
            pairs: steps.filter_map(Step::pair_extrinsics).collect(),
            fused: self.log.fused().map(|fused| fused.extrinsics),
            reference,
        };
        section.figure(sphere_figure("spheres", &estimates, estimates.reach(), self.command));
        section
    }
}

fn lead(summary: &Summary) -> String {
    let Summary { accepted, pairs, state, .. } = summary;
    let rows = summary.rms_px_before.zip(summary.rms_px_after).map(|(before, after)| {
        format!(" Matches that fit lie {after:.2} px from their rows (RMS), {before:.2} px before.")
    });
    let is_start = summary.reference == Reference::Start;
    let moved = summary.e_theta.zip(summary.sd_rotation).filter(|_| is_start).map(|(theta, sd)| {
        let [theta, sd] = [theta, sd].map(f64::to_degrees);
        format!(" The cameras are turned against each other by {theta:.3} degrees from the start, reported sd {sd:.3}.")
    });
    let [rows, moved] = [rows, moved].map(Option::unwrap_or_default);
    format!("{accepted} of {pairs} pairs fused: {state}.{rows}{moved}")
}
