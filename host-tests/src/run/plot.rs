//! A run in one picture: row offsets before and after, and the error of the estimate over the pairs.

use std::ops::Range;
use std::path::Path;

use anyhow::Result;
use plotters::prelude::*;
use stereo_selfcal::metrics::Deviation;

use super::log::{RunLog, Step};
use super::summary::row_offsets_px;
use crate::chart::sheet::{
    Area, BLUE, DOT, Entry, FILL, GREEN, GREY, GRID, Mark, ORANGE, chart_on, font, headed,
};
use crate::data::Dataset;

const SIZE: (u32, u32) = (1000, 460);
/// Bins of the histogram; an even number, so that none straddles 0.
const BINS: u32 = 60;

/// Least half-width of the histogram, px.
const MIN_LIMIT_PX: f64 = 5.0;

/// Half-width of the histogram in medians of the offsets before: mismatches reach far beyond.
const LIMIT_IN_MEDIANS: f64 = 2.0;

/// Decades that the error axis shows at most.
const MAX_DECADES: f64 = 6.0;

/// Writes the picture as SVG; folders on the way are created, an older file is replaced.
///
/// Left: histograms of the row offsets of all matches, px, under the extrinsics that the run started
/// from and under the fused ones. Right: errors against the reference, degrees, of each pair and of
/// the running estimate, with the reference's own standard error where it is known.
///
/// # Errors
/// If the data set's cameras are not valid, or the file cannot be written.
pub fn write_svg(path: &Path, set: &Dataset, log: &RunLog) -> Result<()> {
    crate::chart::sheet::write(path, &svg(set, log)?)
}

fn svg(set: &Dataset, log: &RunLog) -> Result<String> {
    let histogram = Histogram::of(set, log)?;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let matches: usize = set.pairs.iter().map(Vec::len).sum();
        let title = format!("{}, pairs: {}, matches: {matches}", set.name, set.pairs.len());
        let (left, right) = root.titled(&title, font(20))?.split_horizontally(SIZE.0 / 2);
        draw_offsets(&left, &histogram)?;
        draw_errors(&right, set, log.steps())?;
        root.present()?;
    }
    Ok(svg)
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
    fn of(set: &Dataset, log: &RunLog) -> Result<Self> {
        let offsets = |extrinsics| -> Result<Vec<f64>> {
            Ok(row_offsets_px(set, extrinsics)?.into_iter().flatten().flatten().collect())
        };
        let before = offsets(log.factory())?;
        let after = log.fused().map(|f| offsets(&f.extrinsics)).transpose()?;
        let limit = nice_limit(MIN_LIMIT_PX.max(LIMIT_IN_MEDIANS * median_size(&before)));
        let counts = |offsets: &[f64]| Counts::within(limit, offsets);
        let after = after.as_deref().map(counts).transpose()?;
        Ok(Self { limit, before: counts(&before)?, after })
    }

    fn highest(&self) -> u32 {
        let all = self.before.bins.iter().chain(self.after.iter().flat_map(|after| &after.bins));
        all.copied().max().unwrap_or(0)
    }
}

