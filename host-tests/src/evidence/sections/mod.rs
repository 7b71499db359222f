//! The page, section by section.

mod accuracy;
mod brief;
mod compared;
mod curves;
mod knock;
mod labels;
mod order;
mod pictures;

use super::measurement::Tally;
use crate::evidence::findings::Findings;
use crate::evidence::report::{Cell, Section, Table};

/// All sections, in the order of the page.
pub(super) fn all(found: &Findings<'_>, tally: &Tally) -> Vec<Section> {
    let mut all = vec![
        brief::section(found),
        compared::section(found),
        accuracy::section(found),
        order::section(found),
    ];
    all.extend(curves::sections(found));
    all.push(knock::section(found));
    if found.request.pictures {
        all.push(pictures::section(found));
    }
    all.push(failures(found, tally));
    all
}

/// What could not be measured, so that nothing is missing in silence.
fn failures(found: &Findings<'_>, tally: &Tally) -> Section {
    let mut section = Section::new("What failed");
    if tally.failed.is_empty() {
        section.text(format!("All {} measurements have an outcome.", tally.cells));
        return section;
    }
    let mut table = Table::new("failed", ["measurement".into(), "why".into()]);
    for (what, why) in &tally.failed {
        table.push(vec![Cell::text(what.as_str()), Cell::text(why.as_str()).alarming()]);
    }
    let caption = format!(
        "Measurements without an outcome, {} of {}. On recordings a method that found nothing shows as \
         failed; curves have a gap.",
        tally.failed.len(),
        tally.cells
    );
    section.table(table.explained(caption, &found.request.command));
    section
}
