//! A run in one picture: row offsets before and after, and the error of the estimate over the pairs.

use std::path::Path;

use anyhow::Result;
use stereo_selfcal::Calibration;
use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::geometry::metrics::Deviation;

use super::log::RunLog;
use super::step::Step;
use super::summary::row_offsets_px;
use crate::chart::legend::{DOT, FILL, Key, Mark};
use crate::chart::palette::{Rgb, SERIES};
use crate::chart::{self, Anchor, Axis, Plot, Point, Style, Svg, nice_step};
use crate::data::Dataset;
use crate::stats::median;

const SIZE: Point = [1000.0, 460.0];

/// Heights of the title, and of the heading and legend of a panel, px.
const TITLE: f64 = 32.0;
const HEAD: f64 = 80.0;

/// Margins of the axes within a panel: left, right, bottom, px.
const MARGINS: [f64; 3] = [70.0, 14.0, 52.0];

/// Left of the columns of a legend, and the distance between its lines, px.
const COLUMNS: [f64; 2] = [70.0, 275.0];
const LINE: f64 = 17.0;

/// Sizes of the title, of headings and of the words at an axis, px.
const WORDS: [f64; 3] = [17.0, 14.0, 12.0];

const BEFORE: Rgb = SERIES[7].light;
const AFTER: Rgb = SERIES[2].light;

/// Bins of the histogram; an even number, so that none straddles 0.
const BINS: u32 = 60;

/// Least half-width of the histogram, px.
const MIN_LIMIT_PX: f64 = 5.0;

/// Half-width of the histogram in medians of the offsets before: outliers reach far beyond.
const LIMIT_IN_MEDIANS: f64 = 2.0;

/// Writes the picture as SVG; folders on the way are created, an older file is replaced.
///
/// Left: histograms of the row offsets of all matches, px, under the extrinsics that the run started
/// from and under the fused ones. Right: errors against the reference, degrees, of each pair and of
/// the running estimate, with the reference's own standard error where it is known.
///
/// # Errors
/// If the data set's cameras are not valid, or the file cannot be written.
pub fn write_svg(path: &Path, set: &Dataset, log: &RunLog) -> Result<()> {
    chart::write(path, &svg(set, log)?)
}

fn svg(set: &Dataset, log: &RunLog) -> Result<String> {
    let mut svg = Svg::new(SIZE).on_white();
    let matches: usize = set.pairs.iter().map(Vec::len).sum();
    let title = format!("{}, pairs: {}, matches: {matches}", set.name, set.pairs.len());
    svg.text([SIZE[0] / 2.0, TITLE / 2.0], WORDS[0], Anchor::Middle, &title);
    draw_offsets(&mut svg, 0.0, &Histogram::of(set, log)?);
    draw_errors(&mut svg, SIZE[0] / 2.0, set, log.steps());
    Ok(svg.finish())
}

/// Heading, legend, axes and grid of one half of the picture.
///
/// * `left`: of the half, px.
/// * `axes`: with their names.
fn panel<'a>(
    svg: &'a mut Svg,
    left: f64,
    heading: &str,
    legend: &[Vec<Key>],
    axes: [(Axis, &str); 2],
) -> Plot<'a> {
    let middle = left + SIZE[0] / 4.0;
    svg.text([middle, TITLE + 12.0], WORDS[1], Anchor::Middle, heading);
    for (column, x) in legend.iter().zip(COLUMNS) {
        for (key, row) in column.iter().zip((0_u8..).map(f64::from)) {
            key.draw(svg, [left + x, TITLE + 34.0 + row * LINE]);
        }
    }
    let [before, after, below] = MARGINS;
    let top_left = [left + before, TITLE + HEAD + 10.0];
    let corners = [top_left, [left + SIZE[0] / 2.0 - after, SIZE[1] - below]];
    let [(x, x_name), (y, y_name)] = axes;
    let mut plot = Plot::new(svg, corners, [x, y]);
    plot.grid_x();
    plot.grid_y();
    plot.border();
    plot.label_x(x_name, WORDS[2]);
    plot.label_y(y_name, WORDS[2], MARGINS[0] - 14.0);
    plot
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
        let offsets = |calibration: &Calibration<f64>| -> Vec<f64> {
            row_offsets_px(set, calibration).into_iter().flatten().flatten().collect()
        };
        let before = offsets(&set.calibration(log.factory(), &LensCorrection::NONE)?);
        let after = log.fused().map(|f| f.calibration(set)).transpose()?.as_ref().map(offsets);
        let typical = median(before.iter().map(|x| x.abs())).unwrap_or(0.0);
        let limit = nice_step(MIN_LIMIT_PX.max(LIMIT_IN_MEDIANS * typical));
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
    fn outline(&self, limit: f64) -> Vec<Point> {
        let width = 2.0 * limit / f64::from(BINS);
        let mut x = -limit;
        let mut points = vec![[x, 0.0]];
        for count in self.bins.iter().copied().map(f64::from) {
            points.extend([[x, count], [x + width, count]]);
            x += width;
        }
        points.push([x, 0.0]);
        points
    }
}

