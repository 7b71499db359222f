//! Campaigns of alarms over recorded pairs: knocks that must be answered, and rest that must not raise an alarm.
//!
//! The pairs of a recording arrive in random order, each match with a probability of 3/4, and the run starts from the
//! reference extrinsics. A knock turns the right camera, or moves it so that the baseline turns. The definitions judge
//! by the truth, which is the reference with its knock:
//! - The calibration in use is *right* if its row offsets are within 1 px of the true ones and its disparities within
//!   2 px, RMS over the matches of the pair that are within 2 px of their true row.
//! - An *alarm* is a verdict that forbids arming. It is *false* if the calibration in use is right.
//! - A knock is *missed* if the verdict on the tenth pair after it permits arming with a wrong calibration in use.
//! - A run has *recovered* with the first pair from which on the calibration is right and the verdict permits arming.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use nalgebra::{Rotation3, Unit, Vector2, Vector3};
use page::chart::curves::{self, Curve, Line, Scale};
use page::chart::palette;
use page::report::{Entry, Mark};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use rigs::data::{Dataset, Match, in_f64};
use sim::run::{LensTracking, progress};
use sim::stats::rms;
use stereo_selfcal::batch::{RayPair, row_offset};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::{Calibrator, Cameras, Config, Extrinsics, FactoryCalibration};

use super::chance::Chance;
use super::figures::{Figure, count, counted, quantile_of, shared};
use super::{Campaign, Measure, Request, Row};
use crate::recorded_sets::GATE_PX;
use crate::rivals::CAPACITY;
use crate::sections::alone;

/// Names of the campaigns.
pub(crate) const NAMES: [&str; 2] = ["knocks", "rest"];

/// Recordings with reference extrinsics.
const SETS: [&str; 3] = ["opencv_chess_corners", "opencv_chess_sift", "oak_sift"];

/// Sizes of knocks, degrees.
const SIZES: [f64; 7] = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 3.0];

/// Pairs before a knock, and after it.
const BEFORE: usize = 24;
const AFTER: usize = 40;

/// Pairs after which a knock that was not answered is missed.
const PATIENCE: usize = 10;

/// Pairs of an hour at 10 Hz.
const HOUR: f64 = 36_000.0;

/// Pairs of a run at rest.
const REST: usize = 3000;

/// Pairs whose verdicts count as one for the chance of a share, because a verdict stays.
const RUN_OF_PAIRS: usize = 100;

/// Largest errors of rows and disparities of a calibration that is right, px: limits of a default [`Config`].
const RIGHT: [f64; 2] = [1.0, 2.0];

/// Probability of a match.
const KEPT: f64 = 0.75;

/// Turn with every pair of a rig that drifts, rad.
const DRIFT: f64 = 1e-5;

const KNOCKED: &str = "runs, wrong by it, missed, alarm after, alarm after at most, recovered, recovered after, \
    recovered after at most, rows px, depth px";
const AT_REST: &str = "pairs, armed, false alarms, false alarms an hour, wrong and armed, applied";

pub(super) fn campaigns() -> Vec<Campaign> {
    let campaign = |name, columns, trials, rows| Campaign {
        name,
        trials,
        seeds: &[11_000_000],
        lens: LensTracking::Report,
        columns,
        quick: None,
        worst_first: None,
        measure: Measure::Rows(rows),
        chart: None,
    };
    let [of_knocks, of_rest] = NAMES;
    let knocked = campaign(of_knocks, KNOCKED, 24, knocks);
    vec![Campaign { chart: Some(chart), ..knocked }, campaign(of_rest, AT_REST, 12, rest)]
}

