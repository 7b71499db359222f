//! Charts as SVG, without a plotting library.

mod axis;
pub mod curves;
pub mod legend;
pub mod palette;
mod plot;
mod svg;

pub use axis::Axis;
pub use plot::Plot;
pub use svg::{Anchor, Point, Style, Svg};