fn draw_offsets(svg: &mut Svg, left: f64, histogram: &Histogram) {
    let limit = histogram.limit;
    let after = histogram.after.iter().map(|after| ("with the fused estimate", AFTER, after));
    let all: Vec<_> =
        [("as the run started", BEFORE, &histogram.before)].into_iter().chain(after).collect();
    let key = |(name, color, counts): &(&str, Rgb, &Counts)| {
        let beyond = 100.0 * counts.beyond;
        let words = format!("{name}; {beyond:.1} % of the matches beyond ±{limit} px");
        Key::new(Mark::Bars, *color, words)
    };
    let top = 1.1 * f64::from(histogram.highest().max(1));
    let axes = [
        (Axis::over(-limit..limit, 10.0), "row offset, px"),
        (Axis::over(0.0..top, 8.0), "matches per bin"),
    ];
    let legend = [all.iter().map(key).collect()];
    let mut plot = panel(svg, left, "Row offset after rectification", &legend, axes);
    for (_, color, counts) in all {
        let outline = counts.outline(limit);
        plot.shape(outline.iter().copied(), Style::filled(color).opacity(FILL));
        plot.line(outline, Style::line(color, 1.0));
    }
}

/// One of the two errors over the pairs, degrees.
struct Curve {
    name: &'static str,
    color: Rgb,
    singles: Vec<Point>,
    running: Vec<Point>,
    /// Standard error of the reference.
    reference: Option<f64>,
}

impl Curve {
    /// * `of`: picks the error out of a deviation, rad.
    fn new(
        name: &'static str,
        color: Rgb,
        steps: &[Step],
        of: fn(&Deviation<f64>) -> f64,
        reference: Option<f64>,
    ) -> Self {
        let numbered = || (1_u32..).map(f64::from).zip(steps);
        let degrees = |error: &Deviation<f64>| of(error).to_degrees();
        let singles = numbered().filter_map(|(i, s)| Some([i, degrees(&s.pair_error()?)]));
        let running = numbered().filter_map(|(i, s)| Some([i, degrees(s.running.as_ref()?)]));
        Self { name, color, singles: singles.collect(), running: running.collect(), reference }
    }

    fn legend(&self) -> Vec<Key> {
        let Self { name, color, .. } = *self;
        let drawn = [(Mark::Dots, "pair alone"), (Mark::Line, "all pairs so far")];
        let reference = self.reference.map(|_| (Mark::Dashes, "1 sd of the reference"));
        let all = drawn.into_iter().chain(reference);
        all.map(|(mark, what)| Key::new(mark, color, format!("{name}, {what}"))).collect()
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.singles.iter().chain(&self.running).map(|[_, y]| *y).chain(self.reference)
    }
}

fn draw_errors(svg: &mut Svg, left: f64, set: &Dataset, steps: &[Step]) {
    let [t, r] = [SERIES[0].light, SERIES[1].light];
    let curves = [
        Curve::new("e_t", t, steps, |e| e.translation, set.meta.sigma_t_deg),
        Curve::new("e_theta", r, steps, |e| e.rotation, set.meta.sigma_r_deg),
    ];
    let end = u32::try_from(steps.len()).map_or(f64::NAN, f64::from) + 1.0;
    let errors = Axis::decades(curves.iter().flat_map(Curve::values));
    let axes = [(Axis::over(0.0..end.max(2.0), 8.0), "pair"), (errors, "error, degrees")];
    let legend = curves.each_ref().map(Curve::legend);
    let mut plot = panel(svg, left, "Error against the reference", &legend, axes);
    for Curve { color, singles, running, reference, .. } in curves {
        plot.dots(singles, DOT, Style::filled(color).opacity(FILL));
        plot.dots(running.iter().copied(), 1.0, Style::filled(color));
        plot.line(running, Style::line(color, 2.0));
        if let Some(sigma) = reference {
            plot.line([[0.0, sigma], [end, sigma]], Style::line(color, 1.0).dashed(5.0, 3.0));
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "bounds and shares that binary numbers hold exactly")]
mod tests {
    use std::fs;

    use super::*;
    use crate::data::in_f64;
    use crate::run::replay::replay;
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
        assert_eq!([5.0, 5.1, 19.0, 200.0, 201.0].map(nice_step), [5.0, 10.0, 20.0, 200.0, 500.0]);
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
