//! The printed report, apart from the lines of the pairs.

use std::io::Write;

use anyhow::Result;
use rigs::data::Dataset;
use sim::run::Summary;
use stereo_selfcal::outcome::{DEPTHS_M, Details, Direction};
use stereo_selfcal::{ApplyError, Extrinsics, Verdict};

use super::labels;
use super::replay::Run;
use firmware_sim::CAPACITY;

/// Prints the data set and the configuration.
pub(super) fn heading(out: &mut impl Write, set: &Dataset) -> Result<()> {
    let matches: usize = set.pairs.iter().map(Vec::len).sum();
    let pairs = set.pairs.len();
    writeln!(out, "Firmware simulation: recorded matches over SPI into the calibrator")?;
    writeln!(out, "data set   {}: {pairs} pairs, {matches} matches", set.name)?;
    writeln!(out, "source     {}", set.meta.source)?;
    writeln!(out, "preset     robust: redescending loss, fusion by moments, change detection")?;
    writeln!(out, "scalar     f32, up to {CAPACITY} matches per pair, 1/256 px on the wire")?;
    writeln!(out, "errors     in degrees, against R, t of the data set\n")?;
    Ok(())
}

/// Prints the final errors and the standard deviations.
pub(super) fn evaluation(out: &mut impl Write, set: &Dataset, run: &Run) -> Result<()> {
    let summary = run.log.summary(set)?;
    writeln!(out, "\n{summary}")?;
    if let Some([t, r]) = normalised_errors(&summary) {
        writeln!(out, "error / sd         {t:.1} in t, {r:.1} in R")?;
    }
    if let Some((t, r)) = set.meta.sigma_t_deg.zip(set.meta.sigma_r_deg) {
        writeln!(out, "sd of reference    {t:.4} deg in t, {r:.4} deg in R")?;
    }
    let left_out: usize = run.log.steps().iter().map(|s| s.offered - s.taken).sum();
    if left_out > 0 {
        let why = format!("over {CAPACITY} per pair, or without a ray");
        writeln!(out, "left out           {left_out} matches: {why}")?;
    }
    Ok(())
}

/// Errors of `t` and `R` divided by their reported standard deviations.
fn normalised_errors(summary: &Summary) -> Option<[f64; 2]> {
    let t = summary.e_t? / summary.sd_translation?;
    let r = summary.e_theta? / summary.sd_rotation?;
    Some([t, r])
}

/// Prints the verdict after the last pair for an operator.
///
/// * `weakest`: least certain direction of the estimate, and its standard deviation, rad.
pub(super) fn verdict(
    out: &mut impl Write,
    verdict: &Verdict<f32>,
    weakest: Option<(Direction, f32)>,
) -> Result<()> {
    let Verdict { rows_px, depth_px, coverage, image_coverage, state, .. } = verdict;
    writeln!(out, "\nVerdict on the extrinsics of the start, after the last pair")?;
    writeln!(out, "rows               {rows_px:.2} px off")?;
    writeln!(out, "depth              {depth_px:.2} px of disparity off, expected")?;
    writeln!(
        out,
        "coverage           {:.0} % of the matches fit; {:.0} % of the image covered",
        100.0 * coverage,
        100.0 * image_coverage
    )?;
    let doubt = labels::doubt(verdict.reasons).map_or(String::new(), |doubt| format!(", {doubt}"));
    let weakest = weakest.map_or(String::new(), |(direction, sd)| {
        format!(", weakest {} at {:.4} deg", labels::direction(direction), sd.to_degrees())
    });
    writeln!(out, "state              {state}{doubt}{weakest}")?;
    writeln!(out, "may arm            {}", labels::arming(verdict))?;
    Ok(())
}

/// Prints the row offsets over the last pair with the extrinsics in use, and the depth errors that they leave.
pub(super) fn details(
    out: &mut impl Write,
    details: &Details<f32>,
    baseline_m: Option<f32>,
) -> Result<()> {
    let Details { in_use_px, proposed_px, fit_in_use, fit_proposed, .. } = details;
    writeln!(
        out,
        "rows, last pair    {in_use_px:.3} px RMS in use ({fit_in_use} matches fit), {proposed_px:.3} px by the estimate ({fit_proposed} fit)",
    )?;
    if let Some(all) = baseline_m.map(|baseline| details.depth_errors(baseline)) {
        let at = DEPTHS_M.iter().zip(all);
        let errors: Vec<String> = at.map(|(z, e)| format!("{e:.3} m at {z} m")).collect();
        writeln!(out, "depth error        {}", errors.join(", "))?;
    }
    Ok(())
}

/// Prints the extrinsics in use.
pub(super) fn applied(
    out: &mut impl Write,
    applied: &Extrinsics<f32>,
    generation: u32,
) -> Result<()> {
    writeln!(out, "\nApplied, generation {generation}: p_r = R p_l + t, |t| = 1")?;
    extrinsics(out, applied)
}

/// Prints the estimate, and why it is not applied.
pub(super) fn not_applied(
    out: &mut impl Write,
    proposed: &Extrinsics<f32>,
    why: ApplyError,
) -> Result<()> {
    writeln!(out, "\nNot applied: {why}. Proposed: p_r = R p_l + t, |t| = 1")?;
    extrinsics(out, proposed)
}

fn extrinsics(out: &mut impl Write, extrinsics: &Extrinsics<f32>) -> Result<()> {
    let r = extrinsics.rotation_row_major();
    let t = extrinsics.translation();
    for (row, name) in r.chunks(3).zip(["R =", "", ""]) {
        let row: Vec<String> = row.iter().map(|x| format!("{x:>10.6}")).collect();
        writeln!(out, "{name:<4}[{} ]", row.join(" "))?;
    }
    writeln!(out, "t = [{:>10.6} {:>10.6} {:>10.6} ]", t.x, t.y, t.z)?;
    Ok(())
}
