//! Measurements on a rig that is knocked once: the running estimate of one method, pair by pair.

use anyhow::Result;
use serde::Serialize;
use stereo_selfcal::metrics::Deviation;

use super::measurement::{Measured, Measurement, Runner};
use super::on_recorded::{ErrorPair, error_pair};
use super::sweep::setting;
use crate::baselines::Method;
use crate::data::Rays;
use crate::synth::{Scenario, ScenarioKind, five_degrees_off};

/// Pairs of a run; the rig turns in the middle.
pub const PAIRS: usize = 60;

/// By how much the right camera turns, degrees.
pub const TURN_DEG: f64 = 0.5;

/// Share of outliers.
const OUTLIERS: f64 = 0.1;

/// Seed of the first run.
const SEED: u64 = 9_950_000;

/// One method over a step: RMS over the runs of `e_t` and `e_theta` after each pair, rad; `None`
/// where no run has an estimate.
#[derive(Serialize)]
struct AfterStep<'a> {
    pairs: usize,
    turn_deg: f64,
    outliers: f64,
    runs: u64,
    seed: u64,
    method: &'static str,
    #[serde(skip)]
    by: &'a dyn Method,
}

/// Errors after each pair.
pub type StepResponse = Vec<Option<ErrorPair>>;

fn scenario(pairs: usize, turn_deg: f64, outliers: f64) -> Scenario {
    let mut scenario = Scenario { turn_deg, ..Scenario::new(ScenarioKind::Step, pairs) };
    scenario.scene.outliers = outliers;
    scenario.scene.rig = five_degrees_off();
    scenario
}

impl AfterStep<'_> {
    fn run(&self, seed: u64) -> Result<Vec<Option<Deviation<f64>>>> {
        let scenario = scenario(self.pairs, self.turn_deg, self.outliers);
        let frames: Vec<_> = scenario.frames(seed)?.collect();
        let rays: Vec<Vec<Rays>> = frames.iter().map(|f| f.pair.rays(&f.scene)).collect();
        let found = self.by.running(&rays, &setting(&scenario.scene));
        let of_frame = |(found, frame): (Option<_>, &crate::synth::ScenarioPair)| {
            Some(Deviation::between(&found?, &frame.scene.rig))
        };
        Ok(found.into_iter().zip(&frames).map(of_frame).collect())
    }
}

impl Measurement for AfterStep<'_> {
    type Outcome = StepResponse;
    const KIND: &'static str = "step";

    fn label(&self) -> String {
        format!("{} after a step", self.method)
    }

    fn measure(&self) -> Result<StepResponse> {
        let seeds = self.seed..self.seed + self.runs;
        let runs: Vec<_> = seeds.map(|seed| self.run(seed)).collect::<Result<_>>()?;
        let rms = |at: usize| {
            let of_runs = runs.iter().filter_map(|run| run.get(at).copied().flatten());
            Deviation::root_mean_square(of_runs).map(error_pair)
        };
        Ok((0..self.pairs).map(rms).collect())
    }
}

/// Methods over a step, in their order.
///
/// # Errors
/// If the cache cannot be written.
pub fn step_responses(
    runner: &Runner<'_>,
    methods: &[&dyn Method],
    runs: u64,
) -> Result<Vec<Measured<StepResponse>>> {
    let measurements: Vec<AfterStep<'_>> = methods.iter().map(|&by| after_step(by, runs)).collect();
    runner.run(&measurements)
}

fn after_step(by: &dyn Method, runs: u64) -> AfterStep<'_> {
    let (pairs, turn_deg, outliers, seed) = (PAIRS, TURN_DEG, OUTLIERS, SEED);
    AfterStep { pairs, turn_deg, outliers, runs, seed, method: by.name(), by }
}
