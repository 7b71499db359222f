//! Options and measurements of an evaluation.

use std::path::PathBuf;

use anyhow::Result;

use super::effort::Effort;
use super::on_recorded::Row;
use super::recorded_sets::RecordedSet;
use super::step_response::StepResponse;
use super::sweep::Sweep;
use super::verdict::{self, OURS};
use crate::rivals::{self, Method, Range, Variant};

/// Options of an evaluation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Data sets, or folders of data sets, in addition to the shipped ones.
    pub data: Vec<PathBuf>,
    /// Names of the methods to compare; all if empty.
    pub methods: Vec<String>,
    /// Number of trials.
    pub effort: Effort,
    /// Settings of each method on the recordings: all, or a few.
    pub settings: Range,
    /// Folder of the tables and curves of EVIDENCE.md, if they are to be written.
    pub documents: Option<PathBuf>,
    /// Command that reproduces the page.
    pub command: String,
}

/// All measurements.
pub(super) struct Findings<'a> {
    pub(super) request: &'a Request,
    pub(super) sets: &'a [RecordedSet],
    pub(super) methods: &'a [Box<dyn Method>],
    /// Methods and settings on the recordings: the columns of `rows`.
    pub(super) variants: &'a [Variant],
    pub(super) rows: &'a [Row<'a>],
    /// Methods and settings on the generated scenes.
    pub(super) few: &'a [Variant],
    pub(super) sweeps: Vec<Sweep>,
    pub(super) step_responses: Vec<(&'a Variant, StepResponse)>,
    /// The same over rigs that drift, at each of the rates of the section.
    pub(super) drifts: Vec<Vec<StepResponse>>,
}

impl Findings<'_> {
    /// Indices of our method with its settings among the variants of the recordings, and indices of its rivals.
    pub(super) fn sides(&self) -> [Vec<usize>; 2] {
        [verdict::of_method(self.variants, OURS), verdict::rivals(self.variants)]
    }
}

impl Request {
    pub(super) fn methods(&self) -> Result<Vec<Box<dyn Method>>> {
        if self.methods.is_empty() {
            return Ok(rivals::all());
        }
        self.methods.iter().map(|name| rivals::by_name(name)).collect()
    }
}
