//! Comparison of the runs: each mechanism off against the whole estimator, over the same pairs.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};

use host_tests::stats::mean;

use super::AS_IT_IS;
use super::measure::Figures;
use super::tree::Mechanism;

/// Least difference that counts, in its standard errors. With 1,500 figures, chance gives such a difference in one
/// mechanism of ten.
const STANDARD_ERRORS: f64 = 4.0;

/// Least ratio of errors that counts.
const RATIO: f64 = 1.03;

/// Least difference of shares that counts.
const SHARE: f64 = 0.01;

/// Name of a figure, the figure, the least difference that counts, and whether more is worse.
type Part = (&'static str, fn(&Figures) -> f64, f64, bool);

type Runs = BTreeMap<String, BTreeMap<u64, Figures>>;

/// A figure of a row that differs.
struct Difference {
    row: String,
    what: &'static str,
    /// Without the mechanism, and with it.
    values: [f64; 2],
    is_worse: bool,
}

fn read(file: &Path) -> Result<Runs> {
    let text = fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let mut runs = Runs::new();
    for line in text.lines() {
        let mut parts = line.splitn(3, ';');
        let (Some(row), Some(seed), Some(figures)) = (parts.next(), parts.next(), parts.next())
        else {
            continue;
        };
        if let Some(figures) = Figures::of_line(figures) {
            runs.entry(row.to_owned())
                .or_default()
                .insert(seed.parse().with_context(|| file.display().to_string())?, figures);
        }
    }
    Ok(runs)
}

/// Mean and its standard error.
fn mean_and_error(values: &[f64]) -> [f64; 2] {
    let n = f64::from(u32::try_from(values.len()).unwrap_or(u32::MAX));
    let mean = mean(values.iter().copied()).unwrap_or(f64::NAN);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    [mean, (squares / (n - 1.0).max(1.0) / n).sqrt()]
}

fn differences(off: &Runs, on: &Runs) -> Vec<Difference> {
    let mut all = Vec::new();
    for (row, off) in off {
        let Some(on) = on.get(row) else { continue };
        let both: Vec<[Figures; 2]> =
            off.iter().filter_map(|(seed, off)| Some([*off, *on.get(seed)?])).collect();
        if both.len() < 4 {
            continue;
        }
        for (part, what) in ["t", "R"].into_iter().enumerate() {
            let squares: Vec<[f64; 2]> = both
                .iter()
                .map(|pair| pair.map(|figures| figures.error[part].powi(2)))
                .filter(|pair| pair.iter().all(|square| square.is_finite()))
                .collect();
            let sums: [f64; 2] = [0, 1].map(|k| squares.iter().map(|pair| pair[k]).sum());
            let n = f64::from(u32::try_from(squares.len()).unwrap_or(u32::MAX));
            let apart: Vec<f64> =
                squares.iter().map(|[a, b]| n * (a / sums[0] - b / sums[1])).collect();
            let ratio = (sums[0] / sums[1]).sqrt();
            let [_, of_squares] = mean_and_error(&apart);
            let deviations = ratio.ln().abs() / (of_squares / 2.0).max(1e-12);
            if ratio.max(1.0 / ratio) > RATIO && deviations > STANDARD_ERRORS {
                let values = sums.map(|sum| (sum / n).sqrt() * 1e3);
                all.push(Difference { row: row.clone(), what, values, is_worse: ratio > 1.0 });
            }
        }
        let has_step = both.iter().flatten().any(|figures| !figures.found.is_nan());
        let is_found = |figures: &Figures| f64::from(u8::from(!figures.found.is_nan()));
        let parts: [Part; 6] = [
            ("success", |figures| figures.success, SHARE, false),
            ("beyond 5 sd", |figures| figures.bad, SHARE, true),
            ("armed", |figures| figures.armed, SHARE, false),
            ("alarms", |figures| figures.alarms, SHARE, true),
            ("found", is_found, SHARE, false),
            ("found after", |figures| figures.found, 0.5, true),
        ];
        for (what, of, least, more_is_worse) in parts {
            if what == "found" && !has_step {
                continue;
            }
            let values: Vec<[f64; 2]> = both
                .iter()
                .map(|pair| pair.each_ref().map(of))
                .filter(|pair| pair.iter().all(|value| value.is_finite()))
                .collect();
            let apart: Vec<f64> = values.iter().map(|[off, on]| off - on).collect();
            let [difference, error] = mean_and_error(&apart);
            let deviations = difference.abs() / error.max(1e-12);
            if difference.abs() > least && deviations > STANDARD_ERRORS {
                let of = |k: usize| mean(values.iter().map(|pair| pair[k])).unwrap_or(f64::NAN);
                all.push(Difference {
                    row: row.clone(),
                    what,
                    values: [of(0), of(1)],
                    is_worse: (difference > 0.0) == more_is_worse,
                });
            }
        }
    }
    all
}

/// Ratio of the passes without the mechanism to those with it, in the runs that both have.
fn passes(off: &Runs, on: &Runs) -> f64 {
    let [mut without, mut with] = [0.0; 2];
    for (row, runs) in off {
        for (seed, figures) in runs {
            if let Some(other) = on.get(row).and_then(|on| on.get(seed)) {
                without += figures.passes;
                with += other.passes;
            }
        }
    }
    without / with
}

/// Strength of a difference, to name the largest ones.
fn strength(difference: &Difference) -> f64 {
    let [off, on] = difference.values;
    if matches!(difference.what, "t" | "R") { (off / on).ln().abs() } else { (off - on).abs() }
}

fn words(differences: &[&Difference], most: usize) -> String {
    let mut sorted = differences.to_vec();
    sorted.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    let name = |difference: &&Difference| {
        let Difference { row, what, values: [off, on], .. } = difference;
        match *what {
            "t" | "R" => format!("{row} {what} x{:.2}", off / on),
            _ => format!("{row} {what} {on:.2} -> {off:.2}"),
        }
    };
    sorted.iter().take(most).map(name).collect::<Vec<_>>().join("; ")
}

/// Prints the table.
pub(super) fn print(into: &Path, core: &Path, mechanisms: &[&Mechanism], rows: bool) -> Result<()> {
    let mut out = io::stdout();
    let on = read(&into.join(AS_IT_IS))?;
    let runs: usize = on.values().map(BTreeMap::len).sum();
    writeln!(out, "{} rows, {runs} runs of each mechanism\n", on.len())?;
    writeln!(
        out,
        "| mechanism | lines | thresholds | worse without it | better without it | passes |\n|---|---|---|---|---|---|"
    )?;
    for mechanism in mechanisms {
        let Ok(off) = read(&into.join(&mechanism.name)) else {
            writeln!(out, "| {} | not measured | | | | |", mechanism.name)?;
            continue;
        };
        let all = differences(&off, &on);
        let of = |is_worse: bool| -> Vec<&Difference> {
            all.iter().filter(|difference| difference.is_worse == is_worse).collect()
        };
        let [worse, better] = [of(true), of(false)];
        let cell = |differences: &[&Difference], most| {
            if differences.is_empty() {
                "-".to_owned()
            } else {
                format!("{}: {}", differences.len(), words(differences, most))
            }
        };
        writeln!(
            out,
            "| {} | {} | {} | {} | {} | {:.2} |",
            mechanism.name,
            mechanism.lines(core)?,
            mechanism.thresholds.len(),
            cell(&worse, if rows { usize::MAX } else { 3 }),
            cell(&better, if rows { usize::MAX } else { 2 }),
            passes(&off, &on),
        )?;
    }
    Ok(())
}
