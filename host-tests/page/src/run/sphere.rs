//! Estimates of single pairs on the unit sphere, with the fused estimate and the reference, like the figure of the
//! fusion in the paper (eqs 20-22): baseline directions `t^k` and rotation axes `v^k`.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::so3;

use crate::chart::palette::{Rgb, SERIES};
use crate::chart::{Anchor, Axis, Plot, Point, Style, Svg};
use crate::report::{Csv, Entry, Figure, Mark, Picture};

const SIZE: Point = [460.0, 460.0];
const DOT: f64 = 3.0;

/// Sizes of the title and of the words at an axis, px.
const WORDS: [f64; 2] = [15.0, 12.0];

/// Height of the title, and the margin of a sphere at its other sides, px.
const TITLE: f64 = 28.0;
const SIDES: f64 = 14.0;

/// Left and bottom margin of axes with words, px.
const LABELS: [f64; 2] = [62.0, 48.0];

/// Least half width of a picture of the surroundings, rad.
const LEAST_REACH: f64 = 1e-4;

/// Spacing of the sphere's grid, degrees, and samples along each of its lines.
const GRID_DEG: i16 = 30;
const SAMPLES: i16 = 72;

/// Offset of the direction of view of the whole sphere from the reference, before it is normalised: a view along the
/// reference would hide the curvature.
const ASIDE: f64 = 0.5;

/// Estimates of a run.
#[derive(Debug, Clone)]
pub struct Estimates {
    /// Estimates of single pairs.
    pub pairs: Vec<Extrinsics<f64>>,
    /// Estimate of all pairs.
    pub fused: Option<Extrinsics<f64>>,
    /// Reference extrinsics.
    pub reference: Extrinsics<f64>,
}

/// Largest distance of the estimates from the reference along an axis of the enlarged pictures, rad: of `t` and of `v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    t: f64,
    v: f64,
}

impl Reach {
    /// The larger of both, so that figures to compare have one scale.
    pub fn or(self, other: Self) -> Self {
        Self { t: self.t.max(other.t), v: self.v.max(other.v) }
    }
}

/// Directions on the sphere.
struct Directions {
    pairs: Vec<Vector3<f64>>,
    fused: Option<Vector3<f64>>,
    reference: Vector3<f64>,
}

/// Four panels: `t^k` on the whole sphere and enlarged around the reference, and the same for `v^k`.
///
/// * `name`: name of the CSV file; `reach`: distance from the reference that the enlarged panels show, rad.
pub fn sphere_figure(name: &str, estimates: &Estimates, reach: Reach, command: &str) -> Figure {
    let [t, v] = estimates.both();
    let mut panels = Vec::new();
    let kinds = [
        (&t, "baseline direction t", reach.t, ("mrad", 1e3)),
        (&v, "rotation axis v", reach.v, ("degrees", 180.0 / PI)),
    ];
    for (directions, what, reach, unit) in kinds {
        let [whole, near] =
            [format!("{what} of each pair"), format!("{what}, around the reference")];
        panels.push((Picture::Svg(globe(directions, &whole)), whole));
        panels.push((Picture::Svg(zoom(directions, &near, reach, unit)), near));
    }
    let angle = so3::log(estimates.reference.rotation()).norm().to_degrees();
    Figure {
        panels,
        legend: vec![
            Entry::new(Mark::Dots, Some(SERIES[0]), "one pair"),
            Entry::new(Mark::Dots, Some(SERIES[1]), "fused"),
            Entry::new(Mark::Dots, None, "reference (a cross)"),
        ],
        caption: format!(
            "Every pair's baseline direction t^k and rotation axis v^k on the unit sphere; beside each globe \
             the surroundings of the reference, by arc length. Hollow: on the far side. The rotation angle is \
             {angle:.2} degrees: the smaller it is, the wider its axes scatter."
        ),
        command: command.to_owned(),
        numbers: estimates.numbers(name),
    }
}

impl Estimates {
    /// The reach of these estimates alone.
    pub fn reach(&self) -> Reach {
        let [t, v] = self.both().map(|directions| directions.reach());
        Reach { t, v }
    }

    /// Directions of baseline and rotation axis.
    fn both(&self) -> [Directions; 2] {
        [
            self.directions(|e| e.translation().into_inner()),
            self.directions(|e| axis(&so3::log(e.rotation()))),
        ]
    }

    fn directions(&self, of: impl Fn(&Extrinsics<f64>) -> Vector3<f64>) -> Directions {
        Directions {
            pairs: self.pairs.iter().map(&of).collect(),
            fused: self.fused.as_ref().map(&of),
            reference: of(&self.reference),
        }
    }

    fn numbers(&self, name: &str) -> Csv {
        let mut numbers = Csv::new(
            name,
            &["estimate", "t_x", "t_y", "t_z", "R as vector x, rad", "y, rad", "z, rad"],
        );
        let mut push = |what: String, e: &Extrinsics<f64>| {
            let (t, w) = (e.translation(), so3::log(e.rotation()));
            let all = [t.x, t.y, t.z, w.x, w.y, w.z].map(|x| x.to_string());
            numbers.push([what].into_iter().chain(all));
        };
        self.pairs.iter().enumerate().for_each(|(i, e)| push(format!("pair {i}"), e));
        self.fused.iter().for_each(|e| push("fused".into(), e));
        push("reference".into(), &self.reference);
        numbers
    }
}

/// Direction of a rotation vector; the optical axis for a zero vector.
fn axis(w: &Vector3<f64>) -> Vector3<f64> {
    w.try_normalize(f64::MIN_POSITIVE).unwrap_or(Vector3::z())
}

