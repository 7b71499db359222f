//! Options and measurements of an evaluation.

use std::path::PathBuf;

use anyhow::Result;

use super::effort::Effort;
use super::measurement::Measured;
use super::on_recorded::Row;
use super::ordering::OrderCheck;
use super::recorded_sets::RecordedSet;
use super::step_response::StepResponse;
use super::sweep::Sweep;
use crate::baselines::{self, Method};
use crate::chart::palette::{self, Color};

/// Options of an evaluation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Data sets, or folders of data sets, beside those that come with the project.
    pub data: Vec<PathBuf>,
    /// Names of the methods to compare; all if none.
    pub methods: Vec<String>,
    /// How much is measured.
    pub effort: Effort,
    /// Whether disparities and spheres are pictured.
    pub pictures: bool,
    /// Drop cached measurements.
    pub fresh: bool,
    /// Command that reproduces the page.
    pub command: String,
}

/// All that was measured.
pub(super) struct Findings<'a> {
    pub(super) request: &'a Request,
    pub(super) sets: &'a [RecordedSet],
    pub(super) methods: &'a [Box<dyn Method>],
    pub(super) rows: &'a [Row<'a>],
    pub(super) checks: &'a [OrderCheck<'a>],
    pub(super) sweeps: Vec<Sweep>,
    /// By method.
    pub(super) step_responses: Vec<(&'static str, Measured<StepResponse>)>,
}

impl Findings<'_> {
    /// The colour of a method, the same in all charts.
    pub(super) fn color(&self, method: &str) -> Color {
        let place = self.methods.iter().position(|by| by.name() == method);
        palette::series(place.unwrap_or_default())
    }
}

impl Request {
    pub(super) fn methods(&self) -> Result<Vec<Box<dyn Method>>> {
        if self.methods.is_empty() {
            return Ok(baselines::all());
        }
        self.methods.iter().map(|name| baselines::by_name(name)).collect()
    }
}
