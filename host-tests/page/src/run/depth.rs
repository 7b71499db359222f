//! Error of depth before and after the run: the calibrator's expectation, and the measurement with true depths.

use sim::run::{DEPTHS_M, Summary, metres};

use super::Replayed;
use crate::report::{Cell, Section, Table};

/// `None` if depth is neither expected nor measured.
pub(super) fn section(replayed: &Replayed<'_>, summary: &Summary) -> Option<Section> {
    let (expected, measured) = (summary.depth_expected, replayed.depth);
    if expected.is_none() && measured.is_none() {
        return None;
    }
    let [near, far] = DEPTHS_M;
    let columns = [
        "expected, px".to_owned(),
        "measured, px".to_owned(),
        format!("expected at {near} m, m"),
        format!("measured at {near} m, m"),
        format!("expected at {far} m, m"),
        format!("measured at {far} m, m"),
    ];
    let row = |name, expected: Option<f64>, measured: Option<f64>| {
        let both = [expected, measured];
        let at = both.map(|px| px.and_then(|px| metres(replayed.set, px).ok()));
        let at = |i: usize| at.map(|metres| metres.map(|metres| metres[i]));
        (name, [both, at(0), at(1)].concat())
    };
    let used = replayed.log.steps().last().and_then(|step| step.checked);
    let is_applied = used.is_some_and(|used| used.in_use != *replayed.log.factory());
    let rows = [
        Some(row("before", expected.map(|e| e.before_px), measured.map(|m| m.before_px))),
        is_applied.then(|| {
            let measured = measured.map(|m| m.in_use_px);
            row("in use after the last pair", expected.map(|e| e.in_use_px), measured)
        }),
        expected.map(|e| row("estimate", Some(e.estimate_px), None)),
        measured.and_then(|m| Some(row("reference of the recording", None, Some(m.reference_px?)))),
    ];
    let rows: Vec<_> = rows.into_iter().flatten().collect();
    // Columns without any number are left out.
    let shown = |i: &usize| rows.iter().any(|(_, values)| values[*i].is_some());
    let shown: Vec<usize> = (0..columns.len()).filter(shown).collect();
    let heading = shown.iter().map(|&i| columns[i].clone());
    let mut table = Table::new("depth", ["extrinsics".to_owned()].into_iter().chain(heading));
    for (name, values) in &rows {
        let cells = shown.iter().map(|&i| Cell::known(values[i], 3, "not known"));
        table.push([Cell::text(*name)].into_iter().chain(cells).collect());
    }
    let mut section = Section::new("Depth");
    section.table(table.explained(
        "Error of disparity caused by yaw, and the resulting error of depth. Expected: distance of the yaw \
         from the estimate, with the deviation of the estimate, the lens uncertain (one standard deviation); \
         of the estimate this deviation alone. Measured: median of |1/Z - 1/Z_true| f b over the matches of \
         known depth; it includes the noise of the matches.",
        replayed.command,
    ));
    Some(section)
}
