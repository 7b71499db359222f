//! Measurements on a rig that is knocked once, or drifts: the running estimates, pair by pair.

use anyhow::Result;
use stereo_selfcal::geometry::metrics::Deviation;

use super::measurement::{Measurement, Runner};
use super::on_recorded::{ErrorPair, error_pair};
use super::sweep::setting;
use crate::rivals::{Front, Variant};
use rigs::data::Rays;
use sim::synth::{Scenario, ScenarioKind, five_degrees_off};

/// Pairs of a run; the rig turns in the middle.
pub const PAIRS: usize = 60;

/// Turn of the right camera, degrees.
pub const TURN_DEG: f64 = 0.5;

/// Share of outliers.
const OUTLIERS: f64 = 0.1;

/// Seed of the first run.
const SEED: u64 = 9_950_000;

/// Motion of the rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// One turn by [`TURN_DEG`] in the middle.
    Knock,
    /// A turn with every pair, rad, about an axis of each run.
    Drift(f64),
}

/// One run of all methods.
struct Run<'a> {
    seed: u64,
    motion: Motion,
    by: &'a [&'a Variant],
}

/// `e_t` and `e_theta` after each pair, rad, RMS over the runs; `None` if fewer than half of the runs have an estimate.
pub type StepResponse = Vec<Option<ErrorPair>>;

impl Measurement for Run<'_> {
    /// Errors by method and pair.
    type Outcome = Vec<Vec<Option<ErrorPair>>>;

    fn label(&self) -> String {
        format!("{:?}, run {}", self.motion, self.seed)
    }

    fn measure(&self) -> Result<Vec<Vec<Option<ErrorPair>>>> {
        let (kind, turn_deg) = match self.motion {
            Motion::Knock => (ScenarioKind::Step, TURN_DEG),
            Motion::Drift(turn) => (ScenarioKind::Drift, turn.to_degrees()),
        };
        let mut scenario = Scenario { turn_deg, ..Scenario::new(kind, PAIRS) };
        scenario.scene.outliers = OUTLIERS;
        scenario.scene.rig = five_degrees_off();
        let frames: Vec<_> = scenario.frames(self.seed)?.collect();
        let rays: Vec<Vec<Rays>> = frames.iter().map(|f| f.pair.rays(&f.scene)).collect();
        let setting = setting(&scenario.scene);
        let front = Front::new(&rays, &setting);
        let of_method = |by: &&Variant| {
            let found = by.running(&rays, &front, &setting).into_iter();
            let error = |(found, frame): (Option<_>, &sim::synth::ScenarioPair)| {
                Some(error_pair(Deviation::between(&found?, &frame.scene.rig)))
            };
            found.zip(&frames).map(error).collect()
        };
        Ok(self.by.iter().map(of_method).collect())
    }
}

/// Errors of the methods over the pairs, in their order.
pub fn step_responses(
    runner: &Runner<'_>,
    motion: Motion,
    by: &[&Variant],
    runs: u64,
) -> Vec<StepResponse> {
    let all: Vec<Run<'_>> = (SEED..SEED + runs).map(|seed| Run { seed, motion, by }).collect();
    let outcomes = runner.run(&all);
    let rms = |method: usize, pair: usize| {
        let runs = || outcomes.iter().flatten().map(|run| run[method][pair]);
        let solved: Vec<ErrorPair> = runs().flatten().collect();
        if solved.is_empty() || 2 * solved.len() < runs().count() {
            return None;
        }
        let deviation = |&[translation, rotation]: &ErrorPair| Deviation { translation, rotation };
        Deviation::root_mean_square(solved.iter().map(deviation)).map(error_pair)
    };
    let of_method = |method| (0..PAIRS).map(|pair| rms(method, pair)).collect();
    (0..by.len()).map(of_method).collect()
}