/// A change of the rig.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fate {
    /// A knock after [`BEFORE`] pairs, degrees.
    Knock(Axis, f64),
    /// A turn with every pair about an axis of each run, rad.
    Drift(f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Axis {
    Pitch,
    Yaw,
    Roll,
    /// The baseline turns forward, the cameras do not.
    Baseline,
}

impl Axis {
    const ALL: [(Self, &str); 4] = [
        (Self::Pitch, "pitch"),
        (Self::Yaw, "yaw"),
        (Self::Roll, "roll"),
        (Self::Baseline, "baseline"),
    ];
}

/// A change of the right camera: `p_r' = turn p_r + shift`, with the baseline as unit.
struct Change {
    turn: Rotation3<f64>,
    shift: Vector3<f64>,
}

impl Change {
    fn knock(axis: Axis, degrees: f64, rig: &Extrinsics<f64>) -> Self {
        let turn = |axis| Rotation3::new(axis * degrees.to_radians());
        let (none, still) = (Rotation3::identity(), Vector3::zeros());
        match axis {
            Axis::Pitch => Self { turn: turn(Vector3::x()), shift: still },
            Axis::Yaw => Self { turn: turn(Vector3::y()), shift: still },
            Axis::Roll => Self { turn: turn(Vector3::z()), shift: still },
            Axis::Baseline => {
                let t = rig.translation().into_inner();
                Self { turn: none, shift: turn(Vector3::y()) * t - t }
            }
        }
    }

    fn of(&self, rig: &Extrinsics<f64>) -> Result<Extrinsics<f64>> {
        let r = self.turn * rig.rotation();
        let t = self.turn * rig.translation().into_inner() + self.shift;
        Ok(Extrinsics::try_new(r.matrix(), &t)?)
    }
}

/// A match of a recording.
#[derive(Debug, Clone)]
struct Seen {
    given: Match,
    rays: RayPair<f64>,
    /// Depth in the right camera, baselines; `None` if the rays do not meet in front of it.
    depth: Option<f64>,
    /// Whether it is within [`GATE_PX`] of its true row.
    good: bool,
}

/// A recording, ready for changes.
struct Recording {
    name: String,
    cameras: Cameras<f64>,
    factory: FactoryCalibration<f32>,
    rig: Extrinsics<f64>,
    pairs: Vec<Vec<Seen>>,
}

impl Recording {
    fn load(place: &Path) -> Result<Self> {
        let set = Dataset::find(place)?;
        ensure!(set.pairs.len() > 1, "{}: alarms need two pairs or more", set.name);
        ensure!(set.rigs.is_empty(), "{}: the rig moves, and alarms need one at rest", set.name);
        let (cameras, rig) = (set.cameras::<f64>()?, set.truth::<f64>()?);
        let rotations = RectifyingRotations::from(&rig);
        let gate = GATE_PX / cameras.mean_focal();
        let seen = |m: &Match| {
            let rays = cameras.rays(&m.correspondence()).ok()?;
            let good = row_offset(&rotations, &rays).is_some_and(|offset| offset.abs() <= gate);
            Some(Seen { given: *m, depth: depth(&rig, &rays), rays, good })
        };
        let pairs = set.pairs.iter().map(|pair| pair.iter().filter_map(seen).collect()).collect();
        let factory = FactoryCalibration::new(set.cameras()?, set.truth()?);
        Ok(Self { name: set.name, cameras, factory, rig, pairs })
    }

    /// The match after a change; `None` if its point leaves the right image.
    fn changed(&self, seen: &Seen, change: &Change) -> Option<Seen> {
        let [x, y] = seen.rays.right();
        let p = change.turn * Vector3::new(x, y, 1.0);
        let p = seen.depth.map_or(p, |depth| p + change.shift / depth);
        let ray = (p.z > 0.0).then(|| Vector2::new(p.x, p.y) / p.z)?;
        let [ur, vr] = self.cameras.right.pixel(ray).ok()?;
        let [width, height] = self.cameras.right.intrinsics().size.map(|n| f64::from(n) - 1.0);
        if !((0.0..=width).contains(&ur) && (0.0..=height).contains(&vr)) {
            return None;
        }
        let rays = RayPair::try_new(seen.rays.left(), [ray.x, ray.y])?;
        Some(Seen { given: Match { ur, vr, ..seen.given }, rays, ..*seen })
    }

    /// Runs the calibrator over `count` pairs, as on a vehicle.
    fn run(&self, fate: Fate, pairs: usize, seed: u64) -> Result<Vec<Judged>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let axis = Unit::new_normalize(Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)));
        let still = || Change { turn: Rotation3::identity(), shift: Vector3::zeros() };
        let mut calibrator =
            Box::new(Calibrator::<f32, CAPACITY>::new(Config::robust(), &self.factory));
        let mut last = self.pairs.len();
        let mut judged = Vec::with_capacity(pairs);
        for number in 0..pairs {
            let change = match fate {
                Fate::Knock(axis, degrees) if number >= BEFORE => {
                    Change::knock(axis, degrees, &self.rig)
                }
                Fate::Knock(..) => still(),
                Fate::Drift(rad) => {
                    let turn = Rotation3::from_axis_angle(&axis, rad * count(number));
                    Change { turn, ..still() }
                }
            };
            // Another pair than the last one, so that no scene repeats at once.
            last = (last + rng.random_range(1..self.pairs.len())) % self.pairs.len();
            let kept: Vec<&Seen> =
                self.pairs[last].iter().filter(|_| rng.random_bool(KEPT)).collect();
            let pair: Vec<Seen> =
                kept.into_iter().filter_map(|seen| self.changed(seen, &change)).collect();
            // A pair that is not fused leaves the estimate as it is.
            let _ = calibrator.take_pair(pair.iter().map(|seen| seen.given.correspondence()));
            let in_use = in_f64(&calibrator.in_use().extrinsics);
            let off = self.off_px(&pair, &in_use, &change.of(&self.rig)?);
            let armed = calibrator.verdict().may_arm;
            let applied = calibrator.verdict().should_apply && calibrator.apply().is_ok();
            judged.push(Judged { armed, off, applied });
        }
        Ok(judged)
    }

    /// Errors of rows and of disparities of a calibration, RMS over the good matches, px.
    fn off_px(&self, pair: &[Seen], in_use: &Extrinsics<f64>, truth: &Extrinsics<f64>) -> [f64; 2] {
        let [used, truth] = [in_use, truth].map(RectifyingRotations::from);
        let off = |seen: &Seen| {
            let [a, b] = [&used, &truth].map(|of| rectified(of, &seen.rays));
            let ([row, disparity], [true_row, true_disparity]) = (a?, b?);
            Some([row - true_row, disparity - true_disparity])
        };
        let all: Vec<[f64; 2]> = pair.iter().filter(|seen| seen.good).filter_map(off).collect();
        let focal = self.cameras.mean_focal();
        [0, 1].map(|part| focal * rms(all.iter().map(|off| off[part])).unwrap_or(f64::INFINITY))
    }
}

