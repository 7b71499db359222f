//! The page, section by section.

mod accuracy;
mod brief;
mod compared;
mod curves;
mod documents;
mod drift;
mod knock;
mod labels;

use std::collections::BTreeMap;

use super::measurement::MeasurementCounts;
use crate::findings::Findings;
use page::report::{Cell, Section, Table};

pub(crate) use documents::alone;
pub(super) use documents::write as write_documents;
pub(super) use drift::RATES as DRIFTS;

/// All sections, in the order of the page.
pub(super) fn all(findings: &Findings<'_>, counts: &MeasurementCounts) -> Vec<Section> {
    vec![
        brief::section(findings),
        compared::section(findings),
        accuracy::section(findings),
        curves::section(findings),
        knock::section(findings),
        drift::section(findings),
        failures(findings, counts),
    ]
}

/// Failed measurements, so that the page names every gap.
fn failures(findings: &Findings<'_>, counts: &MeasurementCounts) -> Section {
    let mut section = Section::new("Failed measurements");
    if counts.failed.is_empty() {
        section.text(format!("All {} measurements have an outcome.", counts.measurements));
        return section;
    }
    // The view or the scenes of a measurement follow its last comma.
    let mut all = BTreeMap::<(&str, &str), Vec<&str>>::new();
    for (what, why) in &counts.failed {
        let (what, of) = what.rsplit_once(", ").unwrap_or((what, ""));
        all.entry((what, why)).or_default().push(of);
    }
    let heading = ["measurement", "count", "views or scenes", "why"];
    let mut table = Table::new("failed", heading.map(String::from));
    for ((what, why), of) in all {
        let [views, why] = [of.join("; "), why.to_owned()].map(Cell::text);
        table.push(vec![Cell::text(what), Cell::count(of.len()), views, why.alarming()]);
    }
    let caption = format!(
        "Measurements without an outcome, {} of {}. On recordings a method that found nothing shows as \
         failed; curves have a gap.",
        counts.failed.len(),
        counts.measurements
    );
    section.table(table.explained(caption, &findings.request.command));
    section
}