impl Counts {
    fn within(limit: f64, offsets: &[f64]) -> Result<Self> {
        let width = 2.0 * limit / f64::from(BINS);
        let edge = |i: u32| f64::from(i) * width - limit;
        let count = |i: u32| {
            let bin = edge(i)..edge(i + 1);
            offsets.iter().map(|x| u32::from(bin.contains(x))).sum()
        };
        let bins: Vec<u32> = (0..BINS).map(count).collect();
        let all = u32::try_from(offsets.len())?;
        let beyond = all - bins.iter().sum::<u32>();
        Ok(Self { bins, beyond: f64::from(beyond) / f64::from(all.max(1)) })
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
    [1.0, 2.0, 5.0, 10.0]
        .map(|step| step * decade)
        .into_iter()
        .find(|&limit| limit >= px)
        .unwrap_or(px)
}

fn draw_offsets(area: &Area<'_>, histogram: &Histogram) -> Result<()> {
    let limit = histogram.limit;
    let after = histogram.after.iter().map(|after| ("with the fused estimate", GREEN, after));
    let all: Vec<_> =
        [("as the run started", GREY, &histogram.before)].into_iter().chain(after).collect();
    let legend: Vec<_> = all
        .iter()
        .map(|(name, color, counts)| {
            let beyond = 100.0 * counts.beyond;
            (Mark::Bars, *color, format!("{name}; {beyond:.1} % of the matches beyond ±{limit} px"))
        })
        .collect();
    let area = headed(area, "Row offset after rectification", &[legend])?;
    let top = histogram.highest().max(1) * 11 / 10;
    let mut chart = chart_on(&area).build_cartesian_2d(-limit..limit, 0..top + 1)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(GRID))
        .x_desc("row offset, px")
        .x_label_formatter(&|x| format!("{x}"))
        .y_desc("matches per bin")
        .label_style(font(13))
        .axis_desc_style(font(14))
        .draw()?;
    for (_, color, counts) in all {
        let outline = counts.outline(limit);
        chart.draw_series([Polygon::new(outline.clone(), color.mix(FILL))])?;
        chart.draw_series([PathElement::new(outline, color)])?;
    }
    Ok(())
}

/// What is plotted of one of the two errors, degrees.
struct Curve {
    name: &'static str,
    color: RGBColor,
    singles: Vec<(u32, f64)>,
    running: Vec<(u32, f64)>,
    /// Standard error of the reference.
    reference: Option<f64>,
}

impl Curve {
    /// * `of`: picks the error out of a deviation, rad.
    fn new(
        name: &'static str,
        color: RGBColor,
        steps: &[Step],
        of: fn(&Deviation<f64>) -> f64,
        reference: Option<f64>,
    ) -> Self {
        let numbered = || (1_u32..).zip(steps);
        let degrees = |error: &Deviation<f64>| of(error).to_degrees();
        let singles = numbered().filter_map(|(i, s)| Some((i, degrees(&s.solved.as_ref()?.error))));
        let running = numbered().filter_map(|(i, s)| Some((i, degrees(s.running.as_ref()?))));
        Self { name, color, singles: singles.collect(), running: running.collect(), reference }
    }

    fn legend(&self) -> Vec<Entry> {
        let Self { name, color, .. } = *self;
        let drawn = [(Mark::Dots, "pair alone"), (Mark::Line, "all pairs so far")];
        let reference = self.reference.map(|_| (Mark::Dashes, "1 sigma of the reference"));
        let all = drawn.into_iter().chain(reference);
        all.map(|(mark, what)| (mark, color, format!("{name}, {what}"))).collect()
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.singles.iter().chain(&self.running).map(|(_, y)| *y).chain(self.reference)
    }
}

/// Whole decades around all positive values, at least one and at most [`MAX_DECADES`].
fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|y| *y > 0.0 && y.is_finite())
        .map(f64::log10)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    if low > high {
        return 0.1..1.0;
    }
    let high = high.floor() + 1.0;
    let low = low.floor().max(high - MAX_DECADES);
    10_f64.powf(low)..10_f64.powf(high)
}

