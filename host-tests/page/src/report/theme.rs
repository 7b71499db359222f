//! Colours of the series as variables of the page's style sheet, for a light and a dark scheme.

use crate::chart::palette::{Color, Rgb, SERIES};

/// Name of a series in the style sheet of the page.
pub(super) fn variable(i: usize) -> String {
    format!("--s{i}")
}

/// The variables of all series, for one scheme of the page.
pub(super) fn variables(of: impl Fn(&Color) -> Rgb) -> String {
    let all = SERIES.iter().enumerate();
    let all: Vec<String> =
        all.map(|(i, color)| format!("{}:{}", variable(i), of(color).hex())).collect();
    all.join(";")
}
