//! Compares a measurement with the committed table.

use anyhow::{Result, ensure};

use crate::table::{Row, Table, as_f64};

/// Largest change of a figure, up or down, per cent: counts of one compiler repeat exactly, but linked code moves a
/// little with every change.
pub(crate) const SAME_COMPILER: u64 = 3;

/// The same for another compiler: between 1.95.0 and 1.96.0, figures moved by up to 35 %.
pub(crate) const OTHER_COMPILER: u64 = 40;

/// Changes that are too small for a bound in per cent, instructions or bytes.
const SLACK: u64 = 4;

/// The bound of the check.
///
/// # Errors
/// If another compiler wrote the table, unless it is `allowed`.
pub(crate) fn bound(committed: &Table, measured: &Table, allowed: bool) -> Result<u64> {
    let [theirs, ours] = [&committed.compiler, &measured.compiler];
    ensure!(
        allowed || theirs == ours,
        "rustc {theirs} wrote the table, and rustc {ours} built the programs; --other-compiler allows \
         {OTHER_COMPILER} %"
    );
    Ok(if theirs == ours { SAME_COMPILER } else { OTHER_COMPILER })
}

/// Figures beyond the bound, missing or new, in the order of the tables.
///
/// * `committed`: the rows of the measured builds.
pub(crate) fn changes(committed: &[Row], measured: &[Row], percent: u64) -> Vec<String> {
    let find = |rows: &[Row], row: &Row| {
        rows.iter().find(|other| other.key == row.key).map(|other| other.value)
    };
    let change = |row: &Row| {
        let (key, before) = (row.key.join(", "), row.value);
        let Some(now) = find(measured, row) else { return Some(format!("gone: {key}: {before}")) };
        let moved = before.abs_diff(now);
        let beyond = moved > SLACK && moved * 100 > before * percent;
        let change = (as_f64(now) / as_f64(before) - 1.0) * 100.0;
        let word = if now > before { "worse" } else { "better" };
        beyond.then(|| format!("{word}: {key}: {before} -> {now} ({change:+.1} %)"))
    };
    let new = measured.iter().filter(|row| find(committed, row).is_none());
    let new = new.map(|row| format!("new: {}: {}", row.key.join(", "), row.value));
    committed.iter().filter_map(change).chain(new).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(what: &str, value: u64) -> Row {
        Row::new(["m4f", "f32", "3", what], "instructions", value)
    }

    fn reported(committed: &[Row], measured: &[Row]) -> Vec<String> {
        changes(committed, measured, SAME_COMPILER)
    }

    #[test]
    fn three_per_cent_pass_and_more_does_not_in_either_direction() {
        assert_eq!(reported(&[row("fuse", 1000)], &[row("fuse", 1030)]), [""; 0]);
        assert_eq!(
            reported(
                &[row("fuse", 1000), row("push", 1000)],
                &[row("fuse", 1031), row("push", 500)]
            ),
            [
                "worse: m4f, f32, 3, fuse: 1000 -> 1031 (+3.1 %)",
                "better: m4f, f32, 3, push: 1000 -> 500 (-50.0 %)"
            ]
        );
    }

    #[test]
    fn a_small_figure_may_move_by_the_slack() {
        assert_eq!(reported(&[row("undo", 8)], &[row("undo", 12)]), [""; 0]);
        assert_eq!(reported(&[row("undo", 8)], &[row("undo", 13)]).len(), 1);
    }

    #[test]
    fn a_figure_that_is_gone_or_new_is_reported() {
        assert_eq!(
            reported(&[row("push", 1)], &[row("fuse", 2)]),
            ["gone: m4f, f32, 3, push: 1", "new: m4f, f32, 3, fuse: 2"]
        );
    }

    #[test]
    fn another_compiler_fails_unless_it_is_allowed() {
        let [old, new] =
            ["1.96.0", "1.97.0"].map(|v| Table { compiler: v.into(), rows: vec![row("fuse", 1)] });
        assert_eq!(bound(&old, &old, false).unwrap(), SAME_COMPILER);
        assert_eq!(bound(&old, &old, true).unwrap(), SAME_COMPILER);
        assert_eq!(bound(&old, &new, true).unwrap(), OTHER_COMPILER);
        let said = bound(&old, &new, false).unwrap_err().to_string();
        assert!(said.contains("1.96.0") && said.contains("--other-compiler"), "{said}");
    }
}
