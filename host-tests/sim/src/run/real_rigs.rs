//! Runs of the calibrator as on a vehicle: the health is read and the estimate applied after every pair. A run keeps
//! the errors of its estimates and their reported deviations.

use std::ops::Range;

use anyhow::{Context, Result};
use rayon::prelude::*;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Calibrator, Config, Extrinsics, Health, Proposal, Scalar, State};

use super::monte_carlo::{CAPACITY, FEW, TOO_MANY_SD, calibrator, cameras, nees};
use crate::bounds::{cramer_rao, try_joint_fit};
use crate::synth::{Scenario, ScenarioPair};
use rigs::data::{Match, Rays, in_f64, ranges, tracked};

/// Results of one pair of a run.
#[derive(Debug, Clone, Copy)]
pub struct RealPair {
    /// State after the pair.
    pub state: State,
    /// Whether the pair was fused.
    pub fused: bool,
    /// Whether the health permitted arming.
    pub armed: bool,
    /// The estimate after the pair; `None` before the first.
    pub claim: Option<Claim>,
    /// Estimated vibration of `R` and of `t`, rad RMS; 0 without an estimate.
    pub vibration: [f64; 2],
    /// Error of the extrinsics in use, after an attempt to apply the estimate.
    pub in_use: Deviation<f64>,
    /// RMS row offsets from the health, px: with the extrinsics in use before the estimate was applied, and with the
    /// estimate. `None` without a health.
    pub rms_px: Option<[f64; 2]>,
}

/// An estimate, its error, and its reported deviations.
#[derive(Debug, Clone, Copy)]
pub struct Claim {
    /// Error against the truth of the pair.
    pub error: Deviation<f64>,
    /// Reported standard deviation, with the lens uncertain.
    pub sd: Deviation<f64>,
    /// Reported standard deviation, with the lens as given.
    pub sd_given: Deviation<f64>,
    /// Squared error normalised by the reported covariance (NEES), five degrees of freedom; NaN without a covariance.
    pub nees: f64,
}

/// One run.
#[derive(Debug, Clone)]
pub struct RealRun {
    /// Results pair by pair.
    pub pairs: Vec<RealPair>,
    /// Error of `R = I`, `t = (-1, 0, 0)` against the truth of the last pair.
    pub start: Deviation<f64>,
    /// Error of the joint fit of all true matches; `None` if the rig moves, there are fewer than [`FEW`], or the fit
    /// fails.
    pub joint_fit: Option<Deviation<f64>>,
    /// Cramer-Rao bound of all true matches, as if all noise were independent; `None` if the rig moves, or there are
    /// fewer than [`FEW`].
    pub bound: Option<Deviation<f64>>,
}

impl Claim {
    fn of<T: Scalar>(proposal: &Proposal<T>, truth: &Extrinsics<f64>) -> Self {
        Self {
            error: Deviation::between(&in_f64(&proposal.extrinsics), truth),
            sd: Deviation {
                translation: proposal.sd_lens.translation.to_f64(),
                rotation: proposal.sd_lens.rotation.to_f64(),
            },
            sd_given: Deviation {
                translation: proposal.sd.translation.to_f64(),
                rotation: proposal.sd.rotation.to_f64(),
            },
            nees: nees(proposal, truth),
        }
    }

    /// Error over reported standard deviation, of `t` and of `R`.
    #[must_use]
    pub fn error_in_sd(&self) -> Deviation<f64> {
        Deviation {
            translation: self.error.translation / self.sd.translation,
            rotation: self.error.rotation / self.sd.rotation,
        }
    }

    /// Whether the error of `t` or of `R` is above [`TOO_MANY_SD`] reported deviations.
    #[must_use]
    pub fn is_overconfident(&self) -> bool {
        let Deviation { translation, rotation } = self.error_in_sd();
        translation.max(rotation) > TOO_MANY_SD
    }
}

/// Runs a scenario once per seed, on all cores.
///
/// * `each`: called after each run, from any thread.
///
/// # Errors
/// As [`Scenario::frames`], or if the scenario has no pairs or its cameras are not valid.
pub fn runs<T: Scalar>(
    scenario: &Scenario,
    config: Config,
    seeds: Range<u64>,
    each: impl Fn() + Sync,
) -> Result<Vec<RealRun>> {
    let of_seed = |seed| run::<T>(scenario, config, seed).inspect(|_| each());
    seeds.into_par_iter().map(of_seed).collect()
}

fn run<T: Scalar>(scenario: &Scenario, config: Config, seed: u64) -> Result<RealRun> {
    let mut calibrator = calibrator::<T>(scenario, config)?;
    let mut pairs = Vec::with_capacity(scenario.pairs);
    let [mut noisy, mut clean]: [Vec<Rays>; 2] = Default::default();
    let still = !scenario.moves();
    let mut last = None;
    for frame in scenario.frames(seed)? {
        pairs.push(step(&mut calibrator, &frame));
        if still {
            noisy.extend(frame.pair.inlier_rays(&frame.scene));
            clean.extend(frame.pair.clean_inlier_rays(&frame.scene));
        }
        last = Some((frame.scene, frame.steady));
    }
    let (last, rig) = last.context("a scenario has pairs")?;
    let rig = &rig;
    let known = still && clean.len() >= FEW;
    let joint_fit = known.then(|| try_joint_fit(rig, &noisy)).flatten();
    Ok(RealRun {
        pairs,
        start: Deviation::between(&Extrinsics::SIDE_BY_SIDE, rig),
        joint_fit: joint_fit.map(|fit| Deviation::between(&fit, rig)),
        bound: known.then(|| cramer_rao(rig, clean.iter(), scenario.noise_px() / last.focal)),
    })
}

/// Passes the range readings and the tracks of a pair to the calibrator, after the pair itself. A refused measurement
/// leaves the estimate unchanged.
///
/// # Panics
/// If the cameras of the scene are not valid.
pub fn push_witnessed<T: Scalar, const N: usize>(
    calibrator: &mut Calibrator<T, N>,
    frame: &ScenarioPair,
) {
    for reading in &frame.witnessed.readings {
        let _ = calibrator.push_witness(&ranges::in_scalar(reading));
    }
    if !frame.witnessed.tracks.is_empty() {
        let cameras = cameras(&frame.scene).expect("the calibrator has them");
        let tracks = tracked::rays_of(&cameras, &frame.witnessed.tracks);
        let _ = calibrator.push_witness(&tracks[..]);
    }
}

/// Takes one pair as on a vehicle.
fn step<T: Scalar>(calibrator: &mut Calibrator<T, CAPACITY>, frame: &ScenarioPair) -> RealPair {
    let matches = frame.pair.matches.iter().map(Match::correspondence);
    let fused = calibrator.take_pair(matches).fused.is_ok();
    push_witnessed(calibrator, frame);
    let health = calibrator.health().ok();
    // `apply` refuses an estimate that is not locked, or is in doubt.
    let _ = calibrator.apply();
    let truth = &frame.steady;
    let vibration = calibrator.proposal().map(|proposal| proposal.vibration);
    RealPair {
        vibration: vibration.map_or([0.0; 2], |v| [v.rotation.to_f64(), v.baseline.to_f64()]),
        state: calibrator.state(),
        fused,
        armed: health.as_ref().is_some_and(Health::may_arm),
        claim: calibrator.proposal().map(|proposal| Claim::of(&proposal, truth)),
        in_use: Deviation::between(&in_f64(&calibrator.in_use().extrinsics), truth),
        rms_px: health.map(|health| [health.in_use_px.to_f64(), health.proposed_px.to_f64()]),
    }
}
