//! Runs of the calibrator over recorded pairs of a rig that is knocked, drifts or rests.
//!
//! The pairs of a recording arrive in random order, each match with a probability of 3/4, and the run starts from the
//! reference extrinsics. A knock turns the right camera, or moves it so that the baseline turns.

use std::path::Path;

use anyhow::{Result, ensure};
use nalgebra::{Rotation3, Unit, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rigs::data::{Dataset, Match, in_f64};
use sim::stats::rms;
use stereo_selfcal::batch::{RayPair, row_offset};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::{Calibrator, Cameras, Config, Extrinsics, FactoryCalibration};

use super::figures::count;
use crate::recorded_sets::GATE_PX;
use crate::rivals::CAPACITY;

/// Pairs before a knock.
pub(super) const BEFORE: usize = 24;

/// Largest errors of rows and disparities of a calibration that is right, px: limits of a default [`Config`].
const RIGHT: [f64; 2] = [1.0, 2.0];

/// Probability of a match.
const KEPT: f64 = 0.75;

/// A change of the rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Fate {
    /// A knock after [`BEFORE`] pairs, degrees.
    Knock(Axis, f64),
    /// A turn with every pair about an axis of each run, rad.
    Drift(f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Axis {
    Pitch,
    Yaw,
    Roll,
    /// The baseline turns forward, the cameras do not.
    Baseline,
}

impl Axis {
    pub(super) const ALL: [(Self, &str); 4] = [
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
pub(super) struct Recording {
    pub(super) name: String,
    cameras: Cameras<f64>,
    factory: FactoryCalibration<f32>,
    rig: Extrinsics<f64>,
    pairs: Vec<Vec<Seen>>,
}

impl Recording {
    pub(super) fn load(place: &Path) -> Result<Self> {
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
    pub(super) fn run(&self, fate: Fate, pairs: usize, seed: u64) -> Result<Vec<Judged>> {
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
pub(super) struct Judged {
    pub(super) armed: bool,
    /// Errors of rows and disparities, px.
    pub(super) off: [f64; 2],
    /// Whether the estimate was applied after the pair.
    pub(super) applied: bool,
}

impl Judged {
    /// Whether the row offsets are within 1 px of the true ones and the disparities within 2 px, RMS over the matches of
    /// the pair that are within 2 px of their true row.
    pub(super) fn is_right(&self) -> bool {
        self.off.into_iter().zip(RIGHT).all(|(off, most)| off <= most)
    }
}
