//! The page in a few figures, each computed from what follows.

use super::Found;
use super::curves::rms;
use super::order::FEW_MISMATCHES;
use crate::evaluate::ordering::{Judged, ORDER};
use crate::evaluate::sweep::{Axis, Sweep};
use crate::report::{Cell, Section, Table};

/// How long after a knock the estimate is looked at, pairs.
const AFTER: [usize; 2] = [3, 20];

pub(super) fn section(found: &Found<'_>) -> Section {
    let mut section = Section::new("In short");
    let mut table = Table::new("in_short", ["what".into(), "figure".into()]);
    let mut line = |what: &str, figure: Option<String>| {
        table.push(vec![
            Cell::text(what),
            figure.map_or(Cell::missing("-", "not measured"), Cell::text),
        ]);
    };
    let wrong: Vec<&Judged<'_>> =
        found.judged.iter().filter(|j| j.row.set.mismatches > FEW_MISMATCHES).collect();
    let [ours, paper, other] = ORDER;
    line(
        &format!("recordings with mismatches: cells in which {ours} <= {paper} <= {other}"),
        (!wrong.is_empty()).then(|| {
            let holds = wrong.iter().filter(|judged| judged.holds()).count();
            let unexplained = wrong.iter().filter(|judged| judged.is_unexplained()).count();
            format!("{holds} of {}; {unexplained} unexplained", wrong.len())
        }),
    );
    for (against, name) in [(1, paper), (2, other)] {
        line(
            &format!("the same: error of {name} over that of {ours}, geometric mean, e_t, e_theta"),
            ratios(&wrong, against),
        );
    }
    line(
        &format!(
            "one pair of 256 matches: e_t, e_theta of {ours} over the Cramer-Rao bound, without \
             mismatches and with most"
        ),
        over_bound(found, Axis::Outliers),
    );
    line(
        &format!("pairs fused, 10 % wrong: the same, of one pair and of most"),
        over_bound(found, Axis::Pairs),
    );
    let [soon, later] = AFTER;
    line(
        &format!(
            "after a knock: e_theta of {ours}, {paper} after {soon} pairs; after {later} pairs, rad"
        ),
        knocked(found),
    );
    section.table(table.explained(
        "Figures of this page. Ratios above 1 in favour of ours; 1 is as good as the bound.",
        &found.request.command,
    ));
    section
}

/// Geometric means over the cells in which both have an estimate.
fn ratios(judged: &[&Judged<'_>], against: usize) -> Option<String> {
    let of = |part: usize| {
        let ratio = |j: &&&Judged<'_>| j.errors[against] / j.errors[0];
        let logs: Vec<f64> = judged
            .iter()
            .filter(|j| j.part == part)
            .map(|j| ratio(&j).ln())
            .filter(|log| log.is_finite())
            .collect();
        let count = f64::from(u32::try_from(logs.len()).ok()?);
        (count > 0.0).then(|| (logs.iter().sum::<f64>() / count).exp())
    };
    Some(format!("{:.1}, {:.1}", of(0)?, of(1)?))
}

/// At the first and at the last value.
fn over_bound(found: &Found<'_>, axis: Axis) -> Option<String> {
    let sweep: &Sweep = found.sweeps.iter().find(|sweep| sweep.axis == axis)?;
    let place = found.methods.iter().position(|by| by.name() == ORDER[0])?;
    let at = |i: usize| {
        let trials = &sweep.trials[place][i];
        let bound = sweep.bound[i].as_ref().ok()?;
        let [t, r] = [rms(trials, |t| t.e_t)? / bound[0], rms(trials, |t| t.e_theta)? / bound[1]];
        Some(format!("{t:.2}, {r:.2} at {}", sweep.values[i]))
    };
    Some(format!("{}; {}", at(0)?, at(sweep.values.len().checked_sub(1)?)?))
}

fn knocked(found: &Found<'_>) -> Option<String> {
    let of = |method: &str, after: usize| {
        let (_, course) = found.courses.iter().find(|(name, _)| *name == method)?;
        let [_, e_theta] = (*course.as_ref().ok()?.get(super::knock::FIRST + after - 1)?)?;
        Some(format!("{e_theta:.5}"))
    };
    let [soon, later] = AFTER;
    let [ours, paper, _] = ORDER;
    let both = |after: usize| Some(format!("{}, {}", of(ours, after)?, of(paper, after)?));
    Some(format!("{}; {}", both(soon)?, both(later)?))
}
