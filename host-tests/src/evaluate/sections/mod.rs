//! The page, section by section.

mod accuracy;
mod compared;
mod curves;
mod knock;
mod order;

use super::Found;
use super::chart::Line;
use super::runner::Tally;
use crate::report::Section;

/// All sections, in the order of the page.
pub(super) fn all(found: &Found<'_>, tally: &Tally) -> Vec<Section> {
    let mut all = vec![compared::section(found), accuracy::section(found), order::section(found)];
    all.extend(curves::sections(found));
    all.push(knock::section(found));
    all.push(failures(tally));
    all
}

/// A method in a legend or a heading.
fn label(method: &str) -> String {
    match method {
        "robust" => "ours: robust".into(),
        "paper" => "ours: paper".into(),
        "ling-shen" => "ling-shen [7]".into(),
        other => other.into(),
    }
}

/// The presets stand out.
fn line(method: &str) -> Line {
    if ["robust", "paper"].contains(&method) { Line::Broad } else { Line::Thin }
}

/// What could not be measured, so that nothing is missing in silence.
fn failures(tally: &Tally) -> Section {
    let mut section = Section::new("What failed");
    if tally.failed.is_empty() {
        section.text(format!("All {} measurements have an outcome.", tally.cells));
    } else {
        let (failed, all) = (tally.failed.len(), tally.cells);
        section.text(format!("{failed} of {all} measurements have no outcome:"));
        tally.failed.iter().for_each(|why| section.alarm(why));
    }
    section
}
