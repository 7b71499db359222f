//! Timeline of a moving rig: truth, estimate, extrinsics in use and state over the pairs.

use std::ops::Range;
use std::path::Path;

use anyhow::Result;
use nalgebra::{Matrix3x2, Matrix5, Vector3};
use stereo_selfcal::geometry::{RectifyingRotations, so3};
use stereo_selfcal::{Extrinsics, Proposal, Scalar, State};

use crate::chart::legend::{FILL, Key, Mark};
use crate::chart::palette::{Rgb, SERIES};
use crate::chart::{self, Anchor, Axis, Plot, Point, Style, Svg};
use crate::data::in_f64;

const SIZE: Point = [1000.0, 1000.0];
const TRUTH: Rgb = SERIES[7].light;
const PROPOSED: Rgb = SERIES[1].light;
const IN_USE: Rgb = SERIES[0].light;

/// Heights of title with legend, of a panel, and of the strip of the state, px.
const HEAD: f64 = 74.0;
const PANEL: f64 = (SIZE[1] - HEAD - STRIP) / 5.0;
const STRIP: f64 = 84.0;

/// Left and right margin of a panel, px.
const LABELS: f64 = 50.0;
const MARGIN: f64 = 24.0;

/// Sizes of the title, of the name of a panel and of other words, px.
const WORDS: [f64; 3] = [17.0, 13.0, 12.0];

/// Share of its height that a panel leaves free above and below.
const AIR: f64 = 0.12;

/// Least height of a panel, degrees.
const MIN_HEIGHT_DEG: f64 = 0.02;

/// Names of the panels, in the order of [`Pose`].
const NAMES: [&str; 5] = [
    "R about x (pitch), degrees",
    "R about y (yaw), degrees",
    "R about z (roll), degrees",
    "t towards y, degrees",
    "t towards z, degrees",
];

/// Rotation vector of `R`, angles of `t` out of `-x` towards y and z; degrees.
type Pose = [f64; 5];

/// State after one pair.
#[derive(Debug, Clone, PartialEq)]
pub struct TimelinePoint {
    /// True extrinsics of the pair.
    pub truth: Extrinsics<f64>,
    /// Extrinsics in use.
    pub in_use: Extrinsics<f64>,
    /// The estimate.
    pub proposed: Option<Proposed>,
    /// State of the calibrator.
    pub state: State,
}

/// An estimate with its standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposed {
    pose: Pose,
    /// Reported standard deviations, degrees; 0 where there is no covariance.
    sd: Pose,
}

impl<T: Scalar> From<&Proposal<T>> for Proposed {
    fn from(proposal: &Proposal<T>) -> Self {
        let extrinsics = in_f64(&proposal.extrinsics);
        let sd = proposal.covariance.map(|c| deviations(&extrinsics, &c.map(T::to_f64)));
        Self { pose: pose(&extrinsics), sd: sd.unwrap_or_default() }
    }
}

fn pose(extrinsics: &Extrinsics<f64>) -> Pose {
    let w = so3::log(extrinsics.rotation());
    let t = extrinsics.translation();
    [w.x, w.y, w.z, t.y.atan2(-t.x), t.z.atan2(-t.x)].map(f64::to_degrees)
}

/// Standard deviations of a [`Pose`], to first order near `R = I`, `t = (-1, 0, 0)`.
fn deviations(extrinsics: &Extrinsics<f64>, covariance: &Matrix5<f64>) -> Pose {
    // The unknowns are turns in the rectified frame: R_r^T brings them into that of the right camera.
    let to_camera = *RectifyingRotations::from(extrinsics).right().inverse().matrix();
    let turn = covariance.fixed_view::<3, 3>(0, 0);
    let r = to_camera * turn * to_camera.transpose();
    // A turn of the baseline about y, z moves it by (0, z, -y).
    let mut moved = Matrix3x2::zeros();
    (moved[(1, 1)], moved[(2, 0)]) = (1.0, -1.0);
    let moves = to_camera * moved;
    let t = moves * covariance.fixed_view::<2, 2>(3, 3) * moves.transpose();
    let variances = Vector3::from([r.m11, r.m22, r.m33]);
    [variances.x, variances.y, variances.z, t.m22, t.m33].map(|v| v.max(0.0).sqrt().to_degrees())
}

