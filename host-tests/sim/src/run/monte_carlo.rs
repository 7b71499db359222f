//! Monte Carlo: many runs of a scenario, as on a vehicle, against the best possible estimate from its data.
//!
//! The verdict is read and the estimate applied after every pair. A run is compared with the joint maximum-likelihood
//! fit and the Cramer-Rao bound of the true matches of all its pairs.

use anyhow::{Context, Result};
use rayon::prelude::*;
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, Extrinsics, FactoryCalibration, Fused, Intrinsics, Lens,
    Proposal, Scalar, State, Verdict,
};

use crate::bounds::{cramer_rao, try_joint_fit};
use crate::synth::{Rangefinder, Scenario, Scene, SynthPair, Witnessed};
use rigs::data::{Match, Rays, in_f64, ranges, tracked};

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
    /// Reported standard deviation, with the lens uncertain.
    pub sd: Deviation<f64>,
    /// Error divided by its reported standard deviation with the lens as given, the larger ratio of `R` and `t`.
    pub error_in_sd: f64,
    /// Squared error normalised by the reported covariance (NEES), five degrees of freedom; NaN if the covariance has no factor.
    pub nees: f64,
    /// Whether the verdict permitted arming.
    pub armed: bool,
    /// Share of the matches that fit the extrinsics in use, among those that fit the pair's own pose.
    pub coverage: f64,
    /// Estimated vibration of `R` and of `t`, rad RMS.
    pub vibration: [f64; 2],
    /// Error of the yaw that was in use for this pair, about the rectified y, rad; and this error over the one that the
    /// details report. NaN without details.
    pub yaw_in_use: [f64; 2],
    /// Generation of the calibration in use, which changes with each reload of the rectifier.
    pub generation: u32,
    /// RMS row offset with the extrinsics in use before the estimate was applied, px; NaN without details.
    pub in_use_px: f64,
}

impl AfterPair {
    /// Error over reported standard deviation with the lens uncertain, of `t` and of `R`.
    #[must_use]
    pub fn in_sd(&self) -> [f64; 2] {
        let Deviation { translation, rotation } = self.error;
        [translation / self.sd.translation, rotation / self.sd.rotation]
    }
}

/// One run.
#[derive(Debug, Clone)]
pub struct Run {
    /// State after each pair; `None` before the first estimate.
    pub pairs: Vec<Option<AfterPair>>,
    /// Error of `R = I`, `t = (-1, 0, 0)` against the truth of the last pair.
    pub start: Deviation<f64>,
    /// Error of the joint fit of all true matches; `None` if the rig moves, there are fewer than [`FEW`], or the fit
    /// fails.
    pub joint_fit: Option<Deviation<f64>>,
    /// Cramer-Rao bound of all true matches, as if all noise were independent; `None` if the rig moves, or there are
    /// fewer than [`FEW`].
    pub bound: Option<Deviation<f64>>,
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
        let after_pair = step(&mut calibrator, &pair, None, &scenario.scene.rig);
        if at == due || at == scenario.pairs {
            kept.extend(after_pair.map(|after_pair| (at, after_pair)));
            due *= 10;
        }
        each();
    }
    Ok(kept)
}

