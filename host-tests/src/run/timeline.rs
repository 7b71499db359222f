//! A rig that moves in one picture: truth, estimate and what is in use over the pairs, and the state.

use std::ops::Range;
use std::path::Path;

use anyhow::Result;
use nalgebra::{Matrix5, Vector3};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use stereo_selfcal::{Extrinsics, Proposal, RectifyingRotations, Scalar, State, so3};

use crate::chart::sheet::{self, Area, BLUE, Entry, FILL, GREEN, GREY, GRID, Mark, ORANGE, font};
use crate::data::in_f64;

const SIZE: (u32, u32) = (1000, 1000);
const RED: RGBColor = RGBColor(190, 30, 45);

/// Heights of title with legends, and of the strip of the state with the axis of the pairs, px.
const HEAD: u32 = 74;
const STRIP: u32 = 78;

/// Left and right of a panel, px.
const LABELS: i32 = 50;
const MARGIN: i32 = 24;

/// Share of its height that a panel leaves free above and below.
const AIR: f64 = 0.12;

/// Least height of a panel, degrees.
const MIN_HEIGHT_DEG: f64 = 0.02;

/// The five that a panel each is about, as [`Pose`] has them.
const NAMES: [&str; 5] = [
    "R about x (pitch), degrees",
    "R about y (yaw), degrees",
    "R about z (roll), degrees",
    "t towards y, degrees",
    "t towards z, degrees",
];

/// Rotation vector of `R`, angles of `t` out of `-x` towards y and z; degrees.
type Pose = [f64; 5];

/// What is drawn of one pair, after it.
#[derive(Debug, Clone, PartialEq)]
pub struct TimelinePoint {
    /// The rig during the pair.
    pub truth: Extrinsics<f64>,
    /// What is in use.
    pub in_use: Extrinsics<f64>,
    /// The estimate.
    pub proposed: Option<Proposed>,
    /// How far it can be relied on.
    pub state: State,
}

/// What is drawn of an estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposed {
    pose: Pose,
    /// Claimed standard deviations, degrees; 0 where there is no covariance.
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
    let mut moved = nalgebra::Matrix3x2::zeros();
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
    sheet::write(path, &svg(title, points, knock)?)
}

fn svg(title: &str, points: &[TimelinePoint], knock: usize) -> Result<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let (head, rest) = root.split_vertically(HEAD);
        let (panels, strip) = rest.split_vertically(SIZE.1 - HEAD - STRIP);
        draw_head(&head, title)?;
        for (component, panel) in panels.split_evenly((NAMES.len(), 1)).iter().enumerate() {
            draw_panel(panel, &Panel::of(component, points), knock)?;
        }
        draw_states(&strip, points, knock)?;
        root.present()?;
    }
    Ok(svg)
}

fn draw_head(area: &Area<'_>, title: &str) -> Result<()> {
    let middle = i32::try_from(area.dim_in_pixel().0)? / 2;
    let centred = font(20).pos(Pos::new(HPos::Center, VPos::Top));
    area.draw(&Text::new(title.to_owned(), (middle, 8), centred))?;
    let of =
        |(mark, color, label): (Mark, RGBColor, &str)| -> Entry { (mark, color, label.into()) };
    let drawn = [
        (Mark::Line, GREY, "truth of each pair, with its vibration"),
        (Mark::Line, ORANGE, "proposed"),
        (Mark::Bars, ORANGE, "2 claimed standard deviations"),
        (Mark::Line, BLUE, "in use"),
        (Mark::Dashes, BLACK, "knock"),
    ];
    sheet::legend(area, &drawn.map(of), &[LABELS, 370, 490, 750, 860], 52)
}

/// One of the five over the pairs, degrees.
struct Panel {
    name: &'static str,
    truth: Vec<(f64, f64)>,
    in_use: Vec<(f64, f64)>,
    proposed: Vec<(f64, f64)>,
    /// Lower side of the band, then its upper side backwards.
    band: Vec<(f64, f64)>,
    pairs: f64,
    height: Range<f64>,
}

impl Panel {
    fn of(component: usize, points: &[TimelinePoint]) -> Self {
        let numbered = || (0_u32..).map(f64::from).zip(points);
        let truth: Vec<_> = numbered().map(|(i, m)| (i, pose(&m.truth)[component])).collect();
        let height = height(&truth, points, component);
        let shown = |(i, y): (f64, f64)| (i, y.clamp(height.start, height.end));
        let in_use = numbered().map(|(i, m)| shown((i, pose(&m.in_use)[component]))).collect();
        let proposals: Vec<(f64, f64, f64)> = numbered()
            .filter_map(|(i, m)| {
                let Proposed { pose, sd } = m.proposed.as_ref()?;
                Some((i, pose[component], 2.0 * sd[component]))
            })
            .collect();
        let lower = proposals.iter().map(|&(i, y, two_sd)| shown((i, y - two_sd)));
        let upper = proposals.iter().map(|&(i, y, two_sd)| shown((i, y + two_sd)));
        Self {
            name: NAMES[component],
            in_use,
            proposed: proposals.iter().map(|&(i, y, _)| shown((i, y))).collect(),
            band: lower.chain(upper.rev()).collect(),
            pairs: truth.last().map_or(1.0, |(i, _)| i + 1.0),
            truth,
            height,
        }
    }
}