/// Writes the picture as SVG; folders on the way are created, an older file is replaced.
///
/// * `knock`: the pair before which the rig was turned, marked by a line.
///
/// # Errors
/// If the file cannot be written.
pub fn write_svg(path: &Path, title: &str, points: &[TimelinePoint], knock: usize) -> Result<()> {
    chart::write(path, &svg(title, points, knock))
}

fn svg(title: &str, points: &[TimelinePoint], knock: usize) -> String {
    let mut svg = Svg::new(SIZE).on_white();
    let knock = u32::try_from(knock).map_or(f64::NAN, f64::from);
    draw_head(&mut svg, title);
    for (component, top) in (0..NAMES.len()).zip((0_u8..).map(|i| HEAD + f64::from(i) * PANEL)) {
        draw_panel(&mut svg, top, Panel::of(component, points), knock);
    }
    draw_states(&mut svg, SIZE[1] - STRIP, points, knock);
    svg.finish()
}

fn draw_head(svg: &mut Svg, title: &str) {
    svg.text([SIZE[0] / 2.0, 18.0], WORDS[0], Anchor::Middle, title);
    let drawn = [
        (Mark::Line, TRUTH, "truth of each pair, with its vibration", LABELS),
        (Mark::Line, PROPOSED, "proposed", 370.0),
        (Mark::Bars, PROPOSED, "2 reported standard deviations", 490.0),
        (Mark::Line, IN_USE, "in use", 750.0),
        (Mark::Dashes, Rgb::BLACK, "knock", 860.0),
    ];
    for (mark, color, words, left) in drawn {
        Key::new(mark, color, words).draw(svg, [left, 52.0]);
    }
}

/// One of the five over the pairs, degrees.
struct Panel {
    name: &'static str,
    truth: Vec<Point>,
    in_use: Vec<Point>,
    proposed: Vec<Point>,
    /// Lower side of the band, then its upper side backwards.
    band: Vec<Point>,
    pairs: f64,
    height: Range<f64>,
}

impl Panel {
    fn of(component: usize, points: &[TimelinePoint]) -> Self {
        let numbered = || (0_u32..).map(f64::from).zip(points);
        let truth: Vec<_> = numbered().map(|(i, m)| [i, pose(&m.truth)[component]]).collect();
        let height = height(&truth, points, component);
        let in_use = numbered().map(|(i, m)| [i, pose(&m.in_use)[component]]).collect();
        let proposals: Vec<(f64, f64, f64)> = numbered()
            .filter_map(|(i, m)| {
                let Proposed { pose, sd } = m.proposed.as_ref()?;
                Some((i, pose[component], 2.0 * sd[component]))
            })
            .collect();
        let lower = proposals.iter().map(|&(i, y, two_sd)| [i, y - two_sd]);
        let upper = proposals.iter().map(|&(i, y, two_sd)| [i, y + two_sd]);
        Self {
            name: NAMES[component],
            in_use,
            proposed: proposals.iter().map(|&(i, y, _)| [i, y]).collect(),
            band: lower.chain(upper.rev()).collect(),
            pairs: truth.last().map_or(1.0, |[i, _]| i + 1.0),
            truth,
            height,
        }
    }
}

/// Range of a panel: the truth, and the band while the estimate is locked.
fn height(truth: &[Point], points: &[TimelinePoint], component: usize) -> Range<f64> {
    let locked = points.iter().filter(|m| m.state == State::Locked);
    // The first locked pairs have wide bands, which would flatten the rest.
    let settled = locked.skip(points.len() / 50).filter_map(|m| m.proposed.as_ref());
    let ends = settled.flat_map(|p| [-2.0, 2.0].map(|n| p.pose[component] + n * p.sd[component]));
    let values = truth.iter().map(|[_, y]| *y).chain(ends);
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    if low > high {
        return -MIN_HEIGHT_DEG..MIN_HEIGHT_DEG;
    }
    let (middle, half) = (f64::midpoint(low, high), ((high - low) / 2.0).max(MIN_HEIGHT_DEG / 2.0));
    middle - half * (1.0 + 2.0 * AIR)..middle + half * (1.0 + 2.0 * AIR)
}

