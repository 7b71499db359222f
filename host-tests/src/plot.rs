//! A run in one picture: row offsets before and after, and the error of the estimate over the pairs.

use std::fs;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result};
use plotters::coord::Shift;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

use crate::dataset::Dataset;
use crate::evaluation::{Evaluation, Step, row_offsets_px};

const SIZE: (u32, u32) = (1000, 460);
const GREY: RGBColor = RGBColor(120, 120, 120);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const BLUE: RGBColor = RGBColor(0, 114, 178);
const ORANGE: RGBColor = RGBColor(213, 94, 0);

/// Bins of the histogram; an even number, so that none straddles 0.
const BINS: u32 = 60;

/// Least half-width of the histogram, px.
const MIN_LIMIT_PX: f64 = 5.0;

/// Half-width of the histogram in medians of the offsets before: mismatches reach far beyond.
const LIMIT_IN_MEDIANS: f64 = 2.0;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Writes the picture as SVG; folders on the way are created, an older file is replaced.
///
/// Left: histograms of the row offsets of all matches, px, under the extrinsics that the run started
/// from and under the fused ones. Right: errors against the reference, degrees, of each pair and of
/// the running estimate, with the reference's own standard error where it is known.
///
/// # Errors
/// If the data set's cameras are not valid, or the file cannot be written.
pub fn write_svg(path: &Path, set: &Dataset, evaluation: &Evaluation) -> Result<()> {
    let svg = svg(set, evaluation)?;
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    }
    fs::write(path, svg).with_context(|| format!("cannot write {}", path.display()))
}

fn svg(set: &Dataset, evaluation: &Evaluation) -> Result<String> {
    let histogram = Histogram::of(set, evaluation)?;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let matches: usize = set.pairs.iter().map(Vec::len).sum();
        let title = format!("{}: {} pairs, {matches} matches", set.name, set.pairs.len());
        let (left, right) = root.titled(&title, font(20))?.split_horizontally(SIZE.0 / 2);
        draw_offsets(&left, &histogram)?;
        draw_errors(&right, set, evaluation.steps())?;
        root.present()?;
    }
    Ok(svg)
}

fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK)
}

/// Row offsets of all matches before and after, counted in bins of one width.
#[derive(Debug, PartialEq)]
struct Histogram {
    /// Half-width, px.
    limit: f64,
    before: Counts,
    /// `None` without an estimate.
    after: Option<Counts>,
}

#[derive(Debug, PartialEq)]
struct Counts {
    bins: Vec<u32>,
    /// Share of the offsets that no bin holds, 0 to 1.
    beyond: f64,
}

impl Histogram {
    fn of(set: &Dataset, evaluation: &Evaluation) -> Result<Self> {
        let offsets = |extrinsics| -> Result<Vec<f64>> {
            Ok(row_offsets_px(set, extrinsics)?.into_iter().flatten().flatten().collect())
        };
        let before = offsets(evaluation.factory())?;
        let after = evaluation.fused().map(|f| offsets(&f.extrinsics)).transpose()?;
        let limit = nice_limit(MIN_LIMIT_PX.max(LIMIT_IN_MEDIANS * median_size(&before)));
        let counts = |offsets: &[f64]| Counts::within(limit, offsets);
        Ok(Self { limit, before: counts(&before), after: after.as_deref().map(counts) })
    }

    fn highest(&self) -> u32 {
        let all = self.before.bins.iter().chain(self.after.iter().flat_map(|after| &after.bins));
        all.copied().max().unwrap_or(0)
    }
}

impl Counts {
    fn within(limit: f64, offsets: &[f64]) -> Self {
        let width = 2.0 * limit / f64::from(BINS);
        let edges = |i: u32| f64::from(i) * width - limit..f64::from(i + 1) * width - limit;
        let count = |bin: Range<f64>| offsets.iter().filter(|x| bin.contains(x)).count() as u32;
        let bins: Vec<u32> = (0..BINS).map(|i| count(edges(i))).collect();
        let held: u32 = bins.iter().sum();
        let all = offsets.len().max(1) as f64;
        Self { bins, beyond: (offsets.len() as f64 - f64::from(held)) / all }
    }

    /// The outline of the bars, closed by the axis.
    fn outline(&self, limit: f64) -> Vec<(f64, u32)> {
        let width = 2.0 * limit / f64::from(BINS);
        let mut x = -limit;
        let mut points = vec![(x, 0)];
        for &count in &self.bins {
            points.extend([(x, count), (x + width, count)]);
            x += width;
        }
        points.push((x, 0));
        points
    }
}

/// Median of the absolute values; 0 of none.
fn median_size(offsets: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = offsets.iter().map(|x| x.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
}

/// The next of 5, 10, 20, 50, 100 and so on.
fn nice_limit(px: f64) -> f64 {
    let decade = 10_f64.powf(px.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|step| step * decade).into_iter().find(|&limit| limit >= px).unwrap_or(px)
}

fn draw_offsets(area: &Area<'_>, histogram: &Histogram) -> Result<()> {
    let limit = histogram.limit;
    let top = histogram.highest().max(1) * 5 / 4;
    let mut chart = ChartBuilder::on(area)
        .caption("Row offset of all matches after rectification", font(15))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(55)
        .build_cartesian_2d(-limit..limit, 0..top)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("row offset, px")
        .y_desc("matches per bin")
        .label_style(font(13))
        .axis_desc_style(font(14))
        .draw()?;
    let after = histogram.after.iter().map(|after| ("after", after, GREEN));
    for (name, counts, color) in [("before", &histogram.before, GREY)].into_iter().chain(after) {
        let outline = counts.outline(limit);
        let label = format!("{name} ({:.1} % beyond {limit} px)", 100.0 * counts.beyond);
        chart.draw_series([Polygon::new(outline.clone(), color.mix(0.4))])?;
        chart
            .draw_series([PathElement::new(outline, color)])?
            .label(label)
            .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 16, y + 5)], color.filled()));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .label_font(font(13))
        .draw()?;
    Ok(())
}
