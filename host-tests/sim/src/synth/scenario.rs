//! Scenarios: scenes that vary from pair to pair, with the truth of each pair.
//!
//! Varying parameters and points are drawn from separate streams of random numbers. So two scenarios with the same seed
//! and equal scenes have the same points.

use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, UnitCircle, UnitSphere};
use stereo_selfcal::Extrinsics;

use super::depth::Depth;
use super::disturbance::{Disturbance, Disturber};
use super::flight::Part;
use super::lens_error::LensError;
use super::mistake::Mistake;
use super::points::{Landmarks, Points};
use super::rig::turned;
use super::scenario_kind::{NARROW_BAND, ScenarioKind};
use super::scene::{Scene, SynthPair};
use super::witness::{Witnessed, Witnesses, Witnessing};
use rigs::data::{Dataset, Rig};

/// A scenario and its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Quantities that vary over the pairs.
    pub kind: ScenarioKind,
    /// Parameters that are the same for all pairs, unless `kind` varies them. A kind that draws depths, numbers of
    /// matches or bands draws them within `depth`, `matches` and `band`. It keeps a `depth` that is a plane or a
    /// mixture.
    pub scene: Scene,
    /// Number of pairs of a run.
    pub pairs: usize,
    /// Turn of the right camera, degrees: in mid run for a step or a flight, with every pair for a drift,
    /// at most for a warm-up, and before the second drive for two drives.
    pub turn_deg: f64,
    /// Axis of `turn_deg`, right camera frame; `None`: random, new for every seed.
    pub axis: Option<[f64; 3]>,
    /// Sensors that separate the yaw of the mount from that of the lenses.
    pub witnesses: Witnesses,
    /// A mistake in all matches.
    pub mistake: Option<Mistake>,
    /// Whether the run starts from a factory calibration: the rig of `scene`, without `off_deg`.
    pub commissioned: bool,
    /// Disturbances of a pair; the vibration of a flight is part of its motion.
    pub disturbance: Disturbance,
    /// Turn of the right camera in addition to the rig of the scene, about a random axis that is new for every seed,
    /// degrees.
    pub off_deg: f64,
    /// Whether lens errors drawn from the prior, new for every seed, are added to those of the scene.
    pub lens_prior: bool,
    /// Change of the right camera's focal length from the first pair to the last, relative; linear.
    pub lens_warming: f64,
    /// Standard deviation of the matching error that a landmark keeps, of each coordinate, px; for parked landmarks and
    /// creeping. In every pair the noise of the scene is added.
    pub landmark_px: f64,
    /// Motion of the landmarks through the images from pair to pair, px; for parked landmarks and creeping.
    pub creep_px: f64,
}

/// One pair of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioPair {
    /// The scene of this pair, with its rig at this moment.
    pub scene: Scene,
    /// The rig without its disturbance, which an estimate over many pairs can follow. The rig of a flight includes its
    /// vibration.
    pub steady: Extrinsics<f64>,
    /// Correspondences and their truth.
    pub pair: SynthPair,
    /// Ranges and tracks after this pair.
    pub witnessed: Witnessed,
}

/// Fewest matches of a heterogeneous pair, if its scene has as many.
const FEW_MATCHES: usize = 48;

/// Ratio of all depths at the top of a climb to those at its foot.
const CEILING: f64 = 1000.0;

/// Time constant of a warm-up, as a share of the run.
const WARM_UP: f64 = 0.1;

/// Least and largest slant of a random plane, degrees.
const SLANT_DEG: [f64; 2] = [15.0, 60.0];

/// Stream of the random numbers for varying parameters; the points are drawn from stream 0.
const STREAM: u64 = 1;

impl Scenario {
    /// The scenario of a kind with its default parameters.
    #[must_use]
    pub fn new(kind: ScenarioKind, pairs: usize) -> Self {
        Self {
            kind,
            scene: kind.scene(),
            pairs,
            turn_deg: kind.turn_deg(),
            axis: None,
            witnesses: Witnesses::default(),
            mistake: None,
            commissioned: false,
            disturbance: Disturbance {
                vibration_deg: kind.vibration_deg(),
                ..Disturbance::default()
            },
            off_deg: 0.0,
            lens_prior: false,
            lens_warming: 0.0,
            landmark_px: if kind.keeps_landmarks() { 0.3 } else { 0.0 },
            creep_px: if kind == ScenarioKind::Creeping { 2.0 } else { 0.0 },
        }
    }

    /// Number, from 0, of the first pair after the turn of a step, the knock of a flight or the change of the lenses, which
    /// are in mid run.
    #[must_use]
    pub fn turned_from(&self) -> usize {
        self.pairs.div_ceil(2)
    }

    /// Number, from 0, of the first pair of the second of two drives.
    fn starts_again(&self) -> usize {
        self.pairs * 3 / 4
    }

