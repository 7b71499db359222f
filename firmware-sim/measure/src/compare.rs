//! Compares a measurement with a committed table.

use std::fmt;

use crate::table::{Row, Table};

/// Largest change of figures, up or down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bound {
    /// Per cent of the committed figure.
    pub(crate) percent: u32,
    /// Instructions or bytes, for small figures.
    slack: u64,
}

impl Bound {
    /// Same compiler: counts repeat exactly, but linked code moves a little with every change.
    pub(crate) const SAME: Self = Self { percent: 3, slack: 4 };

    /// Another compiler version: between 1.95.0 and 1.96.0, figures moved by up to 35 %.
    pub(crate) const OTHER: Self = Self { percent: 40, slack: 64 };

    fn holds(self, before: u64, now: u64) -> bool {
        let moved = before.abs_diff(now);
        moved <= self.slack || moved * 100 <= before * u64::from(self.percent)
    }
}

/// The bound for figures of one compiler against those of another.
pub(crate) fn bound(committed: &Table, measured: &Table) -> Bound {
    if committed.compiler == measured.compiler { Bound::SAME } else { Bound::OTHER }
}

/// A figure beyond its bound, missing or new.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Change {
    key: String,
    before: Option<u64>,
    now: Option<u64>,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.before, self.now) {
            (Some(before), Some(now)) => {
                let percent = (as_f64(now) / as_f64(before) - 1.0) * 100.0;
                let word = if now > before { "worse" } else { "better" };
                write!(f, "{word}: {}: {before} -> {now} ({percent:+.1} %)", self.key)
            }
            (Some(before), None) => write!(f, "gone: {}: {before}", self.key),
            (None, now) => write!(f, "new: {}: {}", self.key, now.unwrap_or(0)),
        }
    }
}

/// Figures beyond the bound, missing or new, in the order of the tables.
pub(crate) fn changes(committed: &[Row], measured: &[Row], bound: Bound) -> Vec<Change> {
    let find = |rows: &[Row], row: &Row| {
        rows.iter().find(|other| other.key() == row.key()).map(|other| other.value)
    };
    let change = |row: &Row, before, now| Change { key: row.key().join(", "), before, now };
    let changed = committed.iter().filter_map(|row| {
        let now = find(measured, row);
        let moved = now.is_none_or(|now| !bound.holds(row.value, now));
        moved.then(|| change(row, Some(row.value), now))
    });
    let new = measured.iter().filter(|row| find(committed, row).is_none());
    changed.chain(new.map(|row| change(row, None, Some(row.value)))).collect()
}

#[expect(clippy::cast_precision_loss, reason = "figures are far below 2^52")]
fn as_f64(value: u64) -> f64 {
    value as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::row;

    fn reported(committed: &[Row], measured: &[Row]) -> Vec<String> {
        changes(committed, measured, Bound::SAME).iter().map(Change::to_string).collect()
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
    fn figures_of_another_compiler_have_the_wider_bound() {
        let of = |compiler: &str, value| Table {
            compiler: compiler.parse().unwrap(),
            rows: vec![row("fuse", value)],
        };
        let failing = |committed: &Table, measured: &Table| {
            changes(&committed.rows, &measured.rows, bound(committed, measured)).len()
        };
        assert_eq!(failing(&of("1.96.0", 1000), &of("1.96.0", 1100)), 1);
        assert_eq!(failing(&of("1.96.0", 1000), &of("1.97.0-nightly", 1400)), 0);
        assert_eq!(failing(&of("1.96.0", 1000), &of("1.97.0-nightly", 1401)), 1);
    }
}
