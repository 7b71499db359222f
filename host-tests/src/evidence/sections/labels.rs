//! How methods are named and drawn.

use crate::chart::curves::Line;

/// A method in a legend or a heading.
pub(super) fn label(method: &str) -> String {
    match method {
        "robust" => "robust (ours)".into(),
        "ling-shen" => "ling-shen [7]".into(),
        other => other.into(),
    }
}

/// The presets stand out.
pub(super) fn line(method: &str) -> Line {
    if ["robust", "paper"].contains(&method) { Line::Broad } else { Line::Thin }
}
