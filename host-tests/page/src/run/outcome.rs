//! The final numbers.

use stereo_selfcal::geometry::{LensCorrection, so3};
use stereo_selfcal::{Extrinsics, State};

use super::Replayed;
use crate::report::{Cell, Section, Table};
use rigs::data::{Meta, rows};
use sim::run::{Reference, SCREEN_PX, Summary};

pub(super) fn section(replayed: &Replayed<'_>, summary: &Summary) -> Section {
    let mut section = Section::new("Outcome");
    section.text(
        "p_r = R p_l + t, |t| = 1: R and t take points of the left camera to the right one. Camera \
         frames are x right, y down, z forward; a side-by-side rig has R = I, t = (-1, 0, 0).",
    );
    match replayed.log.fused() {
        None if replayed.log.has_begun_again() => section.alarm(
            "There is no estimate: it restarted with a corrected lens, and no pair was fused since.",
        ),
        None => section.alarm("There is no estimate: no pair could be fused."),
        Some(fused) if fused.state != State::Locked => {
            section.alarm(format!("The calibrator does not confirm this estimate: {fused}."));
        }
        Some(fused) if fused.is_doubtful() => {
            section.alarm(format!("The calibrator doubts this estimate: {fused}."));
        }
        Some(_) => {}
    }
    section.table(table(replayed, summary));
    if let Some(fused) = replayed.log.fused() {
        section.table(extrinsics(replayed, &fused.extrinsics));
    }
    section
}

fn table(replayed: &Replayed<'_>, summary: &Summary) -> Table {
    let mut table = Table::new("outcome", ["quantity", "value", "unit"].map(Into::into));
    let mut row = |name: &str, value: Cell, unit: &str| {
        table.push(vec![Cell::text(name), value, Cell::text(unit)]);
    };
    row("state", Cell::text(&summary.state), "");
    if let Some(verdict) = &summary.verdict {
        let why = verdict.reasons.iter().chain(&verdict.cause);
        let why = why.map(String::as_str).collect::<Vec<_>>().join(", ");
        row("may arm", Cell::text(if verdict.may_arm { "yes" } else { "no" }).with_hint(&why), "");
        row("against the calibration in use", Cell::text(why), "");
        let px = |px| Cell::known(px, 2, "no pair was solved");
        row("rows in use, off", px(verdict.rows_px), "px");
        row("disparities in use, expected to be off", px(verdict.depth_px), "px");
        row(
            "share of the matches that fit the calibration in use",
            Cell::number(verdict.coverage, 2),
            "",
        );
        let step = summary.grid_step_px.filter(|px| *px > 0.0);
        row("grid of the rows, stated or found", Cell::known(step, 2, "continuous rows"), "px");
    }
    row("pairs fused", Cell::count(summary.accepted), "");
    row("pairs", Cell::count(summary.pairs), "");
    if let Some(fused) = replayed.log.fused() {
        let w = so3::log(fused.extrinsics.rotation());
        let names = ["x (pitch)", "y (yaw)", "z (roll)"];
        for (name, turn) in names.iter().zip(&w) {
            row(
                &format!("R as a rotation vector, {name}"),
                Cell::number(turn.to_degrees(), 4),
                "deg",
            );
        }
    }
    let LensCorrection { focal, k1 } = summary.correction;
    if !summary.correction.is_none() {
        row("correction of the right focal length", Cell::number(100.0 * focal, 3), "%");
        row("correction of the right k1", Cell::number(k1, 5), "");
    }
    let mut known = |name: &str, value: Option<f64>, factor: f64, decimals, unit: &str| {
        row(name, Cell::known(value.map(|x| x * factor), decimals, "no estimate"), unit);
    };
    known("standard deviation of R, reported", summary.sd_rotation, 1e3, 3, "mrad");
    known("standard deviation of t, reported", summary.sd_translation, 1e3, 3, "mrad");
    let from = summary.reference.words();
    known(&format!("R {from}, e_theta"), summary.e_theta, 1e3, 3, "mrad");
    known(&format!("t {from}, e_t"), summary.e_t, 1e3, 3, "mrad");
    known("row offset of fitting matches before, RMS", summary.rms_px_before, 1.0, 3, "px");
    known("row offset of fitting matches after, RMS", summary.rms_px_after, 1.0, 3, "px");
    let share = |i: usize| summary.in_row.map(|share| share[i]);
    known(&format!("all matches within {SCREEN_PX} px before"), share(0), 100.0, 1, "%");
    known(&format!("all matches within {SCREEN_PX} px after"), share(1), 100.0, 1, "%");
    table.explained(
        format!(
            "Proposal of the calibrator after the last pair. Fitting: within {SCREEN_PX} px of their \
             row under this estimate. {} Arming needs rows within 1 px, disparities within 2 px and a share of \
             0.7, unless the configuration says otherwise.{}",
            match summary.reference {
                Reference::None => "",
                Reference::Start => {
                    "The run started from the R and t of the rig file: a distance from them is a move of the rig, an error, or both."
                }
                Reference::Known => "The reference is the rig of the recording.",
            },
            source(&replayed.set.meta),
        ),
        replayed.command,
    )
}

fn source(meta: &Meta) -> String {
    match meta.source.as_str() {
        "" => String::new(),
        source => format!(" Source: {source}."),
    }
}

/// `R` beside `t`, in the layout of their product.
fn extrinsics(replayed: &Replayed<'_>, found: &Extrinsics<f64>) -> Table {
    let heading = ["row", "R, column 1", "R, column 2", "R, column 3", "t, baselines"];
    let mut table = Table::new("extrinsics", heading.map(Into::into));
    let axes = ["x", "y", "z"];
    for ((axis, r), t) in
        axes.iter().zip(rows(found.rotation().matrix())).zip(found.translation().iter())
    {
        let numbers = r.iter().chain([t]).map(|x| Cell::number(*x, 6));
        table.push([Cell::text(*axis)].into_iter().chain(numbers).collect());
    }
    table.explained("R and t of p_r = R p_l + t, all digits in the file.", replayed.command)
}
