//! Whether the order of the paper holds, cell by cell.

use super::Found;
use crate::evaluate::ordering::{Judged, ORDER, Reason};
use crate::report::{Cell, Section, Table};

pub(super) fn section(found: &Found<'_>) -> Section {
    let mut section = Section::new("Does the paper's order hold?");
    let [ours, paper, other] = ORDER;
    section.text(format!(
        "The paper's method is reported to be better than Ling and Shen's, [7]; ours should be no worse \
         than the paper's on data with mismatches. A cell is one data set, one view and one error; the \
         order holds in it if {ours} <= {paper} <= {other}.",
    ));
    if found.judged.is_empty() {
        section.text(format!("Not judged: that takes the methods {ours}, {paper} and {other}."));
        return section;
    }
    section.text(summary(found.judged));
    section.text(
        "Where it does not hold, the reason is looked for in the data, in this order. Reference: the \
         difference is below the reference's own standard error. Chance: it is below two standard \
         deviations of itself, by a jackknife that leaves out a twelfth of the pairs, or of the matches \
         where there are few pairs, for both methods alike. Data: the matches that agree with the \
         reference have their optimum that far from it, so the recording cannot tell the methods apart \
         by this reference. Pairs: pair by pair the order holds. What is left is unexplained.",
    );
    let heading = ["data set", "view", "error", ours, paper, other, "holds", "if not, why"];
    let mut table = Table::new("order", heading.map(String::from));
    for judged in found.judged {
        table.push(row(judged));
    }
    let caption = "The order, cell by cell; errors in rad.";
    section.table(table.explained(caption, &found.request.command));
    section
}

fn summary(judged: &[Judged<'_>]) -> String {
    let count = |which: &dyn Fn(&Judged<'_>) -> bool| judged.iter().filter(|j| which(j)).count();
    let first = |step: usize| {
        let fits =
            move |j: &Judged<'_>| j.errors.is_some_and(|errors| errors[step] <= errors[step + 1]);
        count(&fits)
    };
    let all = judged.len();
    let holds = count(&|j| j.holds());
    let unexplained = count(&|j| j.is_unexplained());
    let [ours, paper, other] = ORDER;
    format!(
        "It holds in {holds} of {all} cells; of the others {} are explained by the data and {unexplained} \
         are not. Step by step: {ours} <= {paper} in {} of {all}, {paper} <= {other} in {} of {all}.",
        all - holds - unexplained,
        first(0),
        first(1),
    )
}

fn row(judged: &Judged<'_>) -> Vec<Cell> {
    let Judged { row, part, errors, exceptions } = judged;
    let mut cells = vec![
        Cell::text(row.set.name.as_str()),
        Cell::text(row.look.view),
        Cell::text(["e_t", "e_theta"][*part]),
    ];
    match errors {
        Some(errors) => cells.extend(errors.map(|error| Cell::number(error, 4))),
        None => cells.extend([(); 3].map(|()| Cell::missing("", "a method has no estimate"))),
    }
    let steps: Vec<String> = exceptions.iter().map(ToString::to_string).collect();
    let (holds, why) = match (errors, judged.holds()) {
        (None, _) => ("unknown", "a method has no estimate".to_owned()),
        (_, true) => ("yes", String::new()),
        _ => ("no", steps.join("; ")),
    };
    let unexplained = exceptions.iter().any(|e| e.reason == Reason::Unexplained);
    let why = Cell::text(why);
    cells.push(Cell::text(holds));
    cells.push(if unexplained || errors.is_none() { why.alarming() } else { why });
    cells
}
