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
    let heading = [
        "extrinsics".to_owned(),
        "expected, px".to_owned(),
        "measured, px".to_owned(),
        format!("expected at {near} m, m"),
        format!("measured at {near} m, m"),
        format!("expected at {far} m, m"),
        format!("measured at {far} m, m"),
    ];
    let mut table = Table::new("depth", heading.to_vec());
    let mut row = |name: &str, expected: Option<f64>, measured: Option<f64>| {
        let both = [expected, measured];
        let at = both.map(|px| px.and_then(|px| metres(replayed.set, px).ok()));
        let at = |i: usize| at.map(|metres| metres.map(|metres| metres[i]));
        let [at_near, at_far] = [at(0), at(1)];
        let cells = both.into_iter().chain(at_near).chain(at_far);
        let cells = cells.map(|value| Cell::known(value, 3, "not known"));
        table.push([Cell::text(name)].into_iter().chain(cells).collect());
    };
    row("before", expected.map(|e| e.before_px), measured.map(|m| m.before_px));
    row("in use after the last pair", expected.map(|e| e.in_use_px), measured.map(|m| m.in_use_px));
    if let Some(px) = measured.and_then(|m| m.reference_px) {
        row("reference of the recording", None, Some(px));
    }
    let mut section = Section::new("Depth");
    section.table(table.explained(
        "Error of disparity caused by yaw, and the resulting error of depth. Expected: distance of the yaw \
         from the estimate, with the deviation of the estimate, the lens uncertain (one standard deviation). \
         Measured: median of |1/Z - 1/Z_true| f b over the matches of known depth; it includes the noise of \
         the matches.",
        replayed.command,
    ));
    Some(section)
}
