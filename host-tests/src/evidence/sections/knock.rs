//! The running estimate of a rig that is knocked once.

use super::labels::{label, line};
use crate::chart::curves::{self, Curve, Scale};
use crate::evidence::findings::Findings;
use crate::evidence::report::{Csv, Entry, Figure, Picture, Sample, Section};
use crate::evidence::step_response::{PAIRS, TURN_DEG};

/// The first pair of the turned rig.
pub(super) const FIRST: usize = PAIRS / 2;

const PARTS: [&str; 2] = ["e_t", "e_theta"];

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("After a knock");
    section.text(format!(
        "The right camera turns by {TURN_DEG} degrees about a random axis at pair {FIRST} of {PAIRS}, with 10 % \
         outliers. A mean over all pairs keeps the old rig, and a filter forgets it slowly. The robust preset \
         detects the change and starts a new estimate.",
    ));
    let panel = |(part, name): (usize, &&str)| {
        let mut curves: Vec<Curve> = findings
            .step_responses
            .iter()
            .filter_map(|(method, response)| {
                let errors = response.as_ref().ok()?.iter().map(|e| e.map(|e| e[part]));
                let points = (0_u32..).map(f64::from).zip(errors).collect();
                let color = Some(findings.color(method));
                Some(Curve { color, line: line(method), points })
            })
            .collect();
        curves.reverse();
        let x = Scale { name: "pair".into(), log: false };
        let y = format!("{name}, rad");
        let svg = curves::curves(&y, &x, &curves);
        (Picture::Svg(svg), format!("{y} over pairs"))
    };
    let mut numbers = Csv::new("step", &["pair", "method", "e_t, rad", "e_theta, rad"]);
    for (method, response) in &findings.step_responses {
        for (pair, error) in response.iter().flatten().enumerate() {
            let text = |part: usize| error.map_or(String::new(), |e| e[part].to_string());
            numbers.push([pair.to_string(), (*method).to_owned(), text(0), text(1)]);
        }
    }
    let legend = findings
        .step_responses
        .iter()
        .map(|(method, _)| Entry::new(Sample::Line, Some(findings.color(method)), &label(method)));
    section.figure(Figure {
        panels: PARTS.iter().enumerate().map(panel).collect(),
        legend: legend.collect(),
        caption: format!(
            "Error of the running estimate after each pair, root mean square over {} runs.",
            findings.request.effort.steps
        ),
        command: findings.request.command.clone(),
        numbers,
    });
    section
}
