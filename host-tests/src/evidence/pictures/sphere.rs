//! Estimates of single pairs on the unit sphere, with the fused one and the reference, as the paper
//! pictures its fusion (its eqs 20-22): baseline directions `t^k` and rotation axes `v^k`.

use std::f64::consts::{PI, TAU};

use anyhow::Result;
use nalgebra::Vector3;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use stereo_selfcal::{Extrinsics, so3};

use crate::chart::palette::SERIES;
use crate::evidence::report::{Csv, Entry, Figure, Picture, Sample};

const SIZE: (u32, u32) = (460, 460);
const DOT: u32 = 3;
const TITLE: (&str, u32) = ("sans-serif", 18);
const LABEL: (&str, u32) = ("sans-serif", 15);

/// Left and right of the sphere, as much as its title takes above it, px.
const SIDES: u32 = 14;

/// Half of what a picture of the surroundings shows at least, rad.
const LEAST_REACH: f64 = 1e-4;

/// Of the sphere's grid, degrees, and samples along each of its lines.
const GRID_DEG: i16 = 30;
const SAMPLES: i16 = 72;

/// The picture of the whole sphere is not seen along the estimates, which would hide its curvature, rad.
const ASIDE: f64 = 0.5;

/// What a run estimated.
#[derive(Debug, Clone)]
pub struct Estimates {
    /// Of each pair alone.
    pub pairs: Vec<Extrinsics<f64>>,
    /// Of all pairs.
    pub fused: Option<Extrinsics<f64>>,
    /// What they are compared with.
    pub reference: Extrinsics<f64>,
}

/// Directions on the sphere.
struct Directions {
    pairs: Vec<Vector3<f64>>,
    fused: Option<Vector3<f64>>,
    reference: Vector3<f64>,
}

/// Four panels: `t^k` on the sphere and around the reference, `v^k` likewise.
///
/// * `name`: of the CSV file.
///
/// # Errors
/// If a picture cannot be drawn.
pub fn sphere_figure(name: &str, estimates: &Estimates, command: &str) -> Result<Figure> {
    let t = estimates.directions(|e| e.translation().into_inner());
    let v = estimates.directions(|e| axis(&so3::log(e.rotation())));
    let mut panels = Vec::new();
    let kinds =
        [(&t, "baseline direction t", "mrad", 1e3), (&v, "rotation axis v", "degrees", 180.0 / PI)];
    for (directions, what, unit, factor) in kinds {
        let [whole, near] =
            [format!("{what} of each pair"), format!("{what}, around the reference")];
        panels.push((Picture::Svg(globe(directions, &whole)?), whole));
        panels.push((Picture::Svg(zoom(directions, &near, unit, factor)?), near));
    }
    let angle = so3::log(estimates.reference.rotation()).norm().to_degrees();
    Ok(Figure {
        panels,
        legend: vec![
            Entry::new(Sample::Dots, Some(SERIES[0]), "one pair"),
            Entry::new(Sample::Dots, Some(SERIES[1]), "fused"),
            Entry::new(Sample::Dots, None, "reference (a cross)"),
        ],
        caption: format!(
            "Every pair's baseline direction t^k and rotation axis v^k on the unit sphere; beside each \
             globe the surroundings of the reference, by arc length. Hollow: on the far side. The rotation is by \
             {angle:.2} degrees: the smaller it is, the wider its axes scatter."
        ),
        command: command.to_owned(),
        numbers: estimates.numbers(name),
    })
}

