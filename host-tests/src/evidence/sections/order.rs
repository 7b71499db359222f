//! Whether the order of the paper holds, cell by cell.

use crate::evidence::findings::Findings;
use crate::evidence::ordering::{ORDER, OrderCheck, Reason};
use crate::evidence::report::{Cell, Section, Table};

/// A recording with fewer outliers than this share is one without.
pub(super) const FEW_OUTLIERS: f64 = 0.01;

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("Does the paper's order hold?");
    let [ours, paper, other] = ORDER;
    section.text(format!(
        "The paper reports that its method is better than Ling and Shen's, [7]; ours should be no worse than the \
         paper's on data with outliers. A cell is one data set, one view and one error; the order holds in it if \
         {ours} <= {paper} <= {other}. A method without an estimate is worse than any. Without outliers the three \
         almost coincide, as the curves over matches and noise show.",
    ));
    if findings.checks.is_empty() {
        section.text(format!("Not checked: this needs the methods {ours}, {paper} and {other}."));
        return section;
    }
    let (wrong, clean): (Vec<_>, Vec<_>) =
        findings.checks.iter().partition(|check| check.row.set.outliers > FEW_OUTLIERS);
    let few = 100.0 * FEW_OUTLIERS;
    section.text(summary(&format!("Recordings with outliers (above {few} %)"), &wrong));
    section.text(summary("Recordings without", &clean));
    section.text(
        "Where the order does not hold, these reasons are tried in this order. Reference: the difference is below \
         the reference's own standard error. Chance: it is below two standard deviations of itself, by a \
         jackknife that leaves out a twelfth of the pairs, or of the matches where there are few pairs, the same \
         for both methods. Data: the optimum of the matches that agree with the reference is that far from it, so \
         the recording cannot distinguish the methods by this reference. Pairs: the order holds for single \
         pairs. All others are unexplained.",
    );
    let heading = ["data set", "view", "error", ours, paper, other, "holds", "if not, why"];
    let mut table = Table::new("order", heading.map(String::from));
    for check in findings.checks {
        table.push(row(check));
    }
    let caption = "The order, cell by cell; errors in rad.";
    section.table(table.explained(caption, &findings.request.command));
    section
}

fn summary(name: &str, checks: &[&OrderCheck<'_>]) -> String {
    let all = checks.len();
    let count =
        |which: &dyn Fn(&OrderCheck<'_>) -> bool| checks.iter().filter(|j| which(j)).count();
    let step = |step: usize| count(&|j| j.errors[step] <= j.errors[step + 1]);
    let because = |which: fn(&Reason) -> bool| {
        count(&|j| !j.is_unexplained() && j.violations.iter().any(|e| which(&e.reason)))
    };
    let [ours, paper, other] = ORDER;
    let holds = count(&|j| j.holds());
    let words = format!(
        "{name}: the order holds in {holds} of {all} cells, {ours} <= {paper} in {} and {paper} <= {other} in \
         {}.",
        step(0),
        step(1),
    );
    let reasons = [
        (because(|reason| matches!(reason, Reason::Reference { .. })), "reference"),
        (because(|reason| matches!(reason, Reason::Chance { .. })), "chance"),
        (because(|reason| matches!(reason, Reason::Data { .. })), "data"),
        (because(|reason| matches!(reason, Reason::SinglePairs { .. })), "pairs"),
        (count(&|j| j.is_unexplained()), "unexplained"),
    ];
    let reasons = reasons.iter().filter(|(cells, _)| *cells > 0);
    let reasons: Vec<String> = reasons.map(|(cells, why)| format!("{why} {cells}")).collect();
    if holds == all {
        return words;
    }
    format!("{words} The others, some for two reasons: {}.", reasons.join(", "))
}

fn row(check: &OrderCheck<'_>) -> Vec<Cell> {
    let OrderCheck { row, part, errors, violations } = check;
    let mut cells = vec![
        Cell::text(row.set.name.as_str()),
        Cell::text(row.seen.view),
        Cell::text(["e_t", "e_theta"][*part]),
    ];
    cells.extend(errors.map(|error| match error {
        f64::INFINITY => Cell::missing("none", "no estimate"),
        error => Cell::number(error, 4),
    }));
    let steps: Vec<String> = violations.iter().map(ToString::to_string).collect();
    let why = Cell::text(steps.join("; "));
    cells.push(Cell::text(if check.holds() { "yes" } else { "no" }));
    cells.push(if check.is_unexplained() { why.alarming() } else { why });
    cells
}
