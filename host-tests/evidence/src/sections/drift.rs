//! The running estimates of a rig that drifts.

use super::labels::named;
use crate::findings::Findings;
use crate::on_recorded::ErrorPair;
use crate::rivals::Variant;
use crate::step_response::{PAIRS, StepResponse};
use page::report::{Cell, Section, Table};

/// Turn of the right camera with every pair, rad.
pub(crate) const RATES: [f64; 3] = [1e-5, 1e-4, 1e-3];

/// Pairs before the estimates count.
const SETTLED: usize = PAIRS / 2;

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("While it drifts");
    section.text(format!(
        "The right camera turns with every pair about an axis of each run, with 10 % outliers. The pairs {SETTLED} to {PAIRS} \
         count. A method that expects a constant rig lags behind; one that \
         forgets fast follows, and pays with its error while the rig is at rest.",
    ));
    let all: Vec<usize> = (0..findings.step_responses.len()).collect();
    section.table(table(findings, &all).explained(
        "e_t and e_theta, rad, of every method and setting while the rig turns by so many rad a pair, root mean \
         square over pairs and runs. The best of a column is marked.",
        &findings.request.command,
    ));
    section
}

/// The rows of each method with the settings that are best over all rates.
pub(super) fn of_each_method(findings: &Findings<'_>) -> Table {
    let by = |i: usize| -> &Variant { findings.step_responses[i].0 };
    let overall = |i: usize| -> f64 { values(findings, i).iter().flatten().map(|e| e.ln()).sum() };
    let mut best: Vec<usize> = Vec::new();
    for i in 0..findings.step_responses.len() {
        match best.last_mut().filter(|last| by(**last).method.name() == by(i).method.name()) {
            Some(last) if overall(i) < overall(*last) => *last = i,
            Some(_) => {}
            None => best.push(i),
        }
    }
    table(findings, &best)
}

/// Errors of a method, by rate; `t` before `R`. `None`: fewer than half of the runs have an estimate.
fn values(findings: &Findings<'_>, method: usize) -> Vec<Option<f64>> {
    let of_rate = |responses: &Vec<StepResponse>| settled(&responses[method]);
    let errors = findings.drifts.iter().map(of_rate);
    errors.flat_map(|error| [0, 1].map(|part| error.map(|error| error[part]))).collect()
}

/// Root mean square over the pairs that count.
fn settled(response: &StepResponse) -> Option<ErrorPair> {
    let errors: Vec<ErrorPair> = response[SETTLED..].iter().copied().collect::<Option<_>>()?;
    let count = u32::try_from(errors.len()).ok().map(f64::from)?;
    let rms = |part: usize| (errors.iter().map(|e| e[part].powi(2)).sum::<f64>() / count).sqrt();
    Some([rms(0), rms(1)])
}

fn table(findings: &Findings<'_>, methods: &[usize]) -> Table {
    let of_rate = |rate: f64| [format!("e_t at {rate:.0e}"), format!("e_theta at {rate:.0e}")];
    let mut heading = vec!["method, settings".to_owned()];
    heading.extend(RATES.into_iter().flat_map(of_rate));
    let mut table = Table::new("while_it_drifts", heading);
    let all: Vec<Vec<Option<f64>>> = methods.iter().map(|i| values(findings, *i)).collect();
    let least =
        |column: usize| all.iter().filter_map(|row| row[column]).fold(f64::INFINITY, f64::min);
    for (method, errors) in methods.iter().zip(&all) {
        let cell = |(column, error): (usize, &Option<f64>)| match error {
            Some(e) if *e <= least(column) => Cell::number(*e, 5).best(),
            Some(e) => Cell::number(*e, 5),
            None => Cell::missing("none", "an estimate in fewer than half of the runs"),
        };
        let mut row = vec![Cell::text(named(findings.step_responses[*method].0))];
        row.extend(errors.iter().enumerate().map(cell));
        table.push(row);
    }
    table
}
