//! Evidence: the method of the paper and ours against others, on recorded and generated data, as one page.
//!
//! Measurements are independent and the same on any number of threads; finished
//! ones are cached beside the page, and an interrupted evaluation resumes.

#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

pub mod cache;
mod commands;
pub mod effort;
mod findings;
mod measure;
pub mod measurement;
pub mod offsets;
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

use cache::Cache;
use findings::Findings;
use measurement::{MeasurementCounts, Runner};
use page::report::Page;
use rivals::{Range, Variant, all_variants};
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
    let cache = Cache::open(dir, request.fresh)?;
    let runner = Runner::new(&cache, bar);
    let variants = all_variants(&methods, request.settings)?;
    let few = all_variants(&methods, Range::Few)?;
    let rows = on_recorded::rows(&runner, &sets, &variants)?;
    let sweep = |axis| sweep::sweep(&runner, axis, &few, request.effort);
    let sweeps: Vec<Sweep> = SweepAxis::ALL.into_iter().map(sweep).collect::<Result<_>>()?;
    let tracking: Vec<&Variant> =
        few.iter().filter(|by| !BATCH.contains(&by.method.name())).collect();
    let step_responses = step_response::step_responses(&runner, &tracking, request.effort.steps)?;
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
    };
    let [ours, rivals] = findings.sides();
    let judged = verdict::cells(&rows, &ours, &rivals);
    let count = |outcome| judged.iter().filter(|cell| cell.outcome == outcome).count();
    let cells = [Outcome::Win, Outcome::Tie, Outcome::Loss].map(count);
    let mut page = Page::new(TITLE, LEAD);
    page.sections = sections::all(&findings, &counts);
    let page = page.write(dir)?;
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
            pictures: false,
            fresh: false,
            command: "cargo evidence evaluate".into(),
        }
    }

    fn run(dir: &Path, threads: usize) -> Evaluated {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| evaluate(&request(), dir, &ProgressBar::hidden()).unwrap())
    }

    /// The page and its numbers.
    fn files(dir: &Path) -> BTreeMap<PathBuf, String> {
        let csv = fs::read_dir(dir.join("csv")).unwrap().map(|entry| entry.unwrap().path());
        let all = csv.chain([dir.join("index.html")]);
        let read = |path: PathBuf| {
            let name = path.strip_prefix(dir).unwrap().to_owned();
            (name, fs::read_to_string(path).unwrap())
        };
        all.map(read).collect()
    }

    #[test]
    fn any_number_of_threads_and_an_interruption_give_the_same_page() {
        let [one, three] = [1, 3].map(|threads| {
            let dir = tempfile::tempdir().unwrap();
            let evaluated = run(dir.path(), threads);
            assert_eq!(evaluated.counts.reused, 0);
            dir
        });
        let page = files(one.path());
        assert_eq!(page, files(three.path()));

        let cells = three.path().join("cells.jsonl");
        let text = fs::read_to_string(&cells).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        // Cuts the file within a line, as an interruption does: only the whole lines count.
        let whole = lines.len() / 2;
        let begun = &lines[whole][..lines[whole].len() / 2];
        fs::write(&cells, lines[..whole].join("\n") + "\n" + begun).unwrap();
        let again = run(three.path(), 2);
        assert_eq!(again.counts.reused, whole);
        assert!(whole > 0);
        assert_eq!(page, files(three.path()));
        assert_eq!(run(three.path(), 2).counts.reused, lines.len());
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
