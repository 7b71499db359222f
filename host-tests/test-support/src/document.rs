//! Documents in markdown.

/// Code spans outside of blocks, and the lines of shell blocks; continued lines are joined.
#[must_use]
pub fn code(document: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (i, part) in document.split("```").enumerate() {
        if i % 2 == 0 {
            let spans = part.split("\n\n").flat_map(|block| block.split('`').skip(1).step_by(2));
            found.extend(spans.map(|span| span.split_whitespace().collect::<Vec<_>>().join(" ")));
        } else if let Some(shell) = part.strip_prefix("sh\n") {
            found.extend(shell.replace("\\\n", "").lines().map(str::to_owned));
        }
    }
    found
}
