//! Charts of a page: curves and bars, mostly on a logarithmic axis.
//!
//! The charts are small, so that they are legible on a phone. Their text is black on a transparent background; the page
//! replaces the colours, so that the charts are legible on a dark page too. The page has their legend.

use super::axis::Axis;
use super::palette::{Color, Rgb};
use super::plot::Plot;
use super::svg::{Anchor, Point, Style, Svg};

const SIZE: Point = [480.0, 330.0];

/// Margins of the axes: left, top, right, px.
const MARGINS: [f64; 3] = [64.0, 32.0, 14.0];

/// Heights below the axes, with a name and without, px.
const BELOW: [f64; 2] = [52.0, 32.0];

/// Sizes of the title and of all other words, px.
const TITLE: f64 = 15.0;
const TEXT: f64 = 13.0;

/// Largest number of points of a curve that is drawn with dots.
const FEW_POINTS: usize = 20;

/// Share of a group's width for its bars, and share of a bar's place for the bar.
const FILLED: [f64; 2] = [0.84, 0.88];

/// Colour of a series: 0 is this project's method, 1 the best rival, 2 a third series; then they repeat.
pub fn shade(i: usize) -> Color {
    super::palette::series([0, 1, 2][i % 3])
}

/// The horizontal axis.
#[derive(Debug, Clone)]
pub struct Scale {
    /// Its quantity, with the unit.
    pub name: String,
    /// Whether it is logarithmic.
    pub log: bool,
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// Broad, drawn over all other curves.
    Broad,
    /// Thin.
    Thin,
    /// Dashed, without dots.
    Broken,
}

/// A curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Colour; `None`: black.
    pub color: Option<Color>,
    /// How it is drawn.
    pub line: Line,
    /// Points in the order of `x`. A missing value is a gap, and on a logarithmic axis so is a value that is not
    /// positive.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Bars of one series, one for each group; a cross for a value that is missing or not positive.
#[derive(Debug, Clone)]
pub struct Bars {
    /// Colour of the series.
    pub color: Color,
    /// Heights, group by group.
    pub heights: Vec<Option<f64>>,
}

/// A chart of curves over one scale, with a logarithmic vertical axis.
pub fn curves(title: &str, x: &Scale, curves: &[Curve]) -> String {
    let values = curves.iter().flat_map(|curve| &curve.points).filter_map(|(_, y)| *y);
    drawn(title, x, curves, &Axis::log(values))
}

/// A chart of shares, 0 to 1, over one scale, with a linear vertical axis.
pub fn shares(title: &str, x: &Scale, curves: &[Curve]) -> String {
    drawn(title, x, curves, &Axis::linear([0.0, 1.0].into_iter()))
}

fn drawn(title: &str, x: &Scale, curves: &[Curve], y_axis: &Axis) -> String {
    let xs = curves.iter().flat_map(|curve| &curve.points).map(|(x, _)| *x);
    let x_axis = if x.log { Axis::log(xs) } else { Axis::linear(xs) };
    let mut svg = titled(title);
    let mut plot = framed(&mut svg, &x.name, [x_axis, y_axis.clone()]);
    let mut order: Vec<&Curve> = curves.iter().collect();
    order.sort_by_key(|curve| curve.line == Line::Broad);
    for curve in order {
        draw_curve(&mut plot, curve, y_axis);
    }
    svg.finish()
}

fn draw_curve(plot: &mut Plot<'_>, curve: &Curve, axis: &Axis) {
    let color = curve.color.map_or(Rgb::BLACK, |color| color.light);
    let shown = |(x, y): &(f64, Option<f64>)| Some([*x, y.filter(|&y| axis.shows(y))?]);
    let points: Vec<Option<Point>> = curve.points.iter().map(shown).collect();
    let width = if curve.line == Line::Broad { 3.0 } else { 1.0 };
    for run in points.split(Option::is_none) {
        let run = || run.iter().flatten().copied();
        if curve.line == Line::Broken {
            plot.line(run(), Style::line(color, 2.0).dashed(6.0, 4.0));
            continue;
        }
        if points.len() <= FEW_POINTS {
            plot.dots(run(), width + 1.0, Style::filled(color));
        }
        plot.line(run(), Style::line(color, width));
    }
}

/// A chart of bars in groups, with a logarithmic vertical axis.
pub fn bars(title: &str, groups: &[&str], series: &[Bars]) -> String {
    let heights = series.iter().flat_map(|bars| bars.heights.iter().flatten().copied());
    let y_axis = Axis::decades(heights);
    let floor = y_axis.floor();
    let [of_group, of_bar] = FILLED;
    let count = u32::try_from(series.len().max(1)).map_or(1.0, f64::from);
    let width = of_group / count;
    let mut svg = titled(title);
    let mut plot = framed(&mut svg, "", [Axis::groups(groups), y_axis.clone()]);
    for (i, bars) in (0_u32..).map(f64::from).zip(series) {
        let color = bars.color.light;
        for (group, height) in (0_u32..).map(f64::from).zip(&bars.heights) {
            let left = group + (1.0 - of_group) / 2.0 + i * width;
            if let Some(top) = height.filter(|&y| y_axis.shows(y)) {
                let corners = [[left, floor], [left + of_bar * width, top]];
                plot.rectangle(corners, Style::filled(color));
            } else {
                let middle = left + of_bar * width / 2.0;
                plot.cross([middle, floor], 4.0, Style::line(color, 2.0));
            }
        }
    }
    svg.finish()
}

fn titled(title: &str) -> Svg {
    let mut svg = Svg::new(SIZE);
    svg.text([SIZE[0] / 2.0, MARGINS[1] / 2.0], TITLE, Anchor::Middle, title);
    svg
}

/// Axes with grid and labels. A horizontal axis without a name has groups, and gets no grid lines.
fn framed<'a>(svg: &'a mut Svg, name: &str, axes: [Axis; 2]) -> Plot<'a> {
    let [left, top, right] = MARGINS;
    let below = BELOW[usize::from(name.is_empty())];
    let mut plot = Plot::new(svg, [[left, top], [SIZE[0] - right, SIZE[1] - below]], axes);
    plot.frame(!name.is_empty());
    plot.label_x(name, TEXT);
    plot.label_y("", TEXT, 0.0);
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_of_no_point_one_point_gaps_and_zeros_are_drawn() {
        let x = Scale { name: "x".into(), log: true };
        let curve = |points| Curve { color: None, line: Line::Thin, points };
        for points in [
            vec![],
            vec![(1.0, Some(0.1))],
            vec![(1.0, Some(0.1)), (2.0, None), (3.0, Some(0.0)), (4.0, Some(0.2))],
        ] {
            let svg = curves("title", &x, &[curve(points)]);
            assert!(svg.contains("title") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
        assert!(bars("bars", &[], &[]).contains("bars"));
    }
}