    /// The turn of the right camera at a pair, in units of `turn_deg`.
    fn turns(&self, pair: usize) -> Result<f64> {
        let once = |from: usize| f64::from(u8::from(pair >= from));
        let after = |share: f64| libm::exp(-share / WARM_UP);
        Ok(match (self.kind, self.flown(pair)?) {
            (ScenarioKind::Step, _) => once(self.turned_from()),
            (ScenarioKind::Drives, _) => once(self.starts_again()),
            (ScenarioKind::Drift, _) => f64::from(u32::try_from(pair)?),
            (ScenarioKind::WarmUp, flown) if flown < 0.5 => 1.0 - after(flown),
            (ScenarioKind::WarmUp, flown) => (1.0 - after(0.5)) * after(flown - 0.5),
            _ => 0.0,
        })
    }

    /// The rig of each pair, with its disturbance.
    ///
    /// # Errors
    /// As [`Scenario::frames`].
    pub fn rigs(&self, seed: u64) -> Result<Vec<Extrinsics<f64>>> {
        Ok(self.scenes(seed)?.into_iter().map(|(scene, _)| scene.rig).collect())
    }

    /// The pairs, the same for the same seed.
    ///
    /// # Errors
    /// Names the parameter that is out of range, or the pair without a common view of both cameras.
    pub fn frames(&self, seed: u64) -> Result<impl Iterator<Item = ScenarioPair> + use<>> {
        self.scene.check()?;
        let scenes = self.scenes(seed)?;
        ensure!(self.creep_px.is_finite(), "creep must be finite");
        let error_px = self.landmark_px;
        ensure!(error_px >= 0.0 && error_px.is_finite(), "landmark noise must be 0 px or more");
        let mut points = self.points();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut disturber = self.disturber(seed)?;
        let mut witnessing = Witnessing::new(self.witnesses, seed);
        let mistake = self.mistake;
        Ok(scenes.into_iter().enumerate().map(move |(at, (scene, steady))| {
            let mut pair = points.pair(at, &scene, &mut rng);
            disturber.roll(&scene, &mut pair);
            let witnessed = witnessing.after(at, &scene, &pair);
            if let Some(mistake) = mistake {
                pair.matches.iter_mut().for_each(|m| mistake.make(m));
            }
            ScenarioPair { scene, steady, pair, witnessed }
        }))
    }

    fn points(&self) -> Points {
        let new_from = match self.kind {
            ScenarioKind::ParkedLandmarks => self.pairs * 2 / 3,
            ScenarioKind::Creeping => usize::MAX,
            ScenarioKind::Parked => return Points::Again(0..usize::MAX, None),
            ScenarioKind::Drives => {
                return Points::Again(self.pairs / 4..self.starts_again(), None);
            }
            _ => return Points::New,
        };
        let Self { landmark_px: error_px, creep_px, .. } = *self;
        Points::Landmarks(Landmarks { error_px, creep_px, new_from, seen: Vec::new() })
    }

    /// Standard deviation of each coordinate of a true match, px: of the noise and of the constant error of a landmark.
    #[must_use]
    pub fn noise_px(&self) -> f64 {
        libm::hypot(self.scene.noise_px, self.landmark_px)
    }

    /// The pairs as a data set.
    ///
    /// # Errors
    /// As [`Scenario::frames`].
    pub fn dataset(&self, seed: u64) -> Result<Dataset> {
        let mut meta = self.scene.meta();
        let (mut pairs, mut rigs) = (Vec::new(), Vec::new());
        for ScenarioPair { scene, steady, pair, .. } in self.frames(seed)? {
            meta = Scene { rig: steady, ..scene }.meta();
            meta.baseline_m = self.witnesses.rangefinder.map(|range| range.baseline_m);
            pairs.push(pair.matches);
            rigs.extend(self.kind.moves().then(|| Rig::from(&steady)));
        }
        Ok(Dataset { name: format!("synth {} seed {seed}", self.kind), meta, pairs, rigs })
    }

    /// Measurements of the witnesses after each pair.
    ///
    /// # Errors
    /// As [`Scenario::frames`].
    pub fn witnessed(&self, seed: u64) -> Result<Vec<Witnessed>> {
        Ok(self.frames(seed)?.map(|frame| frame.witnessed).collect())
    }

    /// Share of the run before a pair: 0 for the first pair, 1 for the last.
    fn flown(&self, pair: usize) -> Result<f64> {
        let last = u32::try_from(self.pairs.saturating_sub(1).max(1))?;
        Ok(f64::from(u32::try_from(pair)?) / f64::from(last))
    }

