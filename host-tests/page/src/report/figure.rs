//! Figures: pictures side by side under one legend.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{Markup, PreEscaped, html};

use super::inline::{inline, variable};
use super::numbers::Csv;
use crate::chart::legend::Mark;
use crate::chart::palette::{Color, SERIES};

/// Largest number of panels in full size; more are drawn as small multiples.
const FEW_PANELS: usize = 4;

/// A picture, encoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Picture {
    /// Text of an SVG file, drawn in black on white or on nothing, series in [`SERIES`].
    Svg(String),
    /// Bytes of a PNG file.
    Png(Vec<u8>),
    /// Bytes of a JPEG file.
    Jpeg(Vec<u8>),
}

/// One series in a legend.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// How it is drawn.
    pub mark: Mark,
    /// One of [`SERIES`], or black.
    pub color: Option<Color>,
    /// Its name.
    pub name: String,
}

/// Pictures with their explanation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// Pictures with their descriptions.
    pub panels: Vec<(Picture, String)>,
    /// Legend of all panels; may be empty.
    pub legend: Vec<Entry>,
    /// Description and origin.
    pub caption: String,
    /// The command that makes it.
    pub command: String,
    /// Its numbers.
    pub numbers: Csv,
}

impl Entry {
    /// An entry in one of the series' colours; black for `None`.
    pub fn new(mark: Mark, color: Option<Color>, name: &str) -> Self {
        Self { mark, color, name: name.to_owned() }
    }

    fn markup(&self) -> Markup {
        let number = SERIES.iter().position(|color| Some(*color) == self.color);
        let color = match (number, self.color) {
            (Some(i), _) => format!("var({})", variable(i)),
            (None, Some(color)) => color.light.hex(),
            (None, None) => "currentColor".into(),
        };
        let class = match self.mark {
            Mark::Line => "line",
            Mark::Dashes => "dashes",
            Mark::Dots => "dots",
            Mark::Bars => "bar",
        };
        html! { li { i class=(class) style=(format!("color:{color}")) {} (self.name) } }
    }
}

impl Picture {
    fn markup(&self, label: &str) -> Markup {
        let data = |kind: &str, bytes: &[u8]| {
            let source = format!("data:image/{kind};base64,{}", BASE64_STANDARD.encode(bytes));
            html! { img src=(source) alt=(label); }
        };
        match self {
            Self::Svg(text) => PreEscaped(inline(text, label)),
            Self::Png(bytes) => data("png", bytes),
            Self::Jpeg(bytes) => data("jpeg", bytes),
        }
    }
}

impl Figure {
    pub(super) fn markup(&self) -> Markup {
        html! {
            @if !self.legend.is_empty() {
                ul.legend { @for entry in &self.legend { (entry.markup()) } }
            }
            div.panels.many[self.panels.len() > FEW_PANELS] {
                @for (picture, label) in &self.panels {
                    div.panel {
                        (picture.markup(label))
                        @if !matches!(picture, Picture::Svg(_)) { p.label { (label) } }
                    }
                }
            }
        }
    }
}
