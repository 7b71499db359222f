//! Progress of long work: a bar on a terminal, nothing elsewhere.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over so many of a thing.
///
/// # Panics
/// Never: the template is a constant.
#[must_use]
pub fn over(count: usize, things: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}, {eta} left")
        .expect("a valid template");
    ProgressBar::new(count as u64).with_style(style).with_message(things)
}
