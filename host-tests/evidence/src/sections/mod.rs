//! The page, section by section.

mod accuracy;
mod brief;
mod compared;
mod curves;
mod knock;
mod labels;
mod pictures;
mod published;
mod tables;

use std::collections::BTreeMap;

use super::measurement::MeasurementCounts;
use crate::findings::Findings;
use page::report::{Cell, Section, Table};

/// All sections, in the order of the page.
pub(super) fn all(findings: &Findings<'_>, counts: &MeasurementCounts) -> Vec<Section> {
    let mut all = vec![
        brief::section(findings),
        compared::section(findings),
        tables::section(findings),
        accuracy::section(findings),
    ];
    all.extend(curves::sections(findings));
    all.push(knock::section(findings));
    if findings.request.pictures {
        all.push(pictures::section(findings));
    }
    all.push(failures(findings, counts));
    all
}

/// Failed measurements, so that the page names every gap.
fn failures(findings: &Findings<'_>, counts: &MeasurementCounts) -> Section {
    let mut section = Section::new("Failed measurements");
    if counts.failed.is_empty() {
        section.text(format!("All {} measurements have an outcome.", counts.measurements));
        return section;
    }
    let heading = ["measurement", "count", "views or scenes", "why"];
    let mut table = Table::new("failed", heading.map(String::from));
    for ((what, why), of) in by_measurement(&counts.failed) {
        table.push(vec![
            Cell::text(what),
            Cell::count(of.len()),
            Cell::text(of.join("; ")),
            Cell::text(why).alarming(),
        ]);
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

/// Failed views or scenes by measurement and reason.
type Failures<'a> = BTreeMap<(&'a str, &'a str), Vec<&'a str>>;

fn by_measurement(failed: &[(String, String)]) -> Failures<'_> {
    let mut all = Failures::new();
    for (what, why) in failed {
        let (what, of) = what.rsplit_once(", ").unwrap_or((what, ""));
        all.entry((what, why)).or_default().push(of);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_of_a_measurement_for_one_reason_are_one_row() {
        let failed = [
            ("dang: RANSAC, agile on aloe, left top", "no estimate"),
            ("dang: RANSAC, agile on aloe, middle", "no estimate"),
            ("dang: RANSAC, agile on aloe, right top", "it panicked"),
        ];
        let failed = failed.map(|(what, why)| (what.to_owned(), why.to_owned()));
        let rows: Vec<_> = by_measurement(&failed).into_iter().collect();
        let what = "dang: RANSAC, agile on aloe";
        let expected = [
            ((what, "it panicked"), vec!["right top"]),
            ((what, "no estimate"), vec!["left top", "middle"]),
        ];
        assert_eq!(rows, expected);
    }
}