    /// Whether the rig moves, or a disturbance moves the views of a pair against each other.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.kind.moves() || !self.disturbance.is_none()
    }

    fn disturber(&self, seed: u64) -> Result<Disturber> {
        // A flight draws its own vibration.
        let flies = self.kind == ScenarioKind::Flight;
        let drawn = if flies { 0.0 } else { self.disturbance.vibration_deg };
        Disturbance { vibration_deg: drawn, ..self.disturbance }.over(self.pairs, seed)
    }

    /// The scene of each pair, and the rig without its disturbance.
    fn scenes(&self, seed: u64) -> Result<Vec<(Scene, Extrinsics<f64>)>> {
        ensure!(self.turn_deg.is_finite() && self.off_deg.is_finite(), "turn must be finite");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(STREAM);
        let drawn = Vector3::from(UnitSphere.sample(&mut rng));
        let axis = self.axis.map_or(drawn, |axis| Vector3::from(axis).normalize());
        ensure!(axis.iter().all(|x| x.is_finite()), "the axis of a turn must have a direction");
        let mut base = self.scene.clone();
        if self.off_deg != 0.0 {
            let axis = Vector3::from(UnitSphere.sample(&mut rng));
            base.rig = turned(&base.rig, &axis, self.off_deg)?;
        }
        if self.lens_prior {
            let [left, right] = LensError::drawn(seed);
            let [given_left, given_right] = base.lens_errors;
            base.lens_errors = [given_left.plus(&left), given_right.plus(&right)];
        }
        let mut disturber = self.disturber(seed)?;
        let scene = |i: usize| {
            let mut scene = self.scene_of(&base, i, &axis, &mut rng)?;
            scene.lens_errors[1].focal += self.lens_warming * self.flown(i)?;
            let steady = scene.rig;
            scene.rig = disturber.rig(i, &steady)?;
            scene.check()?;
            Ok((scene, steady))
        };
        let named = |(i, scene): (usize, Result<_>)| scene.with_context(|| format!("pair {i}"));
        (0..self.pairs).map(scene).enumerate().map(named).collect()
    }

    fn scene_of(
        &self,
        base: &Scene,
        pair: usize,
        axis: &Vector3<f64>,
        rng: &mut ChaCha8Rng,
    ) -> Result<Scene> {
        let base = base.clone();
        Ok(match self.kind {
            ScenarioKind::Refocus if pair < self.turned_from() => {
                Scene { lens_errors: [LensError::NONE; 2], ..base }
            }
            ScenarioKind::Near
            | ScenarioKind::Far
            | ScenarioKind::VeryFar
            | ScenarioKind::Altitude
            | ScenarioKind::NearFew
            | ScenarioKind::Sky
            | ScenarioKind::NarrowBand
            | ScenarioKind::Parked
            | ScenarioKind::ParkedLandmarks
            | ScenarioKind::Creeping
            | ScenarioKind::Refocus => base,
            ScenarioKind::Step
            | ScenarioKind::Drift
            | ScenarioKind::WarmUp
            | ScenarioKind::Drives => {
                Scene { rig: turned(&base.rig, axis, self.turn_deg * self.turns(pair)?)?, ..base }
            }
            ScenarioKind::Climb => climbed(&base, self.flown(pair)?),
            ScenarioKind::Descent => climbed(&base, 1.0 - self.flown(pair)?),
            ScenarioKind::Heterogeneous => heterogeneous(&base, rng),
            ScenarioKind::Planar => {
                let [x, y]: [f64; 2] = UnitCircle.sample(rng);
                let slant = libm::tan(between(SLANT_DEG, rng).to_radians());
                Scene { depth: plane(base.depth, [x * slant, y * slant], rng), ..base }
            }
            ScenarioKind::FrontoParallel => {
                Scene { depth: plane(base.depth, [0.0; 2], rng), ..base }
            }
            ScenarioKind::Flight => {
                let knock_deg = if pair < self.turned_from() { 0.0 } else { self.turn_deg };
                let Self { pairs, disturbance: Disturbance { vibration_deg, .. }, .. } = *self;
                Part { at: [pair, pairs], knock_deg, vibration_deg }.scene(&base, axis, rng)?
            }
        })
    }
}

/// A scene at a share of the climb, which is linear in the logarithm of depth.
fn climbed(base: &Scene, share: f64) -> Scene {
    Scene { depth: base.depth.times(libm::pow(CEILING, share)), ..base.clone() }
}

/// A scene whose number of matches, depth range and band are drawn within those of `base`. In half of the draws the
/// band keeps its centre.
fn heterogeneous(base: &Scene, rng: &mut ChaCha8Rng) -> Scene {
    let matches = rng.random_range(FEW_MATCHES.min(base.matches)..=base.matches);
    let depth = match base.depth {
        Depth::LogUniform(range) => {
            let [a, b] = [log_uniform(range, rng), log_uniform(range, rng)];
            Depth::LogUniform([a.min(b), a.max(b)])
        }
        other @ (Depth::Mixture { .. } | Depth::Plane { .. }) => other,
    };
    let band = between([NARROW_BAND.min(base.band), base.band], rng);
    let shift = if rng.random() { between([-0.5, 0.5], rng) * (base.band - band) } else { 0.0 };
    Scene { matches, depth, band, band_centre: base.band_centre + shift, ..base.clone() }
}

/// A plane at a random depth within a log-uniform range; other depths are kept.
fn plane(depth: Depth, slope: [f64; 2], rng: &mut ChaCha8Rng) -> Depth {
    match depth {
        Depth::LogUniform(range) => Depth::Plane { on_axis: log_uniform(range, rng), slope },
        other @ (Depth::Mixture { .. } | Depth::Plane { .. }) => other,
    }
}

fn between([least, most]: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    least + (most - least) * rng.random::<f64>()
}

fn log_uniform(range: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    libm::exp(between(range.map(libm::log), rng))
}
