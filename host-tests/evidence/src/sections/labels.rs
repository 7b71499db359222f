//! Names of methods and views.

use crate::on_recorded::Row;
use crate::rivals::Variant;

/// A method in a legend or a heading.
pub(super) fn label(method: &str) -> String {
    match method {
        "robust" => "robust (ours)".into(),
        "ling-shen" => "ling-shen [7]".into(),
        other => other.into(),
    }
}

/// A method with its settings.
pub(super) fn named(by: &Variant) -> String {
    format!("{}: {}", label(by.method.name()), by.tuning.words())
}

/// A data set, the turned camera, and its direction.
pub(super) fn cell(row: &Row<'_>) -> String {
    format!("{}, {}", row.set.name, row.seen.words())
}