/// Difference of the rows and disparity of a match, unit focal length.
fn rectified(rotations: &RectifyingRotations<f64>, rays: &RayPair<f64>) -> Option<[f64; 2]> {
    let sides = [(rotations.left(), rays.left()), (rotations.right(), rays.right())];
    let [left, right] = sides.map(|(r, [x, y])| r * Vector3::new(x, y, 1.0));
    (left.z > 0.0 && right.z > 0.0)
        .then(|| [right.y / right.z - left.y / left.z, left.x / left.z - right.x / right.z])
}

/// Depth in the right camera of the point nearest to both rays, baselines.
fn depth(rig: &Extrinsics<f64>, rays: &RayPair<f64>) -> Option<f64> {
    let [a, b] = [rays.left(), rays.right()].map(|[x, y]| Vector3::new(x, y, 1.0));
    let (a, t) = (rig.rotation() * a, rig.translation().into_inner());
    // `|b depth - a other - t|^2` is least.
    let (aa, ab, bb, at, bt) = (a.dot(&a), a.dot(&b), b.dot(&b), a.dot(&t), b.dot(&t));
    let depth = (aa * bt - ab * at) / (aa * bb - ab * ab);
    (depth > 0.0 && depth.is_finite()).then_some(depth)
}

/// A pair of a run: the verdict, and the truth about the calibration in use.
#[derive(Debug, Clone, Copy)]
struct Judged {
    armed: bool,
    /// Errors of rows and disparities, px.
    off: [f64; 2],
    /// Whether the estimate was applied after the pair.
    applied: bool,
}

impl Judged {
    fn is_right(&self) -> bool {
        self.off.into_iter().zip(RIGHT).all(|(off, most)| off <= most)
    }
}

fn runs(
    recording: &Recording,
    fate: Fate,
    pairs: usize,
    request: &Request,
) -> Result<Vec<Vec<Judged>>> {
    let pairs = request.pairs.unwrap_or(pairs);
    let seeds = request.seeds.iter().flat_map(|seed| *seed..*seed + u64::from(request.trials));
    seeds.collect::<Vec<_>>().into_par_iter().map(|seed| recording.run(fate, pairs, seed)).collect()
}

fn recordings(request: &Request) -> Result<Vec<Recording>> {
    let load = |place: &Path| Recording::load(place).with_context(|| place.display().to_string());
    if request.recordings.is_empty() {
        SETS.iter().map(|name| load(Path::new(name))).collect()
    } else {
        request.recordings.iter().map(|place| load(place)).collect()
    }
}

