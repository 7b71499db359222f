//! The trace of a run for `--trace`: one row for each pair.

use std::path::Path;

use anyhow::{Context, Result};
use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::LensCorrection;

use super::step::Step;

/// Columns before those of the extrinsics.
#[rustfmt::skip]
const COLUMNS: [&str; 11] = [
    "pair", "state", "verdict", "armed", "doubt", "matches", "fit", "rms_px_in_use", "rms_px_proposed", "sd_rotation",
    "sd_translation",
];

/// Letters of the columns of the proposed `R` and `t`, and of the `R` and `t` in use.
const NAMES: [[char; 2]; 2] = [['r', 't'], ['u', 'v']];

/// Names of the corrections of the right camera: of the estimate, and of the calibration in use.
const CORRECTIONS: [&str; 4] = ["focal", "k1", "used_focal", "used_k1"];

/// Names of the vibration of `R` and `t`, rad RMS.
const VIBRATION: [&str; 2] = ["vibration_rotation", "vibration_translation"];

/// Count of numbers in `R` and `t`.
const NUMBERS: usize = 12;

/// Writes the trace; an older file is replaced. Angles in rad; unknown values are empty. If the run corrected a lens,
/// each row also has the corrections. If it detected vibration, each row also has the vibration.
pub fn write(path: &Path, steps: &[Step]) -> Result<()> {
    let write = || -> Result<()> {
        let mut file = csv::Writer::from_path(path)?;
        let corrected = steps.iter().any(is_corrected);
        let vibrates =
            steps.iter().any(|step| step.estimate.is_some_and(|e| !e.vibration.is_none()));
        let names = CORRECTIONS.map(String::from).into_iter().filter(|_| corrected);
        let shakes = VIBRATION.map(String::from).into_iter().filter(|_| vibrates);
        file.write_record(header().into_iter().chain(names).chain(shakes))?;
        for (pair, step) in steps.iter().enumerate() {
            let numbers = corrections(step).into_iter().filter(|_| corrected);
            let vibration = step.estimate.map(|estimate| estimate.vibration);
            let shakes = [vibration.map(|v| v.rotation), vibration.map(|v| v.baseline)];
            let shakes = shakes.map(said).into_iter().filter(|_| vibrates);
            file.write_record(row(pair, step).into_iter().chain(numbers).chain(shakes))?;
        }
        Ok(file.flush()?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

/// Names of the columns.
fn header() -> Vec<String> {
    let of = |[r, t]: [char; 2]| {
        let rows = (1..=3).flat_map(move |i| (1..=3).map(move |j| format!("{r}{i}{j}")));
        rows.chain((1..=3).map(move |i| format!("{t}{i}")))
    };
    COLUMNS.map(String::from).into_iter().chain(NAMES.into_iter().flat_map(of)).collect()
}

fn row(pair: usize, step: &Step) -> Vec<String> {
    let Step { taken, verdict, estimate, checked, .. } = step;
    let details = checked.and_then(|checked| checked.details);
    let doubt = estimate.and_then(|estimate| estimate.doubt);
    let mut row = vec![
        pair.to_string(),
        said(step.state()),
        verdict.to_string(),
        said(checked.map(|checked| checked.is_armed())),
        said(doubt),
        taken.to_string(),
        said(details.map(|details| details.fit)),
        said(details.map(|details| details.in_use_px)),
        said(details.map(|details| details.proposed_px)),
        said(estimate.map(|estimate| estimate.sd_lens.rotation)),
        said(estimate.map(|estimate| estimate.sd_lens.translation)),
    ];
    row.extend(numbers(estimate.map(|estimate| estimate.extrinsics).as_ref()));
    row.extend(numbers(checked.map(|checked| checked.in_use).as_ref()));
    row
}

/// Row-major `R`, then `t`.
fn numbers(extrinsics: Option<&Extrinsics<f64>>) -> Vec<String> {
    let Some(extrinsics) = extrinsics else { return vec![String::new(); NUMBERS] };
    let t = extrinsics.translation();
    extrinsics.rotation_row_major().iter().chain(t.iter()).map(f64::to_string).collect()
}

/// Corrections of the estimate and of the calibration in use; each is `None` if the step does not have it.
fn both(step: &Step) -> [Option<LensCorrection<f64>>; 2] {
    [step.estimate.map(|estimate| estimate.correction), step.checked.map(|used| used.correction)]
}

fn is_corrected(step: &Step) -> bool {
    both(step).into_iter().flatten().any(|correction| !correction.is_none())
}

fn corrections(step: &Step) -> Vec<String> {
    let numbers = |correction: Option<LensCorrection<f64>>| {
        [said(correction.map(|c| c.focal)), said(correction.map(|c| c.k1))]
    };
    both(step).map(numbers).concat()
}

fn said(value: Option<impl ToString>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}
