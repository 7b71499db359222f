//! The program of developers: `cargo evidence`. Figures of the calibrator, and of others beside it.
//!
//! Where a new one goes:
//! - **A rival**: a file of `rivals` that implements [`Method`](rivals::Method) and starts with what is published and
//!   what is filled in. An entry of `rivals::all`, its settings in `rivals::variant`, its words in
//!   `sections::compared`. The tests of `rivals` then run it.
//! - **A campaign**: an entry of `campaigns::made` (project's figures) or `campaigns::real` (scenes of real rigs): name,
//!   runs, seeds, columns, cases. `cargo evidence tables NAME` makes its table; the words above the table are written
//!   by hand in `tables/NAME.md`, and EVIDENCE.md links it.
//! - **A figure of campaigns**: a line of `campaigns::figures`, with its chance of `campaigns::chance`. Campaigns
//!   name it as a column. `campaign NAME --csv FILE` has all figures.
//! - **A section of the page**: a file of `sections`, called in `sections::all`, from measurements of `findings`:
//!   recordings in `on_recorded`, generated scenes in `sweep`, a knock and a drift in `step_response`.
//! - **A command**: a file of `commands`, an entry of [`Command`], a test in `tests/evidence`.

#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod campaigns;
mod commands;
pub mod effort;
mod findings;
pub mod measurement;
pub mod on_recorded;
pub mod pictures;
pub mod recorded_sets;
pub mod rivals;
mod sections;
pub mod step_response;
pub mod sweep;
pub mod verdict;

use std::path::{Path, PathBuf};

use anyhow::Result;
use indicatif::ProgressBar;

use findings::Findings;
use measurement::{MeasurementCounts, Runner};
use page::report::Page;
use rivals::{Range, Variant, all_variants};
use step_response::Motion;
use sweep::{Sweep, SweepAxis};
use verdict::Outcome;

pub use commands::Command;
pub use findings::Request;

/// Results of an evaluation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Evaluated {
    /// The page.
    pub page: PathBuf,
    /// Numbers of measurements by their outcome.
    pub counts: MeasurementCounts,
    /// Numbers of cells on the recordings in which the robust preset has a smaller error than the best rival, in which
    /// they tie, and in which it has a larger one.
    pub cells: [usize; 3],
}

const TITLE: &str = "Online stereo self-calibration: the evidence";

const LEAD: &str = "Errors of the estimated extrinsics of a stereo rig for this project's two presets and for \
                    other methods, on recorded and generated correspondences. All methods get the same \
                    undistorted rays and start at R = I, t = (-1, 0, 0), with p_r = R p_l + t and |t| = 1. \
                    Errors are in radians: 0.001 rad is 0.057 degrees.";

/// Methods that are too slow to run after every pair.
const BATCH: [&str; 1] = ["bundle"];

/// Evaluates the methods of the request, or all methods if it names none, and writes the page into a folder, which is
/// created if it does not exist; writes nothing elsewhere.
///
/// * `bar`: advances with every measurement.
///
/// # Errors
/// If a method is unknown, a data set cannot be read, or a file of the folder cannot be read or written.
pub fn evaluate(request: &Request, dir: &Path, bar: &ProgressBar) -> Result<Evaluated> {
    let sets = recorded_sets::all(&request.data)?;
    let methods = request.methods()?;
    let runner = Runner::new(bar);
    let variants = all_variants(&methods, request.settings)?;
    let few = all_variants(&methods, Range::Few)?;
    let rows = on_recorded::rows(&runner, &sets, &variants);
    let sweep = |axis| sweep::sweep(&runner, axis, &few, request.effort);
    let sweeps: Vec<Sweep> = SweepAxis::ALL.into_iter().map(sweep).collect();
    let tracking: Vec<&Variant> =
        few.iter().filter(|by| !BATCH.contains(&by.method.name())).collect();
    let following =
        |motion| step_response::step_responses(&runner, motion, &tracking, request.effort.steps);
    let step_responses = following(Motion::Knock);
    let drifts = sections::DRIFTS.map(|rate| following(Motion::Drift(rate))).into();
    let step_responses = tracking.into_iter().zip(step_responses).collect();
    let counts = runner.counts();
    let findings = Findings {
        request,
        sets: &sets,
        methods: &methods,
        variants: &variants,
        rows: &rows,
        few: &few,
        sweeps,
        step_responses,
        drifts,
    };
    let [ours, rivals] = findings.sides();
    let judged = verdict::cells(&rows, &ours, &rivals);
    let count = |outcome| judged.iter().filter(|cell| cell.outcome == outcome).count();
    let cells = [Outcome::Win, Outcome::Tie, Outcome::Loss].map(count);
    let mut page = Page::new(TITLE, LEAD);
    page.sections = sections::all(&findings, &counts);
    let page = page.write(dir)?;
    if let Some(folder) = &request.documents {
        sections::write_documents(&findings, folder)?;
    }
    Ok(Evaluated { page, counts, cells })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use super::*;
    use effort::Effort;

    fn request() -> Request {
        Request {
            data: Vec::new(),
            methods: ["robust", "paper"].map(String::from).to_vec(),
            effort: Effort::QUICK.with_trials(1),
            settings: Range::Few,
            documents: None,
            command: "cargo evidence evaluate".into(),
        }
    }

    /// The page and its numbers, and the documents.
    fn files(threads: usize) -> BTreeMap<PathBuf, String> {
        let dir = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let request = Request { documents: Some(dir.path().join("csv")), ..request() };
        pool.install(|| evaluate(&request, dir.path(), &ProgressBar::hidden()).unwrap());
        let csv = fs::read_dir(dir.path().join("csv")).unwrap().map(|entry| entry.unwrap().path());
        let all = csv.chain([dir.path().join("index.html")]);
        let read = |path: PathBuf| {
            let name = path.strip_prefix(dir.path()).unwrap().to_owned();
            (name, fs::read_to_string(path).unwrap())
        };
        all.map(read).collect()
    }

    #[test]
    fn any_number_of_threads_gives_the_same_page_and_documents() {
        let one = files(1);
        assert_eq!(one, files(3));
        assert_eq!(
            one.keys().filter(|name| name.extension().is_some_and(|e| e == "svg")).count(),
            4
        );
    }

    #[test]
    fn a_method_that_does_not_exist_is_named_before_anything_is_written() {
        let dir = tempfile::tempdir().unwrap();
        let unknown = Request { methods: vec!["wizard".into()], ..request() };
        let out = dir.path().join("out");
        let error = evaluate(&unknown, &out, &ProgressBar::hidden()).unwrap_err().to_string();
        assert!(error.contains("wizard") && error.contains("ling-shen"), "{error}");
        assert!(!out.exists());
    }
}