fn knocks(request: &Request) -> Result<Vec<Row>> {
    let recordings = recordings(request)?;
    let cases = recordings.iter().flat_map(|of| {
        let sizes = |axis| SIZES.iter().map(move |size| (axis, *size));
        let all = Axis::ALL.into_iter().flat_map(sizes);
        all.map(move |((axis, word), size)| (of, axis, size, format!("{}/{word} {size}", of.name)))
    });
    let cases: Vec<_> = cases.filter(|(.., case)| request.takes(case)).collect();
    let bar = progress::over(cases.len(), "knocks");
    let mut rows = Vec::new();
    for (of, axis, size, case) in cases {
        let runs = runs(of, Fate::Knock(axis, size), BEFORE + AFTER, request)?;
        rows.push(Row { case, figures: answered(&runs) });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// Share of the knocks that are not missed, one curve an axis, over all recordings.
fn chart(rows: &[Row]) -> String {
    let of_axis = |(i, (_, word)): (usize, (Axis, &str))| {
        let share = |size: f64| {
            let of_size =
                || rows.iter().filter(|row| row.case.ends_with(&format!("/{word} {size}")));
            let sum =
                |name| of_size().filter_map(|row| row.figure(name)).map(|f| f.value).sum::<f64>();
            1.0 - sum("missed") / sum("runs")
        };
        let points = SIZES.iter().map(|size| (*size, Some(share(*size)))).collect();
        Curve { color: Some(palette::series(i)), line: Line::Thin, points }
    };
    let curves: Vec<Curve> = Axis::ALL.into_iter().enumerate().map(of_axis).collect();
    let entry =
        |(curve, (_, word)): (&Curve, (Axis, &str))| Entry::new(Mark::Line, curve.color, word);
    let legend: Vec<Entry> = curves.iter().zip(Axis::ALL).map(entry).collect();
    let x = Scale { name: "knock, degrees".into(), log: true };
    alone(&curves::shares("answered within ten pairs", &x, &curves), &legend)
}

/// Figures of knocked runs.
fn answered(runs: &[Vec<Judged>]) -> Vec<Figure> {
    let after = || runs.iter().filter_map(|run| run.get(BEFORE..));
    let wrong = after().filter(|run| run.first().is_some_and(|judged| !judged.is_right())).count();
    let missed = |run: &&[Judged]| {
        run.get(PATIENCE - 1).is_some_and(|judged| judged.armed && !judged.is_right())
    };
    let alarms: Vec<f64> = after()
        .filter_map(|run| run.iter().position(|judged| !judged.armed))
        .map(|at| count(at + 1))
        .collect();
    let good = |judged: &Judged| judged.armed && judged.is_right();
    let recovered: Vec<f64> = after()
        .map(|run| run.iter().rposition(|judged| !good(judged)).map_or(0, |at| at + 1))
        .filter(|at| *at < AFTER)
        .map(|at| count(at + 1))
        .collect();
    let last = |part: usize| {
        let off = runs.iter().filter_map(|run| run.last()).map(|judged| judged.off[part]);
        quantile_of(["rows px", "depth px"][part], 0.5, off, runs.len())
    };
    vec![
        counted("runs", runs.len()),
        counted("wrong by it", wrong),
        counted("missed", after().filter(missed).count()),
        quantile_of("alarm after", 0.5, alarms.iter().copied(), runs.len()),
        quantile_of("alarm after at most", 1.0, alarms.iter().copied(), runs.len()),
        counted("recovered", recovered.len()),
        quantile_of("recovered after", 0.5, recovered.iter().copied(), runs.len()),
        quantile_of("recovered after at most", 1.0, recovered.iter().copied(), runs.len()),
        last(0),
        last(1),
    ]
}

fn rest(request: &Request) -> Result<Vec<Row>> {
    let fates = [("rest", Fate::Drift(0.0)), ("drift of 1e-5 rad a pair", Fate::Drift(DRIFT))];
    let recordings = recordings(request)?;
    let cases = recordings
        .iter()
        .flat_map(|of| fates.map(|(word, fate)| (of, fate, format!("{}/{word}", of.name))));
    let cases: Vec<_> = cases.filter(|(.., case)| request.takes(case)).collect();
    let bar = progress::over(cases.len(), "recordings");
    let mut rows = Vec::new();
    for (of, fate, case) in cases {
        let runs = runs(of, fate, REST, request)?;
        rows.push(Row { case, figures: at_rest(&runs) });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// Figures of runs without a knock, after their first [`BEFORE`] pairs.
fn at_rest(runs: &[Vec<Judged>]) -> Vec<Figure> {
    let settled = || runs.iter().filter_map(|run| run.get(BEFORE - 1..));
    let pairs: usize = settled().map(|run| run.len() - 1).sum();
    let begins = |two: &&[Judged]| two[0].armed && !two[1].armed && two[1].is_right();
    let alarms = settled().map(|run| run.windows(2).filter(begins).count()).sum();
    let wrong = settled().flatten().filter(|judged| judged.armed && !judged.is_right()).count();
    let applied = settled().flat_map(|run| &run[1..]).filter(|judged| judged.applied).count();
    let armed = settled().flat_map(|run| &run[1..]).filter(|judged| judged.armed).count();
    let an_hour = count(alarms) * HOUR / count(pairs);
    let chance = Chance::mean_count(an_hour * count(pairs) / HOUR, 1);
    vec![
        counted("pairs", pairs),
        Figure {
            chance: Chance::Share(count(pairs / RUN_OF_PAIRS)),
            ..shared("armed", [armed, pairs])
        },
        counted("false alarms", alarms),
        Figure { name: "false alarms an hour", value: an_hour, chance },
        counted("wrong and armed", wrong),
        counted("applied", applied),
    ]
}
