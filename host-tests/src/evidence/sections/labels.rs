//! How methods are named.

/// A method in a legend or a heading.
pub(super) fn label(method: &str) -> String {
    match method {
        "robust" => "robust (ours)".into(),
        "ling-shen" => "ling-shen [7]".into(),
        other => other.into(),
    }
}