/// Two unit vectors perpendicular to `normal`: to the right, and as far down as possible. If `normal` is near the y
/// axis, z takes the place of down.
fn across(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let down = if normal.y.abs() < 0.9 { Vector3::y() } else { Vector3::z() };
    let right = down.cross(normal).normalize();
    [right, normal.cross(&right)]
}

/// The sphere from afar, with the reference a little off the middle.
fn globe(directions: &Directions, title: &str) -> String {
    let [right, down] = across(&directions.reference);
    let towards = (directions.reference + (right - down * 0.7) * ASIDE).normalize();
    let [right, down] = across(&towards);
    let seen = |p: &Vector3<f64>| ([p.dot(&right), p.dot(&down)], p.dot(&towards) >= 0.0);
    let mut svg = titled(title);
    // Holds the unit circle.
    let axes = [(); 2].map(|()| Axis::over(-1.04..1.04, 1.0));
    let mut plot = Plot::new(&mut svg, [[SIDES, TITLE], SIZE.map(|x| x - SIDES)], axes).downwards();
    for line in graticule() {
        for ends in line.windows(2) {
            let [(a, near), (b, also)] = [seen(&ends[0]), seen(&ends[1])];
            if near && also {
                plot.line([a, b], Style::line(Rgb::BLACK, 1.0).opacity(0.22));
            }
        }
    }
    let rim = (0..=SAMPLES).map(|i| {
        let (sin, cos) = turn(i, SAMPLES).sin_cos();
        [cos, sin]
    });
    plot.line(rim, Style::line(Rgb::BLACK, 1.0).opacity(0.6));
    directions.draw(&mut plot, seen);
    svg.finish()
}

fn titled(title: &str) -> Svg {
    let mut svg = Svg::new(SIZE);
    svg.text([SIZE[0] / 2.0, TITLE / 2.0], WORDS[0], Anchor::Middle, title);
    svg
}

/// The surroundings of the reference, by arc length.
///
/// * `reach`: least visible distance from the reference, rad.
/// * `(unit, factor)`: unit of the axes, and its number in 1 rad.
fn zoom(directions: &Directions, title: &str, reach: f64, (unit, factor): (&str, f64)) -> String {
    let by_arc = directions.by_arc();
    let unrolled = |p: &Vector3<f64>| (by_arc(p).map(|x| x * factor), true);
    let limit = 1.1 * factor * reach.max(LEAST_REACH);
    let mut svg = titled(title);
    let axes = [(); 2].map(|()| Axis::over(-limit..limit, 6.0));
    let [left, below] = LABELS;
    let corners = [[left, TITLE], [SIZE[0] - SIDES, SIZE[1] - below]];
    let mut plot = Plot::new(&mut svg, corners, axes).downwards();
    plot.frame(true);
    plot.label_x(&format!("across, {unit}"), WORDS[1]);
    plot.label_y(&format!("down, {unit}"), WORDS[1], left - 10.0);
    directions.draw(&mut plot, unrolled);
    svg.finish()
}

impl Directions {
    /// Places in the plane that touches the sphere at the reference, by arc length, rad.
    fn by_arc(&self) -> impl Fn(&Vector3<f64>) -> Point {
        let (reference, [right, down]) = (self.reference, across(&self.reference));
        move |p| {
            let [x, y] = [p.dot(&right), p.dot(&down)];
            let arc = x.hypot(y).atan2(p.dot(&reference));
            let scale = if arc > 0.0 { arc / x.hypot(y).max(f64::MIN_POSITIVE) } else { 0.0 };
            [x * scale, y * scale]
        }
    }

    fn reach(&self) -> f64 {
        let all = self.pairs.iter().chain(&self.fused).flat_map(self.by_arc());
        all.fold(0.0, |most: f64, x| most.max(x.abs()))
    }

    /// * `place`: position of a direction in the plane, and whether it is on the near side.
    fn draw(&self, plot: &mut Plot<'_>, place: impl Fn(&Vector3<f64>) -> (Point, bool)) {
        let [single, fused] = [SERIES[0].light, SERIES[1].light];
        for p in &self.pairs {
            let (at, near) = place(p);
            let hollow = Style::line(single, 1.0);
            let style = if near { Style::filled(single).opacity(0.6) } else { hollow };
            plot.dots([at], DOT, style);
        }
        let (at, _) = place(&self.reference);
        plot.cross(at, 8.0, Style::line(Rgb::BLACK, 2.0));
        if let Some(p) = &self.fused {
            let (at, near) = place(p);
            let style = if near { Style::filled(fused) } else { Style::line(fused, 2.0) };
            plot.dots([at], DOT + 2.0, style);
        }
    }
}

/// Meridians about the y axis, and circles of latitude.
fn graticule() -> Vec<Vec<Vector3<f64>>> {
    let point = |latitude: f64, longitude: f64| {
        let (up, flat) = latitude.sin_cos();
        Vector3::new(flat * longitude.sin(), up, flat * longitude.cos())
    };
    let meridians = (0..360 / GRID_DEG).map(|i| {
        let longitude = turn(i, 360 / GRID_DEG);
        (-SAMPLES / 4..=SAMPLES / 4).map(|j| point(turn(j, SAMPLES), longitude)).collect()
    });
    let circles = (-90 / GRID_DEG + 1..90 / GRID_DEG).map(|i| {
        let latitude = turn(i, 360 / GRID_DEG);
        (0..=SAMPLES).map(|j| point(latitude, turn(j, SAMPLES))).collect()
    });
    meridians.chain(circles).collect()
}

/// `i` of `n` parts of a full turn, rad.
fn turn(i: i16, n: i16) -> f64 {
    TAU * f64::from(i) / f64::from(n)
}