/// Nominal cameras of a generated scene.
fn cameras<T: Scalar>(scene: &Scene) -> Result<Cameras<T>> {
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
    witnessed: Option<(&Scene, &Witnessed)>,
    truth: &Extrinsics<f64>,
) -> Option<AfterPair> {
    let outcome = calibrator.take_pair(pair.matches.iter().map(Match::correspondence));
    if let Some((scene, witnessed)) = witnessed {
        push_witnessed(calibrator, scene, witnessed);
    }
    let Verdict { may_arm: armed, coverage, .. } = *calibrator.verdict();
    let details = calibrator.details();
    let in_use = RectifyingRotations::from(&in_f64(&calibrator.in_use().extrinsics));
    let yaw = in_use.unknowns_to(&RectifyingRotations::from(truth)).y;
    let reported = details.as_ref().map_or(f64::NAN, |details| details.yaw.to_f64());
    // `apply` refuses an estimate that is not locked, or is in doubt.
    let _ = calibrator.apply();
    let proposal = calibrator.proposal()?;
    let found = in_f64(&proposal.extrinsics);
    let error = Deviation::between(&found, truth);
    let over = |error: f64, sd: T| error / sd.to_f64();
    Some(AfterPair {
        state: proposal.state,
        fused: outcome.fused.ok(),
        passes: outcome.pair.map(|report| report.passes),
        found,
        error,
        in_use: Deviation::between(&in_f64(&calibrator.in_use().extrinsics), truth),
        sd: Deviation {
            translation: proposal.sd_lens.translation.to_f64(),
            rotation: proposal.sd_lens.rotation.to_f64(),
        },
        error_in_sd: over(error.rotation, proposal.sd.rotation)
            .max(over(error.translation, proposal.sd.translation)),
        nees: nees(&proposal, truth),
        armed,
        coverage: coverage.to_f64(),
        vibration: [proposal.vibration.rotation, proposal.vibration.baseline].map(T::to_f64),
        yaw_in_use: [yaw, yaw.abs() / reported],
        generation: calibrator.in_use().generation,
        in_use_px: details.map_or(f64::NAN, |details| details.in_use_px.to_f64()),
    })
}

/// Passes the range readings and the tracks of a pair to the calibrator, after the pair itself. A refused measurement
/// leaves the estimate unchanged.
fn push_witnessed<T: Scalar>(
    calibrator: &mut Calibrator<T, CAPACITY>,
    scene: &Scene,
    witnessed: &Witnessed,
) {
    for reading in &witnessed.readings {
        let _ = calibrator.push_range(&ranges::in_scalar(reading));
    }
    if let (false, Ok(cameras)) = (witnessed.tracks.is_empty(), cameras(scene)) {
        let _ = calibrator.push_motion(&tracked::rays_of(&cameras, &witnessed.tracks));
    }
}

fn run<T: Scalar>(scenario: &Scenario, config: Config, seed: u64) -> Result<Run> {
    let mut calibrator = calibrator::<T>(scenario, config)?;
    let mut pairs = Vec::with_capacity(scenario.pairs);
    let [mut noisy, mut clean]: [Vec<Rays>; 2] = Default::default();
    let still = !scenario.moves();
    let mut last = None;
    for frame in scenario.frames(seed)? {
        let witnessed = Some((&frame.scene, &frame.witnessed));
        pairs.push(step(&mut calibrator, &frame.pair, witnessed, &frame.steady));
        if still {
            noisy.extend(frame.pair.inlier_rays(&frame.scene));
            clean.extend(frame.pair.clean_inlier_rays(&frame.scene));
        }
        last = Some((frame.scene, frame.steady));
    }
    let (last, rig) = last.context("a scenario has pairs")?;
    let known = still && clean.len() >= FEW;
    let joint_fit = known.then(|| try_joint_fit(&rig, &noisy)).flatten();
    Ok(Run {
        pairs,
        start: Deviation::between(&Extrinsics::SIDE_BY_SIDE, &rig),
        joint_fit: joint_fit.map(|fit| Deviation::between(&fit, &rig)),
        bound: known.then(|| cramer_rao(&rig, clean.iter(), scenario.noise_px() / last.focal)),
    })
}

/// Squared error normalised by the reported covariance (NEES), five degrees of freedom; NaN without a covariance.
fn nees<T: Scalar>(proposal: &Proposal<T>, truth: &Extrinsics<f64>) -> f64 {
    let found = RectifyingRotations::from(&in_f64(&proposal.extrinsics));
    let off = found.unknowns_to(&RectifyingRotations::from(truth));
    let factor = proposal.covariance.map(T::to_f64).cholesky();
    factor.map_or(f64::NAN, |factor| off.dot(&factor.solve(&off)))
}

/// 99 % bounds of the mean NEES of `n` consistent estimates, five degrees of freedom.
#[must_use]
pub fn nees_band(n: usize) -> [f64; 2] {
    // Each NEES has mean 5 and variance 10. The mean of many is nearly normal.
    let sd = (10.0 / f64::from(u32::try_from(n).unwrap_or(u32::MAX))).sqrt();
    [5.0 - 2.576 * sd, 5.0 + 2.576 * sd]
}
