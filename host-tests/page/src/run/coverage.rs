//! Coverage of the images by matches. In areas without matches a run does not test the lens.

use stereo_selfcal::Scalar;

use super::Replayed;
use crate::chart::palette::{Rgb, viridis};
use crate::chart::{Style, Svg};
use crate::report::{Csv, Figure, Picture, Section};
use rigs::data::Match;

/// Cells across the image.
const COLUMNS: u16 = 24;

/// Width of the picture, px; its height follows from the shape of the image.
const WIDTH: f64 = 480.0;

/// Counts of matches in square cells.
struct Cells {
    /// Edge of a cell, px of the image.
    edge: f64,
    rows: u16,
    /// Row by row.
    counts: Vec<u32>,
}

impl Cells {
    fn of([width, height]: [u16; 2], points: impl Iterator<Item = [f64; 2]>) -> Self {
        let edge = f64::from(width) / f64::from(COLUMNS);
        let rows = (f64::from(height) / edge).ceil().to_u16().max(1);
        let mut counts = vec![0; usize::from(COLUMNS) * usize::from(rows)];
        for point in points {
            // The image begins half a pixel before the centre of its first pixel.
            let [column, row] = point.map(|x| ((x + 0.5) / edge).to_u16());
            let cell =
                usize::from(row) * usize::from(COLUMNS) + usize::from(column.min(COLUMNS - 1));
            if let Some(count) = counts.get_mut(cell) {
                *count += 1;
            }
        }
        Self { edge, rows, counts }
    }

    fn most(&self) -> u32 {
        self.counts.iter().copied().max().unwrap_or(0)
    }

    fn places(&self) -> impl Iterator<Item = ([u16; 2], u32)> {
        let places = (0..self.rows).flat_map(|row| (0..COLUMNS).map(move |column| [column, row]));
        places.zip(self.counts.iter().copied())
    }

    /// The picture of the cells; those without a match are left empty. A cell of `most` matches is brightest.
    fn svg(&self, [width, height]: [u16; 2], most: u32) -> String {
        let [right, bottom] = [width, height].map(f64::from);
        let scale = WIDTH / right.max(1.0);
        let mut svg = Svg::new([WIDTH, bottom * scale]);
        for ([column, row], count) in self.places().filter(|(_, count)| *count > 0) {
            let color = viridis((f64::from(count) / f64::from(most)).sqrt());
            let at = |x: u16, limit: f64| (f64::from(x) * self.edge).min(limit) * scale;
            let field = [
                [at(column, right), at(row, bottom)],
                [at(column + 1, right), at(row + 1, bottom)],
            ];
            svg.rectangle(field, Style::filled(color));
        }
        let frame = [[0.0, 0.0], [WIDTH, bottom * scale]];
        svg.rectangle(frame, Style::line(Rgb::BLACK, 1.0).opacity(0.5));
        svg.finish()
    }
}

pub(super) fn section(replayed: &Replayed<'_>) -> Section {
    let meta = &replayed.set.meta;
    let sizes = meta.sizes();
    let matches = || replayed.set.pairs.iter().flatten();
    let cells = |side: usize, of: fn(&Match) -> [f64; 2]| Cells::of(sizes[side], matches().map(of));
    let both = [("left", cells(0, |m| [m.ul, m.vl])), ("right", cells(1, |m| [m.ur, m.vr]))];
    let most = both.iter().map(|(_, cells)| cells.most()).max().unwrap_or(0);
    let mut numbers = Csv::new("coverage", &["image", "column", "row", "matches"]);
    let mut panels = Vec::new();
    for ((side, cells), size) in both.iter().zip(sizes) {
        for ([column, row], count) in cells.places() {
            let cell = [(*side).to_owned(), column.to_string(), row.to_string(), count.to_string()];
            numbers.push(cell);
        }
        panels.push((Picture::Svg(cells.svg(size, most)), format!("matches in the {side} image")));
    }
    let edge = both[0].1.edge;
    let mut section = Section::new("Coverage");
    section.figure(Figure {
        panels,
        legend: Vec::new(),
        caption: format!(
            "All matches of all pairs, false ones included, in cells of {edge:.0} px; left image and right image. \
             Empty: no match; yellow: {most}, the largest count; the colour follows the root of the count."
        ),
        command: replayed.command.to_owned(),
        numbers,
    });
    section
}
