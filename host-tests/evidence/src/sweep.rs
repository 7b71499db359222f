//! Measurements on generated scenes: all methods at one value of the varied parameter.
//!
//! All scenes have the rig of the project's figures, 5 degrees off about all axes and `t` 5 degrees off. All methods
//! get the same scenes, with the same seeds.

use anyhow::Result;
use stereo_selfcal::batch::{RayPair, row_offset};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Extrinsics, Scalar};

use super::effort::Effort;
use super::measurement::{Measured, Measurement, Runner};
use super::on_recorded::{ErrorPair, error_pair};
use super::recorded_sets::START;
use crate::rivals::{Front, Setting, Tuning, Variant};
use rigs::data::Rays;
use sim::bounds::cramer_rao;
use sim::synth::{Depth, Scene, SynthPair, five_degrees_off};

/// Seed of the first scene of every point.
const SEED: u64 = 9_900_000;

/// Largest number of scenes of one measurement.
const CHUNK: usize = 25;

/// Share of outliers when pairs, depth or band are varied.
const OUTLIERS: f64 = 0.1;

/// Farthest over nearest point, when the depth is varied.
const DEPTH_RATIO: f64 = 10.0;

/// The varied parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SweepAxis {
    /// Correspondences a pair, no outliers.
    Matches,
    /// Noise of a coordinate, px, no outliers.
    Noise,
    /// Share of outliers.
    Outliers,
    /// Pairs fused.
    Pairs,
    /// Distance of the nearest point, baselines; the farthest is ten times as far.
    Depth,
    /// Height of the band of the image that has matches, image heights.
    Band,
}

/// All methods at one value, some of the trials.
struct Chunk<'a> {
    axis: SweepAxis,
    value: f64,
    trials: u64,
    seed: u64,
    by: &'a [Variant],
}

/// The Cramer-Rao bound at one value: RMS of `e_t` and of `e_theta`, rad.
struct Bound {
    axis: SweepAxis,
    value: f64,
    trials: u64,
}

/// Errors of the trials at one value; `None` for a trial without an estimate.
pub type Trials = Vec<Option<ErrorPair>>;

/// All methods over one axis.
pub struct Sweep {
    /// The varied parameter.
    pub axis: SweepAxis,
    /// Its values.
    pub values: Vec<f64>,
    /// `e_t` and `e_theta` of the trials, rad, by method with its settings and by value; `None` for a trial without an
    /// estimate.
    pub trials: Vec<Vec<Measured<Trials>>>,
    /// Bound by value.
    pub bound: Vec<Measured<[f64; 2]>>,
}

impl SweepAxis {
    /// All axes, in the order of the page.
    pub const ALL: [Self; 6] =
        [Self::Matches, Self::Noise, Self::Outliers, Self::Pairs, Self::Depth, Self::Band];

    /// Name in one or two words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Matches => "matches",
            Self::Noise => "noise",
            Self::Outliers => "outliers",
            Self::Pairs => "pairs",
            Self::Depth => "depth",
            Self::Band => "band",
        }
    }

    /// Values of a curve with all its points.
    #[must_use]
    pub fn values(self) -> &'static [f64] {
        match self {
            Self::Matches => &[
                16.0, 24.0, 32.0, 48.0, 64.0, 96.0, 128.0, 192.0, 256.0, 384.0, 512.0, 724.0,
                1024.0,
            ],
            Self::Noise => &[0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0],
            Self::Outliers => {
                &[0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6]
            }
            Self::Pairs => &[1.0, 2.0, 3.0, 5.0, 10.0, 15.0, 20.0, 30.0, 50.0, 70.0, 100.0],
            Self::Depth => &[3.0, 5.0, 10.0, 20.0, 30.0, 60.0, 100.0, 200.0, 300.0],
            Self::Band => &[0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 1.0],
        }
    }

    /// Scene, and the number of its pairs.
    fn scene(self, value: f64) -> (Scene, usize) {
        let plain = Scene { rig: five_degrees_off(), ..Scene::default() };
        let wrong = Scene { outliers: OUTLIERS, ..plain.clone() };
        // Counts are whole and small.
        let count = value.to_u16().into();
        match self {
            Self::Matches => (Scene { matches: count, ..plain }, 1),
            Self::Noise => (Scene { noise_px: value, ..plain }, 1),
            Self::Outliers => (Scene { outliers: value, ..plain }, 1),
            Self::Pairs => (wrong, count),
            Self::Depth => {
                let depth = Depth::LogUniform([value, DEPTH_RATIO * value]);
                (Scene { depth, ..wrong }, 1)
            }
            Self::Band => (Scene { band: value, ..wrong }, 1),
        }
    }

    fn trials(self, effort: Effort) -> u64 {
        if self == Self::Pairs { effort.fused } else { effort.single }
    }
}

