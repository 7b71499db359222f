//! Progress of long work: a bar on standard error if it is a terminal, and no output otherwise.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `count` items.
///
/// * `things`: name of the items, which follows the number.
pub fn over(count: usize, things: &str) -> ProgressBar {
    styled(ProgressBar::new(count as u64), "{bar:30} {pos}/{len} {msg}, {eta} left", things)
}

/// A count of items whose total is unknown.
pub fn counting(things: &str) -> ProgressBar {
    styled(ProgressBar::no_length(), "{pos} {msg}, {elapsed}", things)
}

fn styled(bar: ProgressBar, template: &str, things: &str) -> ProgressBar {
    let style =
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.with_style(style).with_message(things.to_owned())
}