fn draw_errors(area: &Area<'_>, set: &Dataset, steps: &[Step]) -> Result<()> {
    let curves = [
        Curve::new("e_t", BLUE, steps, |e| e.translation, set.meta.sigma_t_deg),
        Curve::new("e_theta", ORANGE, steps, |e| e.rotation, set.meta.sigma_r_deg),
    ];
    let legend = curves.each_ref().map(Curve::legend);
    let area = headed(area, "Error against the reference", &legend)?;
    let range = decades(curves.iter().flat_map(Curve::values));
    let last = u32::try_from(steps.len())?.max(1);
    let mut chart = chart_on(&area)
        // A hair wider, so that rounding does not lose the ticks at both ends.
        .build_cartesian_2d(0..last + 1, (range.start * 0.999..range.end * 1.001).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(BLACK.mix(GRID / 2.0))
        .bold_line_style(BLACK.mix(GRID))
        .x_desc("pair")
        .y_desc("error, degrees")
        .y_label_formatter(&|y| format!("{y}"))
        .label_style(font(13))
        .axis_desc_style(font(14))
        .draw()?;
    for Curve { color, singles, running, reference, .. } in curves {
        let shown = |(i, y): (u32, f64)| (i, y.max(range.start));
        let dot = |at| Circle::new(shown(at), DOT, color.mix(FILL).filled());
        chart.draw_series(singles.into_iter().map(dot))?;
        let line = LineSeries::new(running.into_iter().map(shown), color.stroke_width(2));
        chart.draw_series(line.point_size(1))?;
        if let Some(sigma) = reference {
            let line = [(0, sigma), (last + 1, sigma)].into_iter().map(shown);
            chart.draw_series(DashedLineSeries::new(line, 5, 3, color.stroke_width(1)))?;
        }
    }
    Ok(())
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "bounds and shares that binary numbers hold exactly")]
mod tests {
    use std::fs;

    use super::super::replay::replay;
    use super::*;
    use crate::data::in_f64;
    use crate::synth::Scene;
    use stereo_selfcal::{Config, Extrinsics};

    fn picture(set: &Dataset) -> String {
        let run = replay::<f32>(set, Config::paper(), Extrinsics::SIDE_BY_SIDE, |_| ()).unwrap();
        svg(set, &run).unwrap()
    }

    #[test]
    fn every_offset_is_in_one_bin_or_beyond() {
        let counts = Counts::within(6.0, &[-6.0, -0.1, 0.0, 0.1, 5.9, 6.0, 400.0, -6.1]).unwrap();
        let filled: Vec<_> = (0..).zip(&counts.bins).filter(|(_, n)| **n > 0).collect();
        assert_eq!(filled, [(0, &1), (29, &1), (30, &2), (59, &1)]);
        assert_eq!(counts.beyond, 3.0 / 8.0);
    }

    #[test]
    fn axes_end_at_round_numbers() {
        assert_eq!([5.0, 5.1, 19.0, 200.0, 201.0].map(nice_limit), [5.0, 10.0, 20.0, 200.0, 500.0]);
        assert_eq!(decades([0.3, 0.002, 4.0].into_iter()), 1e-3..10.0);
        assert_eq!(decades([1e-12, 0.5].into_iter()), 1e-6..1.0);
        assert_eq!(decades([0.0, f64::NAN].into_iter()), 0.1..1.0);
    }

    #[test]
    fn no_pair_one_pair_no_estimate_and_no_error_are_drawn_all_the_same() {
        let exact = Scene { noise_px: 0.0, ..Scene::default() };
        let too_few = Scene { matches: 5, ..Scene::default() };
        for set in [exact.dataset(0, 1), exact.dataset(1, 1), too_few.dataset(3, 1)] {
            let set = set.unwrap();
            assert!(picture(&set).contains(&format!("pairs: {}", set.pairs.len())));
        }
        let set = exact.dataset(2, 1).unwrap();
        let truth = set.truth::<f64>().unwrap();
        let untouched = RunLog::new(truth, in_f64(&Extrinsics::<f32>::SIDE_BY_SIDE));
        assert!(svg(&set, &untouched).unwrap().contains("as the run started; 0.0 %"));
    }

    #[test]
    fn an_older_picture_is_replaced_and_folders_are_made() {
        let set = Scene::default().dataset(1, 1).unwrap();
        let run = RunLog::new(set.truth().unwrap(), Extrinsics::SIDE_BY_SIDE);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b.svg");
        for _ in 0..2 {
            write_svg(&path, &set, &run).unwrap();
            assert!(fs::read_to_string(&path).unwrap().ends_with("</svg>\n"));
        }
    }
}
