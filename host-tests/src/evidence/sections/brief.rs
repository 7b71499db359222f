//! The page in a few figures, each computed from what follows.

use super::curves::rms;
use super::order::FEW_OUTLIERS;
use crate::evidence::findings::Findings;
use crate::evidence::on_recorded::ErrorPair;
use crate::evidence::ordering::{ORDER, OrderCheck};
use crate::evidence::report::{Cell, Section, Table};
use crate::evidence::sweep::{Sweep, SweepAxis};

/// Pairs from a knock to the estimates of the table.
const AFTER: usize = 3;

/// A line of the table: what, and `e_t`, `e_theta` if measured.
type Line = (String, Option<ErrorPair>, usize);

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("In short");
    let wrong: Vec<&OrderCheck<'_>> =
        findings.checks.iter().filter(|j| j.row.set.outliers > FEW_OUTLIERS).collect();
    let [ours, paper, other] = ORDER;
    if !wrong.is_empty() {
        let holds = wrong.iter().filter(|check| check.holds()).count();
        let unexplained = wrong.iter().filter(|check| check.is_unexplained()).count();
        section.text(format!(
            "On recordings with outliers {ours} <= {paper} <= {other} holds in {holds} of {} cells, data \
             sets by views by the two errors. Exceptions without an explanation: {unexplained}.",
            wrong.len(),
        ));
    }
    let heading = ["what", "e_t", "e_theta"];
    let mut table = Table::new("in_short", heading.map(String::from));
    for (what, errors, decimals) in lines(findings, &wrong) {
        let Some([t, theta]) = errors else { continue };
        table.push(vec![
            Cell::text(what),
            Cell::number(t, decimals),
            Cell::number(theta, decimals),
        ]);
    }
    section.table(table.explained(
        "Figures of this page. Over the bound: RMS error over the least that the true matches allow, \
         which is 1 within the chance of so many scenes.",
        &findings.request.command,
    ));
    section
}

fn lines(findings: &Findings<'_>, wrong: &[&OrderCheck<'_>]) -> Vec<Line> {
    let [ours, paper, other] = ORDER;
    let ratio = |against: usize, name: &str| {
        let what = format!(
            "recordings with outliers: error of {name} over that of {ours}, geometric mean"
        );
        (what, ratios(wrong, against), 1)
    };
    let bound = |axis: SweepAxis, value: f64, what: &str| {
        (format!("{ours} over the bound: {what}"), over_bound(findings, axis, value), 2)
    };
    let after = |name: &str| {
        let what = format!("{AFTER} pairs after a knock of 0.0087 rad: {name}, rad");
        (what, after_step(findings, name), 5)
    };
    vec![
        ratio(1, paper),
        ratio(2, other),
        bound(SweepAxis::Outliers, 0.0, "one pair of 256 matches, none wrong"),
        bound(SweepAxis::Outliers, 0.3, "one pair, 30 % wrong"),
        bound(SweepAxis::Outliers, 0.6, "one pair, 60 % wrong"),
        bound(SweepAxis::Pairs, 100.0, "100 pairs fused, 10 % wrong"),
        after(ours),
        after(paper),
    ]
}

/// Geometric means over the cells in which both have an estimate.
fn ratios(checks: &[&OrderCheck<'_>], against: usize) -> Option<ErrorPair> {
    let of = |part: usize| {
        let of_part = checks.iter().filter(|j| j.part == part);
        let logs: Vec<f64> = of_part
            .map(|j| (j.errors[against] / j.errors[0]).ln())
            .filter(|log| log.is_finite())
            .collect();
        let count = f64::from(u32::try_from(logs.len()).ok()?);
        (count > 0.0).then(|| (logs.iter().sum::<f64>() / count).exp())
    };
    Some([of(0)?, of(1)?])
}

fn over_bound(findings: &Findings<'_>, axis: SweepAxis, value: f64) -> Option<ErrorPair> {
    let sweep: &Sweep = findings.sweeps.iter().find(|sweep| sweep.axis == axis)?;
    let place = findings.methods.iter().position(|by| by.name() == ORDER[0])?;
    let at = sweep.values.iter().position(|x| x.total_cmp(&value).is_eq())?;
    let [t, theta] = *sweep.bound[at].as_ref().ok()?;
    let trials = &sweep.trials[place][at];
    Some([rms(trials, |trial| trial.e_t)? / t, rms(trials, |trial| trial.e_theta)? / theta])
}

fn after_step(findings: &Findings<'_>, method: &str) -> Option<ErrorPair> {
    let (_, response) = findings.step_responses.iter().find(|(name, _)| *name == method)?;
    *response.as_ref().ok()?.get(super::knock::FIRST + AFTER - 1)?
}
