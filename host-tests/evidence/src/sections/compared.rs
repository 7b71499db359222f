//! The methods and the data sets.

use super::labels::label;
use crate::findings::Findings;
use crate::recorded_sets::RecordedSet;
use crate::rivals::Variant;
use page::report::{Cell, Section, Table};

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("Methods and data");
    let command = findings.request.command.as_str();
    section.text(
        "e_t is the angle between the estimated and the true baseline direction, e_theta the distance \
         of the rotation vectors (eqs 23, 24 of the paper), both of all pairs of a recording fused; \
         sigma_t and sigma_theta are the same errors of single pairs, root mean square (eqs 25, 26).",
    );
    let mut methods = Table::new("methods", ["method".into(), "what it is".into()]);
    for method in findings.methods {
        methods.push(vec![Cell::text(label(method.name())), Cell::text(method.source())]);
    }
    section.table(methods.explained(
        "The methods. robust and paper are this project's presets, as shipped; the others are written \
         from their publications for this comparison.",
        command,
    ));
    section.table(settings(findings).explained(
        "Settings. All start at R = I, t = (-1, 0, 0). Gate: pairs more than 0.5 rad from the start, or with a \
         standard deviation above 0.12 rad, are refused. RANSAC: five points, MSAC at 3 noise deviations, the \
         same for all. Noise: methods are given 0.3 px on recordings, and the true value on generated scenes; \
         or it is estimated from the inliers of RANSAC. Process noise of a filter, for each pair and axis: \
         1e-5 rad steady, 1e-3 rad agile; the tracker teso remembers ten frames, or one if agile. On recordings each cell shows the best of all.",
        command,
    ));
    let heading = ["data set", "pairs", "matches", "wrong, %", "sd t, rad", "sd R, rad", "source"];
    let mut sets = Table::new("data_sets", heading.map(String::from));
    for set in findings.sets {
        sets.push(row(set));
    }
    section.table(sets.explained(
        "The recorded data. Matches passed no geometric test, so the outliers are the matcher's own: \
         wrong are those more than 2 px off the reference's rows. sd: standard error of the reference extrinsics for the intrinsics they come with, where it is \
         known.",
        command,
    ));
    section
}

fn settings(findings: &Findings<'_>) -> Table {
    let heading = ["method", "settings on recordings", "on generated scenes"];
    let mut table = Table::new("settings", heading.map(String::from));
    for method in findings.methods {
        let of = |variants: &[Variant]| -> String {
            let of_method = variants.iter().filter(|by| by.method.name() == method.name());
            of_method.map(|by| by.tuning.words()).collect::<Vec<_>>().join("; ")
        };
        table.push(vec![
            Cell::text(label(method.name())),
            Cell::text(of(findings.variants)),
            Cell::text(of(findings.few)),
        ]);
    }
    table
}

fn row(set: &RecordedSet) -> Vec<Cell> {
    let pairs = set.views.first().map_or(0, |seen| seen.pairs.len());
    let unknown = || Cell::missing("not known", "not given by the data set");
    let [t, r] = match set.reference {
        Some(sd) => [sd.translation, sd.rotation].map(|sd| Cell::number(sd, 4)),
        None => [unknown(), unknown()],
    };
    let source = Cell::text(set.source.as_str());
    vec![
        Cell::text(set.name.as_str()),
        Cell::count(pairs),
        Cell::count(set.matches()),
        Cell::number(100.0 * set.outliers, 1),
        t,
        r,
        source,
    ]
}
