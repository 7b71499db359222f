//! A run in one picture: row offsets before and after, and the error of the estimate over the pairs.

use std::path::Path;

use anyhow::Result;
use stereo_selfcal::Calibration;
use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::outcome::StandardDeviations;

use crate::chart::legend::{DOT, FILL, Key, Mark};
use crate::chart::palette::{Rgb, SERIES};
use crate::chart::{Anchor, Axis, Plot, Point, Style, Svg};
use rigs::data::Dataset;
use sim::run::{RunLog, SCREEN_PX, Step, row_offsets_px};
use sim::stats::{median, quantile};

const SIZE: Point = [1000.0, 460.0];

/// Height of the title, and height of the heading and legend of a half of the picture, px.
const TITLE: f64 = 32.0;
const HEAD: f64 = 70.0;

/// Margins of the axes within a half: left, right, bottom, px.
const MARGINS: [f64; 3] = [70.0, 14.0, 52.0];

/// Distance between the lines of a legend, and between two charts one above the other, px.
const LINE: f64 = 17.0;
const GAP: f64 = 16.0;

/// Font sizes of the title, of headings and of the words at an axis, px.
const WORDS: [f64; 3] = [17.0, 14.0, 12.0];

const BEFORE: Rgb = SERIES[1].light;
const AFTER: Rgb = SERIES[2].light;
const TRANSLATION: Rgb = SERIES[0].light;
const ROTATION: Rgb = SERIES[9].light;

/// Bins of the histogram; an even number, so that 0 is the edge of a bin.
const BINS: u32 = 60;

/// Least share of the row offsets under the extrinsics of the start that the histogram contains.
const SHOWN: f64 = 0.98;

/// Least half-width of the histogram, px.
const MIN_LIMIT_PX: f64 = 2.0;

/// Writes the picture as SVG; missing folders are created, an older file is replaced.
///
/// Left: two histograms of row offsets, px: under the extrinsics that the run started from, and under the fused ones.
/// Both count the matches within [`SCREEN_PX`] of their row under the fused extrinsics. Without fused extrinsics there
/// is only the first histogram, over all matches. Right: errors against the reference, degrees, of each pair alone and
/// of the running estimate. A band shows the standard deviation that the estimate reports, and a dashed line the
/// standard error of the reference, if known.
///
/// # Errors
/// If the data set's cameras are not valid, or the file cannot be written.
pub fn write_svg(path: &Path, set: &Dataset, log: &RunLog) -> Result<()> {
    crate::write(path, &svg(set, log)?)
}

fn svg(set: &Dataset, log: &RunLog) -> Result<String> {
    let mut svg = Svg::new(SIZE).on_white();
    let matches: usize = set.pairs.iter().map(Vec::len).sum();
    let title = format!("{}: {} pairs, {matches} matches", set.name, set.pairs.len());
    svg.text([SIZE[0] / 2.0, TITLE / 2.0], WORDS[0], Anchor::Middle, &title);
    draw_offsets(&mut svg, 0.0, &Histogram::of(set, log)?);
    draw_errors(&mut svg, SIZE[0] / 2.0, set, log.steps());
    Ok(svg.finish())
}

/// Heading and legend of one half of the picture.
///
/// * `left`: left border of the half, px.
fn head(svg: &mut Svg, left: f64, heading: &str, legend: &[Key]) {
    svg.text([left + SIZE[0] / 4.0, TITLE + 12.0], WORDS[1], Anchor::Middle, heading);
    for (key, row) in legend.iter().zip((0_u8..).map(f64::from)) {
        key.draw(svg, [left + MARGINS[0], TITLE + 34.0 + row * LINE]);
    }
}

/// Axes and grid between two heights of one half of the picture.
///
/// * `left`: left border of the half, px.
/// * `axes`: horizontal and vertical axis with their names. A horizontal axis without a name gets no labels.
fn chart<'a>(
    svg: &'a mut Svg,
    left: f64,
    [top, bottom]: [f64; 2],
    axes: [(Axis, &str); 2],
) -> Plot<'a> {
    let [before, after, _] = MARGINS;
    let corners = [[left + before, top], [left + SIZE[0] / 2.0 - after, bottom]];
    let [(x, x_name), (y, y_name)] = axes;
    let mut plot = Plot::new(svg, corners, [x, y]);
    plot.frame(true);
    if !x_name.is_empty() {
        plot.label_x(x_name, WORDS[2]);
    }
    plot.label_y(y_name, WORDS[2], MARGINS[0] - 14.0);
    plot
}

/// Row offsets before and after the run, counted in bins of one width.
#[derive(Debug, PartialEq)]
struct Histogram {
    /// Half-width of the histogram, px.
    limit: f64,
    /// Number of matches counted, and of all matches.
    counted: [usize; 2],
    before: Counts,
    /// Counts after; `None` without an estimate.
    after: Option<Counts>,
}

