//! Picture of a run whose rig is knocked: errors of the extrinsics in use, and state of the calibrator, over the pairs.

use std::path::Path;

use anyhow::Result;
use stereo_selfcal::State;
use stereo_selfcal::geometry::metrics::Deviation;

use super::states::STATES;
use crate::chart::legend::{FILL, Key, Mark};
use crate::chart::palette::{Rgb, SERIES};
use crate::chart::{Anchor, Axis, Plot, Point, Style, Svg};

const SIZE: Point = [1000.0, 440.0];
const ROTATION: Rgb = SERIES[9].light;
const TRANSLATION: Rgb = SERIES[0].light;

/// Heights of the title, of a chart, and of the strip of states, and distance between charts, px.
const HEAD: f64 = 36.0;
const CHART: f64 = 140.0;
const STRIP: f64 = 22.0;
const GAP: f64 = 14.0;

/// Left and right margin of a chart, px.
const LEFT: f64 = 70.0;
const RIGHT: f64 = 14.0;

/// Font sizes of the title and of other words, px.
const WORDS: [f64; 2] = [17.0, 12.0];

/// The calibration after one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimelinePoint {
    /// Error of the extrinsics in use, rad.
    pub error: Deviation<f64>,
    /// Standard deviation that the estimate reports, rad; `None` without an estimate.
    pub sd: Option<Deviation<f64>>,
    /// State of the calibrator.
    pub state: State,
}

/// Writes the picture as SVG; missing folders are created, an older file is replaced.
///
/// * `knock`: number of the first pair after the knock, from 0; a line marks it.
pub fn write_svg(path: &Path, title: &str, points: &[TimelinePoint], knock: usize) -> Result<()> {
    crate::write(path, &svg(title, points, knock))
}

fn svg(title: &str, points: &[TimelinePoint], knock: usize) -> String {
    let mut svg = Svg::new(SIZE).on_white();
    svg.text([SIZE[0] / 2.0, 18.0], WORDS[0], Anchor::Middle, title);
    let knock = u32::try_from(knock).map_or(f64::NAN, f64::from);
    let pairs = Axis::over(0.0..count(points).max(1.0), 9.0);
    let tops = [HEAD, HEAD + CHART + GAP, HEAD + 2.0 * (CHART + GAP)];
    let rotation = Part { name: "error of R, degrees", color: ROTATION, of: |part| part.rotation };
    let translation =
        Part { name: "error of t, degrees", color: TRANSLATION, of: |part| part.translation };
    for (part, top) in [rotation, translation].into_iter().zip(tops) {
        draw_errors(&mut svg, top, &pairs, &part, points, knock);
    }
    draw_states(&mut svg, tops[2], &pairs, points, knock);
    svg.finish()
}

fn count(points: &[TimelinePoint]) -> f64 {
    u32::try_from(points.len()).map_or(f64::NAN, f64::from)
}

/// Number and value of each pair that has a value.
fn values(
    points: &[TimelinePoint],
    of: impl Fn(&TimelinePoint) -> Option<f64>,
) -> impl Iterator<Item = Point> {
    (0_u32..).map(f64::from).zip(points).filter_map(move |(i, point)| Some([i, of(point)?]))
}

/// Axes, grid, and the line of the knock.
///
/// * `top`, `height`: of the chart, px.
fn chart<'a>(
    svg: &'a mut Svg,
    [top, height]: [f64; 2],
    axes: [Axis; 2],
    name: &str,
    knock: f64,
) -> Plot<'a> {
    let mut plot = Plot::new(svg, [[LEFT, top], [SIZE[0] - RIGHT, top + height]], axes);
    plot.frame(true);
    plot.label_y(name, WORDS[1], LEFT - 14.0);
    let ends = [f64::MAX, f64::MIN_POSITIVE].map(|y| [knock, y]);
    plot.line(ends, Style::line(Rgb::BLACK, 1.0).dashed(4.0, 4.0));
    plot
}

/// The error of `R` or of `t`, and how it is drawn.
struct Part {
    name: &'static str,
    color: Rgb,
    of: fn(&Deviation<f64>) -> f64,
}

fn draw_errors(
    svg: &mut Svg,
    top: f64,
    pairs: &Axis,
    part: &Part,
    points: &[TimelinePoint],
    knock: f64,
) {
    let Part { name, color, of } = *part;
    let errors: Vec<_> = values(points, |point| Some(of(&point.error).to_degrees())).collect();
    let reported: Vec<_> = values(points, |point| Some(of(&point.sd?).to_degrees())).collect();
    let axis = Axis::decades(errors.iter().chain(&reported).map(|[_, y]| *y));
    let mut plot = chart(svg, [top, CHART], [pairs.clone(), axis], name, knock);
    plot.band(&reported, Style::filled(color).opacity(FILL / 2.0));
    plot.line(errors, Style::line(color, 2.0));
}

fn draw_states(svg: &mut Svg, top: f64, pairs: &Axis, points: &[TimelinePoint], knock: f64) {
    let axes = [pairs.clone(), Axis::groups(&["state"])];
    let mut plot = chart(svg, [top, STRIP], axes, "", knock);
    let mut from = 0.0;
    for run in points.chunk_by(|a, b| a.state == b.state) {
        // A rectangle reaches from the first pair of a state to the first pair of the next state.
        let to = from + count(run);
        let color = STATES.iter().find(|(state, _)| *state == run[0].state);
        let color = color.map_or(Rgb::BLACK, |(_, color)| color.light);
        let corners = [[from, 0.0], [to, 1.0]];
        plot.rectangle(corners, Style::filled(color).opacity(FILL));
        plot.rectangle(corners, Style::line(color, 1.0));
        from = to;
    }
    plot.label_x("pair", WORDS[1]);
    let states = STATES.map(|(state, color)| (Mark::Bars, color.light, state.to_string()));
    let drawn = [
        (Mark::Line, ROTATION, "error of the extrinsics in use".to_owned()),
        (Mark::Bars, ROTATION, "standard deviation that the estimate reports".to_owned()),
    ];
    let lefts = [LEFT, 180.0, 270.0, 365.0, 450.0, 680.0];
    for ((mark, color, words), left) in states.into_iter().chain(drawn).zip(lefts) {
        Key::new(mark, color, words).draw(svg, [left, top + STRIP + 50.0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(state: State, sd: Option<f64>) -> TimelinePoint {
        let sd = sd.map(|sd| Deviation { translation: sd, rotation: sd });
        TimelinePoint { error: Deviation { translation: 0.02, rotation: 0.01 }, sd, state }
    }

    #[test]
    fn runs_without_pairs_or_without_an_estimate_are_drawn() {
        for points in [&[][..], &[point(State::Acquiring, None)]] {
            let svg = svg("nothing yet", points, 0);
            assert!(svg.contains("nothing yet") && !svg.contains("NaN"));
        }
    }

    #[test]
    fn each_change_of_state_begins_a_rectangle() {
        let states = [State::Acquiring, State::Locked, State::Locked, State::Suspect];
        let svg = svg("", &states.map(|state| point(state, Some(0.01))), 3);
        // The background, three borders, and two rectangles for each of three states and of five keys of the legend.
        assert_eq!(svg.matches("<rect").count(), 1 + 3 + 2 * 3 + 2 * 5);
    }
}
