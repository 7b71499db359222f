//! Progress of long work: a bar on a terminal, nothing elsewhere.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over pairs.
///
/// # Panics
/// Never: the template is a constant.
#[must_use]
pub fn over_pairs(pairs: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} pairs, {eta} left")
        .expect("a valid template");
    ProgressBar::new(pairs as u64).with_style(style)
}