#[derive(Debug, PartialEq)]
struct Counts {
    bins: Vec<u32>,
    /// Median of the magnitudes of the offsets, px.
    median: f64,
}

impl Histogram {
    fn of(set: &Dataset, log: &RunLog) -> Result<Self> {
        let offsets = |calibration: &Calibration<f64>| -> Vec<Option<f64>> {
            row_offsets_px(set, calibration).into_iter().flatten().collect()
        };
        let before = offsets(&set.meta.calibration(log.factory(), &LensCorrection::NONE)?);
        let after = log.fused().map(|f| f.calibration(set)).transpose()?.as_ref().map(offsets);
        let all = before.len();
        let fits = |i: &usize| {
            let offset = after.as_ref().map_or(before[*i], |after| after[*i]);
            offset.is_some_and(|px| after.is_none() || px.abs() <= SCREEN_PX)
        };
        let kept: Vec<usize> = (0..all).filter(fits).collect();
        let pick = |offsets: &[Option<f64>]| -> Vec<f64> {
            kept.iter().filter_map(|&i| offsets[i]).collect()
        };
        let before = pick(&before);
        let reach = quantile(before.iter().map(|x| x.abs()), SHOWN).unwrap_or(0.0);
        let limit = MIN_LIMIT_PX.max(reach).ceil();
        let after = after.map(|after| Counts::within(limit, &pick(&after)));
        Ok(Self {
            limit,
            counted: [kept.len(), all],
            before: Counts::within(limit, &before),
            after,
        })
    }

    fn highest(&self) -> u32 {
        let all = self.before.bins.iter().chain(self.after.iter().flat_map(|after| &after.bins));
        all.copied().max().unwrap_or(0)
    }
}

impl Counts {
    /// Counts offsets in [`BINS`] bins from `-limit` to below `limit`, px. Other offsets are in no bin, but count in
    /// the median.
    fn within(limit: f64, offsets: &[f64]) -> Self {
        let width = 2.0 * limit / f64::from(BINS);
        let edge = |i: u32| f64::from(i) * width - limit;
        let count = |i: u32| {
            let bin = edge(i)..edge(i + 1);
            offsets.iter().map(|x| u32::from(bin.contains(x))).sum()
        };
        let median = median(offsets.iter().map(|x| x.abs())).unwrap_or(0.0);
        Self { bins: (0..BINS).map(count).collect(), median }
    }

    /// The outline of the bars, from the horizontal axis and back to it.
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
    let Histogram { limit, counted: [counted, all], before, after } = histogram;
    let after = after.iter().map(|after| ("after", AFTER, after));
    let drawn: Vec<_> = [("before", BEFORE, before)].into_iter().chain(after).collect();
    let key = |(name, color, counts): &(&str, Rgb, &Counts)| {
        Key::new(Mark::Bars, *color, format!("{name}: median {:.2} px", counts.median))
    };
    let legend: Vec<_> = drawn.iter().map(key).collect();
    head(svg, left, "Row offset of the matches", &legend);
    let top = 1.1 * f64::from(histogram.highest().max(1));
    let name = format!("row offset, px ({counted} of {all} matches fit)");
    let axes =
        [(Axis::over(-limit..*limit, 10.0), name.as_str()), (Axis::over(0.0..top, 8.0), "matches")];
    let mut plot = chart(svg, left, [TITLE + HEAD + 10.0, SIZE[1] - MARGINS[2]], axes);
    for (_, color, counts) in drawn {
        let outline = counts.outline(*limit);
        plot.shape(outline.iter().copied(), Style::filled(color).opacity(FILL));
        plot.line(outline, Style::line(color, 1.0));
    }
}

/// The error of `t` or of `R` over the pairs, degrees.
struct Curve {
    name: &'static str,
    color: Rgb,
    /// Number of each pair, from 1, and its error when solved alone.
    singles: Vec<Point>,
    /// Number of each pair, from 1, and the error of the running estimate.
    running: Vec<Point>,
    /// Number of each pair, from 1, and the reported deviation of the running estimate, with the lens uncertain.
    reported: Vec<Point>,
    /// Standard error of the reference.
    reference: Option<f64>,
}

