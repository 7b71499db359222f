//! A measurement against the committed one.

use std::fmt;

use crate::table::Row;

/// A figure may move by this share.
const MARGIN: f64 = 0.03;

/// Or by so much, where it is small.
const SLACK: u64 = 4;

/// What has changed of one figure.
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

/// What is beyond the margin, gone or new, in the order of the tables.
pub(crate) fn changes(committed: &[Row], measured: &[Row]) -> Vec<Change> {
    let find = |rows: &[Row], row: &Row| {
        rows.iter().find(|other| other.key() == row.key()).map(|other| other.value)
    };
    let change = |row: &Row, before, now| Change { key: row.key().join(", "), before, now };
    let changed = committed.iter().filter_map(|row| {
        let now = find(measured, row);
        let moved = now.is_none_or(|now| is_beyond(row.value, now));
        moved.then(|| change(row, Some(row.value), now))
    });
    let new = measured.iter().filter(|row| find(committed, row).is_none());
    changed.chain(new.map(|row| change(row, None, Some(row.value)))).collect()
}

fn is_beyond(before: u64, now: u64) -> bool {
    let moved = before.abs_diff(now);
    moved > SLACK && as_f64(moved) > as_f64(before) * MARGIN
}

#[expect(clippy::cast_precision_loss, reason = "figures are far below 2^52")]
fn as_f64(value: u64) -> f64 {
    value as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::row;

    fn told(committed: &[Row], measured: &[Row]) -> Vec<String> {
        changes(committed, measured).iter().map(Change::to_string).collect()
    }

    #[test]
    fn three_per_cent_pass_and_more_does_not_in_either_direction() {
        assert_eq!(told(&[row("fuse", 1000)], &[row("fuse", 1030)]), [""; 0]);
        assert_eq!(
            told(&[row("fuse", 1000), row("push", 1000)], &[row("fuse", 1031), row("push", 500)]),
            [
                "worse: m4f, f32, 3, fuse: 1000 -> 1031 (+3.1 %)",
                "better: m4f, f32, 3, push: 1000 -> 500 (-50.0 %)"
            ]
        );
    }

    #[test]
    fn a_small_figure_may_move_by_a_few() {
        assert_eq!(told(&[row("undo", 8)], &[row("undo", 12)]), [""; 0]);
        assert_eq!(told(&[row("undo", 8)], &[row("undo", 13)]).len(), 1);
    }

    #[test]
    fn a_figure_that_is_gone_or_new_is_told() {
        assert_eq!(
            told(&[row("push", 1)], &[row("fuse", 2)]),
            ["gone: m4f, f32, 3, push: 1", "new: m4f, f32, 3, fuse: 2"]
        );
    }
}
