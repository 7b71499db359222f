//! Legends of stand-alone pictures.

use super::palette::Rgb;
use super::svg::{Anchor, Point, Style, Svg};

/// Opacity of filled shapes and of dots.
pub const FILL: f64 = 0.5;

/// Radius of a dot, px.
pub const DOT: f64 = 3.0;

/// Font size, px.
const TEXT: f64 = 12.0;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Filled areas with an outline.
    Bars,
    /// Dots.
    Dots,
    /// A line.
    Line,
    /// A dashed line.
    Dashes,
}

/// A series in a legend.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// How it is drawn.
    pub mark: Mark,
    /// Its colour.
    pub color: Rgb,
    /// Its name.
    pub words: String,
}

impl Key {
    /// The key of a series.
    pub fn new(mark: Mark, color: Rgb, words: impl Into<String>) -> Self {
        Self { mark, color, words: words.into() }
    }

    /// Draws a sample and the words; `x`, `y` is the middle of the left side, px.
    pub fn draw(&self, svg: &mut Svg, [x, y]: Point) {
        let Self { mark, color, words } = self;
        let ends = [[x, y], [x + 20.0, y]];
        match mark {
            Mark::Bars => {
                let corners = [[x, y - 5.0], [x + 20.0, y + 5.0]];
                svg.rectangle(corners, Style::filled(*color).opacity(FILL));
                svg.rectangle(corners, Style::line(*color, 1.0));
            }
            Mark::Dots => {
                svg.circle([x + 10.0, y], DOT, Style::filled(*color).opacity(FILL));
            }
            Mark::Line => svg.path(ends, Style::line(*color, 2.0)),
            Mark::Dashes => svg.path(ends, Style::line(*color, 1.0).dashed(5.0, 3.0)),
        }
        svg.text([x + 27.0, y], TEXT, Anchor::Start, words);
    }
}