/// What a panel shows: the truth, and the band while the estimate is locked.
fn height(truth: &[(f64, f64)], points: &[TimelinePoint], component: usize) -> Range<f64> {
    let locked = points.iter().filter(|m| m.state == State::Locked);
    // The first locked pairs claim little, and would flatten what comes after.
    let settled = locked.skip(points.len() / 50).filter_map(|m| m.proposed.as_ref());
    let ends = settled.flat_map(|p| [-2.0, 2.0].map(|n| p.pose[component] + n * p.sd[component]));
    let values = truth.iter().map(|(_, y)| *y).chain(ends);
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    if low > high {
        return -MIN_HEIGHT_DEG..MIN_HEIGHT_DEG;
    }
    let (middle, half) = (f64::midpoint(low, high), ((high - low) / 2.0).max(MIN_HEIGHT_DEG / 2.0));
    middle - half * (1.0 + 2.0 * AIR)..middle + half * (1.0 + 2.0 * AIR)
}

fn draw_panel(area: &Area<'_>, panel: &Panel, knock: usize) -> Result<()> {
    let mut chart = ChartBuilder::on(area)
        .margin_top(6)
        .margin_right(MARGIN)
        .set_label_area_size(LabelAreaPosition::Left, LABELS)
        .build_cartesian_2d(0.0..panel.pairs, panel.height.clone())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(GRID))
        .x_labels(9)
        .y_labels(5)
        .y_label_formatter(&|y| format!("{y:.2}"))
        .label_style(font(13))
        .draw()?;
    let line = |points: &[(f64, f64)], style: ShapeStyle| LineSeries::new(points.to_vec(), style);
    chart.draw_series([Polygon::new(panel.band.clone(), ORANGE.mix(FILL / 2.0))])?;
    chart.draw_series(line(&panel.truth, GREY.stroke_width(1)))?;
    chart.draw_series(line(&panel.proposed, ORANGE.mix(FILL).stroke_width(5)))?;
    chart.draw_series(line(&panel.in_use, BLUE.stroke_width(2)))?;
    let at = f64::from(u32::try_from(knock)?);
    let ends = [(at, panel.height.start), (at, panel.height.end)];
    chart.draw_series(DashedLineSeries::new(ends, 4, 4, BLACK.stroke_width(1)))?;
    let named = font(14).pos(Pos::new(HPos::Left, VPos::Top));
    area.draw(&Text::new(panel.name, (LABELS + 8, 10), named))?;
    Ok(())
}

fn color(state: State) -> RGBColor {
    match state {
        State::Locked => GREEN,
        State::Suspect => ORANGE,
        State::Lost => RED,
        _ => GREY,
    }
}

fn draw_states(area: &Area<'_>, points: &[TimelinePoint], knock: usize) -> Result<()> {
    let pairs = f64::from(u32::try_from(points.len())?);
    let mut chart = ChartBuilder::on(area)
        .margin_top(6)
        .margin_right(MARGIN)
        .set_label_area_size(LabelAreaPosition::Left, LABELS)
        .set_label_area_size(LabelAreaPosition::Bottom, 54)
        .build_cartesian_2d(0.0..pairs.max(1.0), 0.0..1.0)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_y_axis()
        .x_labels(9)
        .x_label_formatter(&|x| format!("{x}"))
        .x_desc("pair")
        .label_style(font(13))
        .axis_desc_style(font(14))
        .draw()?;
    let mut from = 0.0;
    for run in points.chunk_by(|a, b| a.state == b.state) {
        // From the pair that brought the state to the one that ended it.
        let to = from + f64::from(u32::try_from(run.len())?);
        let color = color(run[0].state);
        let corners = [(from, 0.0), (to, 1.0)];
        chart.draw_series([Rectangle::new(corners, color.mix(FILL).filled())])?;
        chart.draw_series([Rectangle::new(corners, color.stroke_width(1))])?;
        from = to;
    }
    let at = f64::from(u32::try_from(knock)?);
    chart.draw_series(DashedLineSeries::new(
        [(at, 0.0), (at, 1.0)],
        4,
        4,
        BLACK.stroke_width(1),
    ))?;
    let beside = font(13).pos(Pos::new(HPos::Right, VPos::Center));
    area.draw(&Text::new("state", (LABELS - 8, 15), beside))?;
    let all = [State::Acquiring, State::Locked, State::Suspect, State::Lost];
    let entries = all.map(|state| -> Entry { (Mark::Bars, color(state), state.to_string()) });
    sheet::legend(area, &entries, &[LABELS, 180, 270, 365], 62)
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
            assert!(svg("nothing yet", points, 0).unwrap().contains("nothing yet"));
        }
    }
}
