//! Monte Carlo: many runs of a scenario against the best possible estimate from its data.
//!
//! A run is compared with the joint maximum-likelihood fit of the true matches of all its pairs. A single pair is
//! compared with the Cramer-Rao bound of its true matches.

use anyhow::{Context, Result};
use rayon::prelude::*;
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, Extrinsics, FactoryCalibration, Fused, Intrinsics, Lens,
    Proposal, Reason, Scalar, State,
};

use super::estimate::doubt;
use crate::bounds::{cramer_rao, joint_fit};
use crate::synth::{Rangefinder, Scenario, ScenarioPair, Scene, SynthPair};
use rigs::data::{Match, Rays, in_f64};

/// Capacity of the calibrators: the largest number of matches of a pair of any scenario kind by default.
pub const CAPACITY: usize = 512;

/// Least number of true matches for a bound or a joint fit.
pub const FEW: usize = 12;

/// Number of reported standard deviations above which an error is overconfident.
pub const TOO_MANY_SD: f64 = 5.0;

/// State of a run after one pair.
#[derive(Debug, Clone, Copy)]
pub struct AfterPair {
    /// State after the pair.
    pub state: State,
    /// How the pair was fused, if at all.
    pub fused: Option<Fused>,
    /// Passes over the batch that the pair took, if it was solved.
    pub passes: Option<u16>,
    /// The estimate.
    pub found: Extrinsics<f64>,
    /// Error of the estimate against the truth of this pair.
    pub error: Deviation<f64>,
    /// Error of the extrinsics in use, after an attempt to apply the estimate.
    pub in_use: Deviation<f64>,
    /// Error divided by its reported standard deviation with the lens as given, the larger ratio of `R` and `t`.
    pub error_in_sd: f64,
    /// Squared error normalised by the reported covariance (NEES), five degrees of freedom; NaN without a covariance.
    pub nees: f64,
    /// The strongest reason against the estimate that comes from the matches.
    pub doubt: Option<Reason>,
}

/// One run.
#[derive(Debug, Clone)]
pub struct Run {
    /// State after each pair; `None` before the first estimate.
    pub pairs: Vec<Option<AfterPair>>,
    /// Error of the joint fit of all true matches; `None` if the rig moves, or there are fewer than [`FEW`].
    pub joint_fit: Option<Deviation<f64>>,
    /// Cramer-Rao bound of the last pair's true matches; NaN for fewer than [`FEW`].
    pub bound: Deviation<f64>,
}

impl Run {
    /// Number of the first pair, from 0, after which the state was locked; `None` if it never was.
    #[must_use]
    pub fn locked_at(&self) -> Option<usize> {
        self.pairs.iter().position(|m| m.is_some_and(|m| m.state == State::Locked))
    }

    /// The state after the last pair; `None` without an estimate.
    #[must_use]
    pub fn last(&self) -> Option<&AfterPair> {
        self.pairs.last()?.as_ref()
    }

    /// Number of locked pairs, and of locked pairs whose error is above [`TOO_MANY_SD`] reported deviations.
    #[must_use]
    pub fn locked_and_overconfident(&self) -> [usize; 2] {
        let locked = || self.pairs.iter().flatten().filter(|m| m.state == State::Locked);
        [locked().count(), locked().filter(|m| m.error_in_sd > TOO_MANY_SD).count()]
    }
}

/// Runs a scenario once per seed, on all cores.
///
/// * `each`: called after each run, from any thread.
///
/// # Errors
/// If a parameter of the scenario is out of range.
pub fn runs<T: Scalar>(
    scenario: &Scenario,
    config: Config,
    seeds: std::ops::Range<u64>,
    each: impl Fn() + Sync,
) -> Result<Vec<Run>> {
    let of_seed = |seed| run::<T>(scenario, config, seed).inspect(|_| each());
    seeds.into_par_iter().map(of_seed).collect()
}

/// One run of any length, in constant memory: the number of pairs and the state after 10, 100, 1000, ... pairs and
/// after the last pair, where there is an estimate. Only [`Scenario::scene`] generates the pairs: the scene of every
/// pair is the same, and the rig does not move.
///
/// * `each`: called after each pair.
///
/// # Errors
/// If a parameter of the scenario is out of range.
pub fn long_run<T: Scalar>(
    scenario: &Scenario,
    config: Config,
    seed: u64,
    mut each: impl FnMut(),
) -> Result<Vec<(usize, AfterPair)>> {
    let mut calibrator = calibrator::<T>(scenario, config)?;
    let mut kept = Vec::new();
    let mut due = 10;
    // `Scenario::frames` is not used, because it checks the scene of every pair. For a million pairs the checks take
    // hours.
    for (at, pair) in (1..=scenario.pairs).zip(scenario.scene.pairs(seed)) {
        let after_pair = step(&mut calibrator, &pair, &scenario.scene.rig);
        if at == due || at == scenario.pairs {
            kept.extend(after_pair.map(|after_pair| (at, after_pair)));
            due *= 10;
        }
        each();
    }
    Ok(kept)
}

