//! Charts of the page: curves and bars, errors on a logarithmic axis.
//!
//! Drawn small, black on nothing, so that they are legible on a phone and on a dark page; their legend
//! stands beside them, in the page.

mod axis;
pub mod palette;
pub(crate) mod sheet;

use anyhow::Result;
use plotters::prelude::*;

use axis::Axis;

const SIZE: (u32, u32) = (480, 330);

/// Curves of more points than this are drawn without dots.
const FEW_POINTS: usize = 20;

/// Share of a group's width that its bars take, and of a bar's place that the bar takes.
const FILLED: [f64; 2] = [0.84, 0.88];

/// What is varied.
#[derive(Debug, Clone)]
pub struct Scale {
    /// What it is, with its unit.
    pub name: String,
    /// Whether its axis is logarithmic.
    pub log: bool,
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// Broad, over the others.
    Broad,
    /// Thin.
    Thin,
    /// Broken, and without dots.
    Broken,
}

/// A curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Black if none.
    pub color: Option<palette::Color>,
    /// How it is drawn.
    pub line: Line,
    /// In the order of `x`; what is not a positive number is a gap.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Bars of one series, one of each group; a cross where there is none.
#[derive(Debug, Clone)]
pub struct Bars {
    /// Of the series.
    pub color: palette::Color,
    /// Heights, group by group.
    pub heights: Vec<Option<f64>>,
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

/// Curves over one scale, on a logarithmic axis.
///
/// # Errors
/// If the plotting library fails.
pub fn curves(title: &str, x: &Scale, curves: &[Curve]) -> Result<String> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let xs = points().map(|(x, _)| *x);
    let x_axis = if x.log { Axis::log(xs) } else { Axis::linear(xs) };
    let y_axis = Axis::log(points().filter_map(|(_, y)| *y));
    draw(title, &x.name, [&x_axis, &y_axis], |chart| {
        let mut order: Vec<&Curve> = curves.iter().collect();
        order.sort_by_key(|curve| curve.line == Line::Broad);
        order.into_iter().try_for_each(|curve| draw_curve(chart, curve, &y_axis))
    })
}

fn draw_curve(chart: &mut Chart<'_, '_>, curve: &Curve, axis: &Axis) -> Result<()> {
    let color = curve.color.map_or(BLACK, |color| color.light);
    let shown = |(x, y): &(f64, Option<f64>)| Some((*x, y.filter(|&y| axis.shows(y))?));
    let points: Vec<Option<(f64, f64)>> = curve.points.iter().map(shown).collect();
    for run in points.split(Option::is_none) {
        let run: Vec<(f64, f64)> = run.iter().flatten().copied().collect();
        let width = if curve.line == Line::Broad { 3 } else { 1 };
        if curve.line == Line::Broken {
            chart.draw_series(DashedLineSeries::new(run, 6, 4, color.stroke_width(2)))?;
            continue;
        }
        if points.len() <= FEW_POINTS {
            chart.draw_series(run.iter().map(|&at| Circle::new(at, width + 1, color.filled())))?;
        }
        chart.draw_series(LineSeries::new(run, color.stroke_width(width)))?;
    }
    Ok(())
}

/// Bars in groups, on a logarithmic axis.
///
/// # Errors
/// If the plotting library fails.
pub fn bars(title: &str, groups: &[&str], series: &[Bars]) -> Result<String> {
    let count = |n: usize| u32::try_from(n).map(f64::from);
    let heights = series.iter().flat_map(|bars| bars.heights.iter().flatten().copied());
    let y_axis = Axis::decades(heights);
    let [of_group, of_bar] = FILLED;
    let width = of_group / count(series.len().max(1))?;
    draw(title, "", [&Axis::groups(groups), &y_axis], |chart| {
        for (i, bars) in series.iter().enumerate() {
            for (group, height) in bars.heights.iter().enumerate() {
                let left = count(group)? + (1.0 - of_group) / 2.0 + count(i)? * width;
                let Some(top) = height.filter(|&y| y_axis.shows(y)) else {
                    let middle = left + of_bar * width / 2.0;
                    let cross =
                        Cross::new((middle, y_axis.floor()), 4, bars.color.light.stroke_width(2));
                    chart.draw_series([cross])?;
                    continue;
                };
                let corners = [(left, y_axis.floor()), (left + of_bar * width, top)];
                chart.draw_series([Rectangle::new(corners, bars.color.light.filled())])?;
            }
        }
        Ok(())
    })
}

fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK)
}

fn draw(
    title: &str,
    x_name: &str,
    [x, y]: [&Axis; 2],
    series: impl FnOnce(&mut Chart<'_, '_>) -> Result<()>,
) -> Result<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin(6)
            .margin_right(14)
            .caption(title, font(18))
            .x_label_area_size(if x_name.is_empty() { 28 } else { 46 })
            .y_label_area_size(58)
            .build_cartesian_2d(x.clone(), y.clone())?;
        let mut mesh = chart.configure_mesh();
        if x_name.is_empty() {
            mesh.disable_x_mesh();
        }
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.13))
            .axis_style(BLACK.mix(0.5))
            .x_desc(x_name)
            .label_style(font(16))
            .axis_desc_style(font(17))
            .draw()?;
        series(&mut chart)?;
        root.present()?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_one_point_gaps_and_zeros_are_drawn_all_the_same() {
        let x = Scale { name: "x".into(), log: true };
        let curve = |points| Curve { color: None, line: Line::Thin, points };
        for points in [
            vec![],
            vec![(1.0, Some(0.1))],
            vec![(1.0, Some(0.1)), (2.0, None), (3.0, Some(0.0)), (4.0, Some(0.2))],
        ] {
            let svg = curves("title", &x, &[curve(points)]).unwrap();
            assert!(svg.contains("title") && svg.ends_with("</svg>\n"));
        }
        assert!(bars("bars", &[], &[]).unwrap().contains("bars"));
    }
}
