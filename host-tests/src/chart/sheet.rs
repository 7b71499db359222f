//! What the pictures have in common: colours, fonts, legends, and the file.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

pub(crate) const GREY: RGBColor = RGBColor(120, 120, 120);
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const ORANGE: RGBColor = RGBColor(213, 94, 0);

/// Height of heading and legend, radius of a dot: px.
const HEAD: u32 = 80;
pub(crate) const DOT: u32 = 3;

/// Opacities of areas and dots, and of grid lines.
pub(crate) const FILL: f64 = 0.5;
pub(crate) const GRID: f64 = 0.15;

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Writes a picture; folders on the way are created, an older file is replaced.
pub(crate) fn write(path: &Path, svg: &str) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    }
    fs::write(path, svg).with_context(|| format!("cannot write {}", path.display()))
}

pub(crate) fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK)
}

/// How a series is drawn, as its legend shows it.
#[derive(Clone, Copy)]
pub(crate) enum Mark {
    Bars,
    Dots,
    Line,
    Dashes,
}

/// An entry of a legend.
pub(crate) type Entry = (Mark, RGBColor, String);

/// Heading and legend, column by column, over a panel; returns what is left for the chart.
///
/// The legend of the plotting library lies on the data and guesses the width of its text.
pub(crate) fn headed<'a>(
    area: &Area<'a>,
    heading: &str,
    legend: &[Vec<Entry>],
) -> Result<Area<'a>> {
    let (head, chart) = area.split_vertically(HEAD);
    let middle = i32::try_from(head.dim_in_pixel().0)? / 2;
    let centred = font(15).pos(Pos::new(HPos::Center, VPos::Top));
    head.draw(&Text::new(heading.to_owned(), (middle, 4), centred))?;
    for (column, x) in legend.iter().zip((70..).step_by(205)) {
        for (entry, y) in column.iter().zip((34..).step_by(17)) {
            draw_entry(&head, entry, (x, y))?;
        }
    }
    Ok(chart)
}

/// A legend in one line.
///
/// * `lefts`: where each entry begins; `y`: the middle of the line. Px.
pub(crate) fn legend(area: &Area<'_>, entries: &[Entry], lefts: &[i32], y: i32) -> Result<()> {
    entries.iter().zip(lefts).try_for_each(|(entry, &x)| draw_entry(area, entry, (x, y)))
}

fn draw_entry(area: &Area<'_>, (mark, color, label): &Entry, (x, y): (i32, i32)) -> Result<()> {
    mark.draw(area, *color, (x, y))?;
    let beside = font(13).pos(Pos::new(HPos::Left, VPos::Center));
    area.draw(&Text::new(label.clone(), (x + 27, y), beside))?;
    Ok(())
}

pub(crate) fn chart_on<'a, 'b>(area: &'a Area<'b>) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
    let mut chart = ChartBuilder::on(area);
    chart.margin(10).x_label_area_size(40).y_label_area_size(55);
    chart
}

impl Mark {
    /// Draws a sample, 20 px wide; `x`, `y` is the middle of its left side.
    pub(crate) fn draw(self, area: &Area<'_>, color: RGBColor, (x, y): (i32, i32)) -> Result<()> {
        let line = |parts: &[[i32; 2]], width: u32| {
            parts.iter().try_for_each(|ends| {
                area.draw(&PathElement::new(ends.map(|x| (x, y)), color.stroke_width(width)))
            })
        };
        match self {
            Self::Bars => {
                let corners = [(x, y - 5), (x + 20, y + 5)];
                area.draw(&Rectangle::new(corners, color.mix(FILL).filled()))?;
                area.draw(&Rectangle::new(corners, color.stroke_width(1)))?;
            }
            Self::Dots => area.draw(&Circle::new((x + 10, y), DOT, color.mix(FILL).filled()))?,
            Self::Line => line(&[[x, x + 20]], 2)?,
            Self::Dashes => line(&[[x, x + 5], [x + 8, x + 13], [x + 16, x + 21]], 1)?,
        }
        Ok(())
    }
}