/// The pairs of each trial.
fn scenes(
    axis: SweepAxis,
    value: f64,
    seeds: std::ops::Range<u64>,
) -> Result<(Scene, Vec<Vec<SynthPair>>)> {
    let (scene, pairs) = axis.scene(value);
    scene.check()?;
    let of_seed = |seed| scene.pairs(seed).take(pairs).collect();
    let all = seeds.map(of_seed).collect();
    Ok((scene, all))
}

impl Measurement for Chunk<'_> {
    /// Trials by method.
    type Outcome = Vec<Trials>;

    fn label(&self) -> String {
        format!("{} {}, scenes from {}", self.axis.name(), self.value, self.seed)
    }

    fn measure(&self) -> Result<Vec<Trials>> {
        let seeds = self.seed..self.seed + self.trials;
        let (scene, all) = scenes(self.axis, self.value, seeds)?;
        let setting = setting(&scene);
        let mut trials = vec![Vec::new(); self.by.len()];
        for pairs in &all {
            let rays: Vec<Vec<Rays>> = pairs.iter().map(|pair| pair.rays(&scene)).collect();
            let front = Front::new(&rays, &setting);
            for (by, trials) in self.by.iter().zip(&mut trials) {
                let found = by.fused(&rays, &front, &setting);
                trials.push(found.and_then(|found| trial(&scene, pairs, &found)));
            }
        }
        Ok(trials)
    }
}

impl Measurement for Bound {
    type Outcome = [f64; 2];

    fn label(&self) -> String {
        format!("Cramer-Rao bound, {} {}", self.axis.name(), self.value)
    }

    fn measure(&self) -> Result<[f64; 2]> {
        let (scene, all) = scenes(self.axis, self.value, SEED..SEED + self.trials)?;
        let noise = scene.noise_px / scene.focal;
        let of = |pairs: &Vec<SynthPair>| {
            let rays: Vec<Rays> =
                pairs.iter().flat_map(|pair| pair.clean_inlier_rays(&scene)).collect();
            cramer_rao(&scene.rig, rays.iter(), noise)
        };
        let rms = Deviation::root_mean_square(all.iter().map(of));
        Ok(error_pair(rms.unwrap_or_default()))
    }
}

/// The knowledge of a generated scene that methods may use.
pub(super) fn setting(scene: &Scene) -> Setting {
    Setting {
        start: START,
        focal: scene.focal,
        noise_px: scene.noise_px,
        tuning: Tuning::default(),
    }
}

/// Errors of an estimate; `None` if it puts a point behind a camera.
fn trial(scene: &Scene, pairs: &[SynthPair], estimate: &Extrinsics<f64>) -> Option<ErrorPair> {
    let rotations = RectifyingRotations::from(estimate);
    let mut clean = pairs.iter().flat_map(|pair| &pair.clean).map(|clean| scene.rays(*clean));
    let in_front = clean.all(|[p_l, p_r]: Rays| {
        let pair = RayPair::try_new([p_l.x, p_l.y], [p_r.x, p_r.y]);
        pair.is_some_and(|pair| row_offset(&rotations, &pair).is_some())
    });
    in_front.then(|| error_pair(Deviation::between(estimate, &scene.rig)))
}

/// Measures all methods over one axis.
pub fn sweep(runner: &Runner<'_>, axis: SweepAxis, by: &[Variant], effort: Effort) -> Sweep {
    let values = effort.thinned(axis.values());
    let trials = axis.trials(effort);
    let of_value = |&value: &f64| {
        let starts = (0..trials).step_by(CHUNK);
        starts.map(move |from| {
            let count = (trials - from).min(CHUNK as u64);
            Chunk { axis, value, trials: count, seed: SEED + from, by }
        })
    };
    let chunks: Vec<Chunk<'_>> = values.iter().flat_map(of_value).collect();
    let outcomes = runner.run(&chunks);
    let bounds: Vec<Bound> = values.iter().map(|&value| Bound { axis, value, trials }).collect();
    let bound = runner.run(&bounds);
    let of_values: Vec<_> = outcomes.chunks(outcomes.len() / values.len().max(1)).collect();
    let of_method = |i: usize| {
        let joined = |chunks: &&[Measured<Vec<Trials>>]| {
            let of_chunk = chunks.iter().map(|chunk| chunk.as_ref().map(|by| &by[i]));
            let all: Result<Vec<_>, &String> = of_chunk.collect();
            all.map(|all| all.into_iter().flatten().copied().collect()).map_err(Clone::clone)
        };
        of_values.iter().map(joined).collect()
    };
    let trials = (0..by.len()).map(of_method).collect();
    Sweep { axis, values, trials, bound }
}