/// Nominal cameras of a generated scene.
pub(super) fn cameras<T: Scalar>(scene: &Scene) -> Result<Cameras<T>> {
    let centre = scene.size.map(|n| T::lit(f64::from(n - 1) / 2.0));
    let intrinsics =
        Intrinsics { focal: [T::lit(scene.focal); 2], principal: centre, size: scene.size };
    let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
    Ok(Cameras { left: camera, right: camera })
}

/// A calibrator with the nominal cameras of a scenario. It starts from the rig of the scene if the scenario is
/// commissioned, and from a guess otherwise; a rangefinder gives the length of the baseline.
///
/// # Errors
/// If a parameter of the scenario is out of range.
pub fn calibrator<T: Scalar>(
    scenario: &Scenario,
    config: Config,
) -> Result<Box<Calibrator<T, CAPACITY>>> {
    let cameras = cameras(&scenario.scene)?;
    let mut factory = if scenario.commissioned {
        let rig = &scenario.scene.rig;
        let rotation = rig.rotation().matrix().map(T::lit);
        let translation = rig.translation().into_inner().map(T::lit);
        FactoryCalibration::new(cameras, Extrinsics::try_new(&rotation, &translation)?)
    } else {
        FactoryCalibration::guess(cameras)
    };
    if let Some(Rangefinder { baseline_m, .. }) = scenario.witnesses.rangefinder {
        factory = factory.with_baseline_m(baseline_m.to_single())?;
    }
    Ok(Box::new(Calibrator::new(config, &factory)))
}

/// Takes one pair, and applies the estimate if possible. `None` without an estimate.
fn step<T: Scalar>(
    calibrator: &mut Calibrator<T, CAPACITY>,
    pair: &SynthPair,
    truth: &Extrinsics<f64>,
) -> Option<AfterPair> {
    let outcome = calibrator.take_pair(pair.matches.iter().map(Match::correspondence));
    // `apply` refuses an estimate that is not locked, or is in doubt.
    let _ = calibrator.apply();
    let (fused, passes) = (outcome.fused.ok(), outcome.pair.map(|report| report.passes));
    let proposal = calibrator.proposal()?;
    Some(after_pair(&proposal, fused, passes, &calibrator.in_use().extrinsics, truth))
}

fn run<T: Scalar>(scenario: &Scenario, config: Config, seed: u64) -> Result<Run> {
    let mut calibrator = calibrator::<T>(scenario, config)?;
    let mut pairs = Vec::with_capacity(scenario.pairs);
    let mut inliers: Vec<Rays> = Vec::new();
    let mut last: Option<ScenarioPair> = None;
    let still = !scenario.moves();
    for frame in scenario.frames(seed)? {
        pairs.push(step(&mut calibrator, &frame.pair, &frame.steady));
        if still {
            inliers.extend(frame.pair.inlier_rays(&frame.scene));
        }
        last = Some(frame);
    }
    let last = last.context("a scenario has pairs")?;
    let clean = last.pair.clean_inlier_rays(&last.scene);
    let rig = &last.steady;
    let noise = last.scene.noise_px / last.scene.focal;
    let unknown = Deviation { translation: f64::NAN, rotation: f64::NAN };
    let few = |rays: &[Rays]| rays.len() < FEW;
    let bound = if few(&clean) { unknown } else { cramer_rao(rig, clean.iter(), noise) };
    let joint_fit =
        (still && !few(&inliers)).then(|| Deviation::between(&joint_fit(rig, &inliers), rig));
    Ok(Run { pairs, joint_fit, bound })
}

fn after_pair<T: Scalar>(
    proposal: &Proposal<T>,
    fused: Option<Fused>,
    passes: Option<u16>,
    in_use: &Extrinsics<T>,
    truth: &Extrinsics<f64>,
) -> AfterPair {
    let found = in_f64(&proposal.extrinsics);
    let error = Deviation::between(&found, truth);
    let over = |error: f64, sd: T| error / sd.to_f64();
    AfterPair {
        state: proposal.state,
        found,
        fused,
        passes,
        error,
        in_use: Deviation::between(&in_f64(in_use), truth),
        error_in_sd: over(error.rotation, proposal.sd.rotation)
            .max(over(error.translation, proposal.sd.translation)),
        nees: nees(proposal, truth),
        doubt: doubt(proposal.reasons()),
    }
}

/// Squared error normalised by the reported covariance (NEES), five degrees of freedom; NaN without a covariance.
pub(super) fn nees<T: Scalar>(proposal: &Proposal<T>, truth: &Extrinsics<f64>) -> f64 {
    let found = RectifyingRotations::from(&in_f64(&proposal.extrinsics));
    let off = found.unknowns_to(&RectifyingRotations::from(truth));
    let nees = proposal.covariance.and_then(|c| {
        let c = c.map(T::to_f64);
        Some(off.dot(&c.cholesky()?.solve(&off)))
    });
    nees.unwrap_or(f64::NAN)
}

/// 99 % bounds of the mean NEES of `n` consistent estimates, five degrees of freedom.
#[must_use]
pub fn nees_band(n: usize) -> [f64; 2] {
    // Each NEES has mean 5 and variance 10. The mean of many is nearly normal.
    let sd = (10.0 / f64::from(u32::try_from(n).unwrap_or(u32::MAX))).sqrt();
    [5.0 - 2.576 * sd, 5.0 + 2.576 * sd]
}