impl Estimates {
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

/// Direction of a rotation vector; the optical axis where there is none.
fn axis(w: &Vector3<f64>) -> Vector3<f64> {
    w.try_normalize(f64::MIN_POSITIVE).unwrap_or(Vector3::z())
}

/// Two directions across `normal`: as far right and as far down as may be.
fn across(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let down = if normal.y.abs() < 0.9 { Vector3::y() } else { Vector3::z() };
    let right = down.cross(normal).normalize();
    [right, normal.cross(&right)]
}

/// The sphere as seen from afar, the reference a little aside of the middle.
fn globe(directions: &Directions, title: &str) -> Result<String> {
    let [right, down] = across(&directions.reference);
    let towards = (directions.reference + (right - down * 0.7) * ASIDE).normalize();
    let [right, down] = across(&towards);
    let seen = |p: &Vector3<f64>| ((p.dot(&right), p.dot(&down)), p.dot(&towards) >= 0.0);
    drawn(title, |plane| {
        for line in graticule() {
            for ends in line.windows(2) {
                let [(a, near), (b, also)] = [seen(&ends[0]), seen(&ends[1])];
                if near && also {
                    plane.draw(&PathElement::new([a, b], BLACK.mix(0.22)))?;
                }
            }
        }
        let rim = (0..=SAMPLES).map(|i| {
            let (sin, cos) = turn(i, SAMPLES).sin_cos();
            (cos, sin)
        });
        plane.draw(&PathElement::new(rim.collect::<Vec<_>>(), BLACK.mix(0.6)))?;
        directions.draw(plane, seen)
    })
}

/// By arc length around the reference.
///
/// * `factor`: of the unit in 1 rad.
fn zoom(directions: &Directions, title: &str, unit: &str, factor: f64) -> Result<String> {
    let [right, down] = across(&directions.reference);
    let unrolled = |p: &Vector3<f64>| {
        let [x, y] = [p.dot(&right), p.dot(&down)];
        let arc = x.hypot(y).atan2(p.dot(&directions.reference));
        let scale = if arc > 0.0 { factor * arc / x.hypot(y).max(f64::MIN_POSITIVE) } else { 0.0 };
        ((x * scale, y * scale), true)
    };
    let all = directions.pairs.iter().chain(&directions.fused);
    let reach = all.fold(LEAST_REACH * factor, |most: f64, p| {
        let ((x, y), _) = unrolled(p);
        most.max(x.abs()).max(y.abs())
    });
    let limit = 1.1 * reach;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&root);
        let mut chart = chart
            .margin(8)
            .caption(title, TITLE)
            .x_label_area_size(40)
            .y_label_area_size(58)
            .build_cartesian_2d(-limit..limit, limit..-limit)?;
        chart
            .configure_mesh()
            .x_desc(format!("across, {unit}"))
            .y_desc(format!("down, {unit}"))
            .x_labels(6)
            .y_labels(6)
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .label_style(LABEL)
            .draw()?;
        directions.draw(chart.plotting_area(), unrolled)?;
        root.present()?;
    }
    Ok(svg)
}

type Plane<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// A picture that holds the unit circle, y down.
fn drawn(title: &str, draw: impl FnOnce(&Plane<'_>) -> Result<()>) -> Result<String> {
    let limit = 1.04;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let chart = ChartBuilder::on(&root)
            .margin_left(SIDES)
            .margin_right(SIDES)
            .caption(title, TITLE)
            .build_cartesian_2d(-limit..limit, limit..-limit)?;
        draw(chart.plotting_area())?;
        root.present()?;
    }
    Ok(svg)
}

impl Directions {
    /// * `place`: where a direction is in the plane, and whether on the near side.
    fn draw(
        &self,
        plane: &Plane<'_>,
        place: impl Fn(&Vector3<f64>) -> ((f64, f64), bool),
    ) -> Result<()> {
        for p in &self.pairs {
            let (at, near) = place(p);
            let color = SERIES[0].light;
            let style = if near { color.mix(0.6).filled() } else { color.stroke_width(1) };
            plane.draw(&Circle::new(at, DOT, style))?;
        }
        let (at, _) = place(&self.reference);
        plane.draw(&Cross::new(at, 8, BLACK.stroke_width(2)))?;
        if let Some(fused) = &self.fused {
            let (at, near) = place(fused);
            let color = SERIES[1].light;
            let style = if near { color.filled() } else { color.stroke_width(2) };
            plane.draw(&Circle::new(at, DOT + 2, style))?;
        }
        Ok(())
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
