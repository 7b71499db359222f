//! A restart in the middle of a run: the time until the estimate is locked and armed again, and its error against a run
//! without a restart. A campaign makes 200 runs of each scene.

use rayon::prelude::*;
use rigs::data::Match;
use sim::synth::{Scenario, ScenarioKind, ScenarioPair};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Calibrator, Config, Extrinsics, FactoryCalibration, State};
use strum::VariantArray;
use test_support::{is_campaign, runs};

const RUNS: [u64; 2] = [6, 200];
const FIRST_SEED: u64 = 60_000;

/// Number of pairs before the restart, and after it.
const BEFORE: usize = 60;
const AFTER: usize = 10;

/// Number of pairs after the restart at which the estimates with and without a restart are compared, and the largest
/// ratios of their RMS errors: in a campaign, and over the few runs of a test.
const BOUNDS: [(usize, [f64; 2]); 3] = [(1, [1.05, 1.05]), (3, [1.02, 1.05]), (10, [1.01, 1.05])];

/// Largest ratio in any scene but a drift.
const MOST: f64 = 1.05;

/// Addition to the bounds of a flight, whose rig warps slowly. A restart forgets the window of the change detection,
/// and so follows the warp a few pairs later.
const FLIGHT: f64 = 0.02;

/// Largest ratio for a rig that drifts, and least share of its runs that lock and arm in time, percent.
const DRIFTING: f64 = 1.15;
const DRIFTING_IN_TIME: usize = 98;

/// Whether the errors of a kind are compared. A campaign compares all kinds. Over the few runs of a test, the errors of
/// a vehicle at rest and of a rig that drifts or flies differ by chance, because a restart forgets whether a scene
/// repeats the previous one.
fn is_compared(kind: ScenarioKind) -> bool {
    use ScenarioKind::{Creeping, Drift, Drives, Flight, Parked, ParkedLandmarks, WarmUp};
    is_campaign()
        || !matches!(kind, Parked | ParkedLandmarks | Creeping | Drift | WarmUp | Drives | Flight)
}

fn bound(kind: ScenarioKind, usual: f64) -> f64 {
    match kind {
        ScenarioKind::Drift | ScenarioKind::WarmUp => DRIFTING,
        ScenarioKind::Flight => (usual + FLIGHT).min(MOST),
        _ => usual,
    }
}

type Rig = Box<Calibrator<f32, 512>>;

/// Takes a pair and applies the estimate; returns whether the calibrator is locked, and whether it may arm.
fn take(calibrator: &mut Rig, pair: &ScenarioPair) -> [bool; 2] {
    // A pixel beyond the range of the lens is refused, and left out.
    let _ = calibrator.take_pair(pair.pair.matches.iter().map(Match::correspondence));
    let armed = calibrator.verdict().may_arm;
    let _ = calibrator.apply();
    [calibrator.state() == State::Locked, armed]
}

/// Errors of `t` and `R`, rad; `None` without an estimate.
fn error(calibrator: &Rig, truth: &Extrinsics<f64>) -> Option<[f64; 2]> {
    let found = calibrator.proposal()?.extrinsics;
    let found = Extrinsics::try_new(
        &found.rotation().matrix().map(f64::from),
        &found.translation().map(f64::from),
    );
    let Deviation { translation, rotation } = Deviation::between(&found.ok()?, truth);
    Some([translation, rotation])
}

/// One run, with a restart and without it.
struct Run {
    /// Number of pairs after the restart until locked and until armed: without a restart, and with one. [`AFTER`] + 1
    /// for never.
    until: [[usize; 2]; 2],
    /// Squared errors of `t` and `R`, rad^2, at the pairs of [`BOUNDS`]: without a restart, and with one.
    squared: [[[f64; 2]; 2]; 3],
}

