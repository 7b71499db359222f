//! Colours of the series, each with a twin for a dark page.
//!
//! The first six are Okabe and Ito's, told apart by colour-blind readers too.

use plotters::style::RGBColor;

/// A colour of pictures, on a light page and on a dark one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color {
    /// As pictures are drawn.
    pub light: RGBColor,
    /// What it becomes on a dark page.
    pub dark: RGBColor,
}

const fn color(light: [u8; 3], dark: [u8; 3]) -> Color {
    let [r, g, b] = light;
    let [dark_r, dark_g, dark_b] = dark;
    Color { light: RGBColor(r, g, b), dark: RGBColor(dark_r, dark_g, dark_b) }
}

/// Series in the order of their use.
pub const SERIES: [Color; 10] = [
    color([0, 114, 178], [86, 170, 230]),
    color([213, 94, 0], [255, 140, 70]),
    color([0, 158, 115], [40, 200, 155]),
    color([204, 121, 167], [232, 160, 204]),
    color([230, 159, 0], [245, 190, 70]),
    color([86, 180, 233], [150, 212, 250]),
    color([130, 90, 60], [196, 152, 120]),
    color([120, 120, 120], [165, 165, 165]),
    color([140, 140, 0], [200, 200, 60]),
    color([110, 70, 180], [170, 140, 235]),
];

/// The colour of a series, round and round.
#[must_use]
pub fn series(i: usize) -> Color {
    SERIES[i % SERIES.len()]
}

/// `#RRGGBB`, as the plotting library writes it.
#[must_use]
pub fn hex(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// What a series is called in the style sheet of the page.
#[must_use]
pub(crate) fn variable(i: usize) -> String {
    format!("--s{i}")
}

/// The variables of all series, for one scheme of the page.
#[must_use]
pub(crate) fn variables(of: impl Fn(&Color) -> RGBColor) -> String {
    let all = SERIES.iter().enumerate();
    let all: Vec<String> =
        all.map(|(i, color)| format!("{}:{}", variable(i), hex(of(color)))).collect();
    all.join(";")
}