fn draw_panel(svg: &mut Svg, top: f64, panel: Panel, knock: f64) {
    let corners = [[LABELS, top + 6.0], [SIZE[0] - MARGIN, top + PANEL]];
    let ends = [panel.height.start, panel.height.end];
    let axes = [Axis::over(0.0..panel.pairs, 9.0), Axis::over(panel.height, 5.0)];
    let mut plot = Plot::new(svg, corners, axes);
    plot.grid_x();
    plot.grid_y();
    plot.border();
    plot.label_y("", WORDS[2], 0.0);
    plot.shape(panel.band, Style::filled(PROPOSED).opacity(FILL / 2.0));
    plot.line(panel.truth, Style::line(TRUTH, 1.0));
    plot.line(panel.proposed, Style::line(PROPOSED, 5.0).opacity(FILL));
    plot.line(panel.in_use, Style::line(IN_USE, 2.0));
    draw_knock(&mut plot, knock, ends);
    svg.text([LABELS + 8.0, top + 17.0], WORDS[1], Anchor::Start, panel.name);
}

fn draw_knock(plot: &mut Plot<'_>, pair: f64, ends: [f64; 2]) {
    plot.line(ends.map(|y| [pair, y]), Style::line(Rgb::BLACK, 1.0).dashed(4.0, 4.0));
}

fn color(state: State) -> Rgb {
    match state {
        State::Locked => SERIES[2].light,
        State::Suspect => SERIES[4].light,
        State::Lost => SERIES[1].light,
        _ => SERIES[7].light,
    }
}

fn draw_states(svg: &mut Svg, top: f64, points: &[TimelinePoint], knock: f64) {
    let bottom = top + 30.0;
    let pairs = u32::try_from(points.len()).map_or(f64::NAN, f64::from);
    let axes = [Axis::over(0.0..pairs.max(1.0), 9.0), Axis::over(0.0..1.0, 1.0)];
    let mut plot = Plot::new(svg, [[LABELS, top + 6.0], [SIZE[0] - MARGIN, bottom]], axes);
    let mut from = 0.0;
    for run in points.chunk_by(|a, b| a.state == b.state) {
        // From the pair that brought the state to the one that ended it.
        let to = from + u32::try_from(run.len()).map_or(f64::NAN, f64::from);
        let color = color(run[0].state);
        let corners = [[from, 0.0], [to, 1.0]];
        plot.rectangle(corners, Style::filled(color).opacity(FILL));
        plot.rectangle(corners, Style::line(color, 1.0));
        from = to;
    }
    plot.label_x("pair", WORDS[2]);
    draw_knock(&mut plot, knock, [0.0, 1.0]);
    svg.text([LABELS - 8.0, top + 18.0], WORDS[2], Anchor::End, "state");
    let states = [State::Acquiring, State::Locked, State::Suspect, State::Lost];
    for (state, left) in states.into_iter().zip([LABELS, 180.0, 270.0, 365.0]) {
        Key::new(Mark::Bars, color(state), state.to_string()).draw(svg, [left, top + 70.0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::rig;

    #[test]
    fn a_rig_is_shown_by_the_angles_it_was_made_of() {
        let shown = pose(&rig([0.3, -0.2, 0.1], [0.4, -0.5]).unwrap());
        // A turn of (-1, 0, 0) about y by a moves it to z = a, about z by b to y = -b.
        let expected = [0.3, -0.2, 0.1, 0.5, 0.4];
        assert!(shown.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{shown:?}");
    }

    #[test]
    fn deviations_are_those_of_the_unknowns_where_the_rectified_frame_is_the_cameras() {
        let variances = nalgebra::Vector5::new(1.0, 4.0, 9.0, 16.0, 25.0);
        let sd = deviations(&Extrinsics::SIDE_BY_SIDE, &Matrix5::from_diagonal(&variances));
        let expected = [1.0, 2.0, 3.0, 5.0, 4.0].map(f64::to_degrees);
        assert!(sd.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{sd:?}");
    }

    #[test]
    fn no_pair_and_one_pair_without_an_estimate_are_drawn_all_the_same() {
        let rig = Extrinsics::SIDE_BY_SIDE;
        let point =
            TimelinePoint { truth: rig, in_use: rig, proposed: None, state: State::Acquiring };
        for points in [&[][..], &[point]] {
            let svg = svg("nothing yet", points, 0);
            assert!(svg.contains("nothing yet") && !svg.contains("NaN"));
        }
    }
}