impl Curve {
    /// * `of`: picks the error, rad.
    /// * `sd`: picks the standard deviation that the estimate reports for it, rad.
    fn new(
        (name, color): (&'static str, Rgb),
        steps: &[Step],
        of: fn(&Deviation<f64>) -> f64,
        sd: fn(&StandardDeviations<f64>) -> f64,
        reference: Option<f64>,
    ) -> Self {
        let numbered = || (1_u32..).map(f64::from).zip(steps);
        let degrees = |error: &Deviation<f64>| of(error).to_degrees();
        let singles = numbered().filter_map(|(i, s)| Some([i, degrees(&s.pair_error()?)]));
        let running = numbered().filter_map(|(i, s)| Some([i, degrees(s.running.as_ref()?)]));
        let reported =
            numbered().filter_map(|(i, s)| Some([i, sd(&s.estimate?.sd_lens).to_degrees()]));
        Self {
            name,
            color,
            singles: singles.collect(),
            running: running.collect(),
            reported: reported.collect(),
            reference,
        }
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        let drawn = self.singles.iter().chain(&self.running).chain(&self.reported);
        drawn.map(|[_, y]| *y).chain(self.reference)
    }
}

fn draw_errors(svg: &mut Svg, left: f64, set: &Dataset, steps: &[Step]) {
    let [t, r] = [("error of t, degrees", TRANSLATION), ("error of R, degrees", ROTATION)];
    let curves = [
        Curve::new(t, steps, |e| e.translation, |sd| sd.translation, set.meta.sigma_t_deg),
        Curve::new(r, steps, |e| e.rotation, |sd| sd.rotation, set.meta.sigma_r_deg),
    ];
    let legend = [
        (Mark::Line, "line: estimate from all pairs so far; dots: each pair alone"),
        (Mark::Bars, "band: its sd with the lens uncertain; dashed: sd of the reference"),
    ];
    let keys = legend.map(|(mark, words)| Key::new(mark, TRANSLATION, words));
    head(svg, left, "Error against the reference", &keys);
    let end = (u32::try_from(steps.len()).map_or(f64::NAN, f64::from) + 1.0).max(2.0);
    let errors = Axis::decades(curves.iter().flat_map(Curve::values));
    let [top, bottom] = [TITLE + HEAD + 10.0, SIZE[1] - MARGINS[2]];
    let middle = f64::midpoint(top, bottom);
    let heights = [[top, middle - GAP / 2.0], [middle + GAP / 2.0, bottom]];
    for ((curve, height), x_name) in curves.into_iter().zip(heights).zip(["", "pairs so far"]) {
        let axes = [(Axis::over(0.0..end, 8.0), x_name), (errors.clone(), curve.name)];
        let mut plot = chart(svg, left, height, axes);
        plot.band(&curve.reported, Style::filled(curve.color).opacity(FILL / 2.0));
        plot.dots(curve.singles, DOT, Style::filled(curve.color).opacity(FILL));
        plot.dots(curve.running.iter().copied(), 1.0, Style::filled(curve.color));
        plot.line(curve.running, Style::line(curve.color, 2.0));
        if let Some(sigma) = curve.reference {
            let style = Style::line(curve.color, 1.0).dashed(5.0, 3.0);
            plot.line([[0.0, sigma], [end, sigma]], style);
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "the mean of two numbers of the test, and round bounds")]
mod tests {
    use std::fs;

    use super::*;
    use rigs::data::in_f64;
    use sim::run::{Start, replay};
    use sim::synth::Scene;
    use stereo_selfcal::Extrinsics;
    use stereo_selfcal::paper::Settings;

    fn picture(set: &Dataset) -> String {
        let run = replay::<f32>(set, Settings::DEFAULT, Start::Guess, |_| ()).unwrap();
        svg(set, &run).unwrap()
    }

    #[test]
    fn every_offset_is_in_one_bin_or_beyond_the_limit() {
        let counts = Counts::within(6.0, &[-6.0, -0.1, 0.0, 0.1, 5.9, 6.0, 400.0, -6.1]);
        let filled: Vec<_> = (0..).zip(&counts.bins).filter(|(_, n)| **n > 0).collect();
        assert_eq!(filled, [(0, &1), (29, &1), (30, &2), (59, &1)]);
        assert_eq!(counts.median, 5.95);
    }

    #[test]
    fn runs_without_pairs_estimate_or_error_are_drawn() {
        let exact = Scene { noise_px: 0.0, ..Scene::default() };
        let too_few = Scene { matches: 5, ..Scene::default() };
        for set in [exact.dataset(0, 1), exact.dataset(1, 1), too_few.dataset(3, 1)] {
            let set = set.unwrap();
            assert!(picture(&set).contains(&format!(": {} pairs", set.pairs.len())));
        }
        let set = exact.dataset(2, 1).unwrap();
        let truth = set.truth::<f64>().unwrap();
        let untouched = RunLog::new(truth, in_f64(&Extrinsics::<f32>::SIDE_BY_SIDE));
        let drawn = svg(&set, &untouched).unwrap();
        assert!(drawn.contains("before: median") && !drawn.contains("after: median"));
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