/// `None` if the run is not locked before the restart.
fn run(kind: ScenarioKind, config: Config, seed: u64) -> Option<Run> {
    let mut scenario = Scenario::new(kind, BEFORE + AFTER);
    scenario.scene.outliers = scenario.scene.outliers.max(0.1);
    let cameras = scenario.scene.dataset(0, 0).unwrap().cameras().unwrap();
    let new = || -> Rig { Box::new(Calibrator::new(config, &FactoryCalibration::guess(cameras))) };
    let mut unbroken = new();
    let mut pairs = scenario.frames(seed).unwrap();
    let before = pairs.by_ref().take(BEFORE).map(|pair| take(&mut unbroken, &pair)).last()?;
    if !before[0] {
        return None;
    }
    let mut restarted = new();
    restarted.restore(&unbroken.snapshot()).unwrap();
    let never = AFTER + 1;
    let mut run = Run { until: [[never; 2]; 2], squared: [[[0.0; 2]; 2]; 3] };
    for (number, pair) in (1..).zip(pairs) {
        for (until, calibrator) in run.until.iter_mut().zip([&mut unbroken, &mut restarted]) {
            for (until, is_so) in until.iter_mut().zip(take(calibrator, &pair)) {
                *until = if is_so { (*until).min(number) } else { *until };
            }
        }
        for ((at, _), squared) in BOUNDS.iter().zip(&mut run.squared) {
            if *at == number {
                let errors = [&unbroken, &restarted].map(|c| error(c, &pair.scene.rig));
                let [one, other] = errors.map(|error| error.unwrap().map(|e| e * e));
                *squared = [one, other];
            }
        }
    }
    Some(run)
}

#[test]
fn a_restarted_rig_is_locked_and_armed_within_two_pairs_and_as_good_as_without_a_restart() {
    let mut worst = Vec::new();
    for kind in ScenarioKind::VARIANTS {
        let seeds = FIRST_SEED..FIRST_SEED + runs(RUNS[0], RUNS[1]);
        let all: Vec<Run> =
            seeds.into_par_iter().filter_map(|seed| run(*kind, Config::robust(), seed)).collect();
        let within_two =
            |[of, what]: [usize; 2]| all.iter().filter(move |r| r.until[of][what] <= 2);
        let [locked, armed, armed_unbroken] =
            [[1, 0], [1, 1], [0, 1]].map(|of| within_two(of).count());
        let late_alike = all.iter().filter(|r| r.until[1][0] > 2 && r.until[1] == r.until[0]);
        let ratios = [0, 1, 2].map(|at| {
            [0, 1].map(|error| {
                let sum = |of: usize| all.iter().map(|r| r.squared[at][of][error]).sum::<f64>();
                (sum(1) / sum(0)).sqrt()
            })
        });
        println!(
            "{kind:<16} {:>3} runs: locked {locked}, {} as late without a restart; \
             armed {armed} (unbroken {armed_unbroken}); e_t, e_theta {ratios:.3?}",
            all.len(),
            late_alike.count()
        );
        if all.is_empty() {
            continue;
        }
        // A pair that does not arm the unbroken run need not arm the restarted run.
        let armed_alike = all.iter().filter(|r| r.until[1][1] <= r.until[0][1].max(2)).count();
        let is_late = match kind {
            ScenarioKind::Drift | ScenarioKind::WarmUp => {
                100 * locked.min(armed_alike) < DRIFTING_IN_TIME * all.len()
            }
            _ => locked < all.len() || armed < armed_unbroken || armed_alike < all.len(),
        };
        if is_late {
            worst.push(format!("{kind}: {locked} locked, {armed} armed of {armed_unbroken}"));
        }
        for ((pairs, bounds), ratios) in BOUNDS.iter().zip(ratios) {
            let bound = bound(*kind, bounds[usize::from(!is_campaign())]);
            if is_compared(*kind) && ratios.iter().any(|ratio| *ratio > bound) {
                worst.push(format!("{kind}: {ratios:?} after {pairs}"));
            }
        }
    }
    assert!(worst.is_empty(), "{worst:#?}");
}
