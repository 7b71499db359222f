//! Recorded matches with falsified lens models: the reported deviations cover the error, and lens compensation removes
//! most of the error.

use rigs::data::Dataset;
use sim::run::{Apply, Capacity, Estimate, Feed, RunLog, Start, Verdict, replay_pairs};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Config, Fused, LensTracking, State};

const SETS: [&str; 2] = ["opencv_chess_corners", "opencv_chess_sift"];

/// Number of pairs of each set. A set has as many cyclic orders.
const ORDERS: usize = 13;

/// Largest ratio of an error to its reported deviation, with the lens uncertain.
const MOST_SD: f64 = 2.5;

/// Largest relative error with which a falsification of 0.01 is found.
const MOST_OFF: f64 = 0.15;

/// Largest relative error with which a smaller falsification is found. Its reported deviation is a fifth to a third of
/// the falsification.
const MOST_OFF_SMALL: f64 = 0.25;

/// A falsification of the right camera: relative focal length, `k1`, principal column and row, px.
#[derive(Debug, Clone, Copy, Default)]
struct Falsified {
    focal: f64,
    k1: f64,
    cx: f64,
    cy: f64,
}

fn cases() -> Vec<Falsified> {
    let mut cases = vec![Falsified::default()];
    for sign in [1.0, -1.0] {
        cases.extend([0.003, 0.01].map(|f| Falsified { focal: sign * f, ..Falsified::default() }));
        cases.push(Falsified { k1: sign * 0.01, ..Falsified::default() });
        cases.push(Falsified { cx: sign * 3.0, ..Falsified::default() });
        cases.push(Falsified { cy: sign, ..Falsified::default() });
    }
    cases
}

fn run(name: &str, falsified: Falsified, tracking: LensTracking) -> RunLog {
    run_from(0, name, falsified, tracking)
}

/// Replays the pairs from number `first` on, then the pairs before it.
fn run_from(first: usize, name: &str, falsified: Falsified, tracking: LensTracking) -> RunLog {
    let mut set = Dataset::load(&Dataset::shipped().join(name)).unwrap();
    assert_eq!(set.pairs.len(), ORDERS);
    set.pairs.rotate_left(first);
    let Falsified { focal, k1, cx, cy } = falsified;
    let [[fx, _, px], [_, fy, py], _] = &mut set.meta.k_r;
    (*fx, *fy, *px, *py) = (*fx * (1.0 + focal), *fy * (1.0 + focal), *px + cx, *py + cy);
    set.meta.dist_r[0] += k1;
    let config = Config::robust().with_lens_tracking(tracking);
    replay_pairs(
        Feed::of(&set).unwrap(),
        config,
        Start::<f32>::Guess,
        Capacity::N2048,
        Apply::Each,
        |_| (),
    )
    .unwrap()
}

fn end(log: &RunLog) -> (Estimate, Deviation<f64>) {
    let last = log.steps().last().unwrap();
    (last.estimate.unwrap(), last.running.unwrap())
}

/// Asserts that no estimate with an error above five deviations is armed, and that the error at the end is within
/// [`MOST_SD`] deviations.
fn assert_covered(log: &RunLog, case: &str) {
    for step in log.steps() {
        let (Some(estimate), Some(error)) = (step.estimate, step.running) else { continue };
        let sd = estimate.sd_lens;
        let worst = (error.translation / sd.translation).max(error.rotation / sd.rotation);
        let armed = step.checked.is_some_and(|checked| checked.is_armed());
        assert!(!armed || worst <= 5.0, "{case}: armed at {worst}");
    }
    let (Estimate { sd_lens: sd, .. }, error) = end(log);
    let [t, r] = [error.translation / sd.translation, error.rotation / sd.rotation];
    assert!(t <= MOST_SD && r <= MOST_SD, "{case}: {t} {r}");
}

#[test]
fn errors_stay_within_the_deviations_with_the_lens_uncertain_and_none_beyond_five_is_armed() {
    for name in SETS {
        for falsified in cases() {
            let log = run(name, falsified, LensTracking::Report);
            assert_covered(&log, &format!("{name} {falsified:?}"));
        }
    }
}

#[test]
fn errors_with_compensation_are_covered_and_runs_without_a_correction_equal_those_that_report() {
    for name in SETS {
        for falsified in cases() {
            let case = format!("{name} {falsified:?}");
            let log = run(name, falsified, LensTracking::Compensate);
            assert_covered(&log, &case);
            if !log.has_begun_again() {
                let reported = run(name, falsified, LensTracking::Report);
                assert_eq!(log.steps(), reported.steps(), "{case}");
            }
        }
        let as_calibrated = run(name, Falsified::default(), LensTracking::Compensate);
        assert!(!as_calibrated.has_begun_again(), "{name}");
    }
}

/// Whether the 13 pairs suffice for a correction depends on their order. Three of the pairs with SIFT matches show in part
/// the background of the pair before, and count less.
#[test]
fn a_wrong_focal_length_is_corrected_in_10_of_13_orders_of_the_pairs() {
    for name in SETS {
        for falsified in cases().into_iter().filter(|falsified| falsified.focal != 0.0) {
            let is_corrected = |first: &usize| {
                run_from(*first, name, falsified, LensTracking::Compensate).has_begun_again()
            };
            let corrected = (0..ORDERS).filter(is_corrected).count();
            assert!(corrected >= ORDERS - 3, "{name} {falsified:?}: {corrected}");
        }
    }
}

/// A wrong `k1` is corrected only for `opencv_chess_sift`, because for the other set the correction would not halve the
/// deviation of `t`.
#[test]
fn a_compensated_lens_is_found_and_leaves_the_error_of_the_correct_lens() {
    for name in SETS {
        let (right, of_right) = end(&run(name, Falsified::default(), LensTracking::Compensate));
        for falsified in cases() {
            let case = format!("{name} {falsified:?}");
            let Falsified { focal, k1, .. } = falsified;
            let orders = if focal == 0.0 { 1 } else { ORDERS };
            // A correction at one of the last two pairs leaves one pair at most.
            let is_early = |log: &RunLog| {
                let corrected = Verdict::Accepted(Fused::LensCorrected);
                let mut early = log.steps().iter().rev().skip(2);
                early.any(|step| step.verdict == corrected)
            };
            let mut logs =
                (0..orders).map(|first| run_from(first, name, falsified, LensTracking::Compensate));
            let Some(log) = logs.find(is_early) else {
                assert!(focal == 0.0, "{case}");
                continue;
            };
            let (estimate, error) = end(&log);
            // The pairs after the correction may be few, so their own deviation counts.
            let sd = estimate.sd_lens.translation.max(right.sd_lens.translation);
            let most = of_right.translation + 2.0 * sd;
            assert!(error.translation <= most, "{case}: {error:?} {sd}");
            let (found, true_ratio) = (estimate.correction, 1.0 / (1.0 + focal) - 1.0);
            // With SIFT matches the correction may come so late that the remaining pairs do not lock the estimate. The
            // correction is then not compared with the falsification.
            if estimate.state != State::Locked {
                assert_eq!(name, SETS[1], "{case}");
                continue;
            }
            let lens = estimate.lens.unwrap();
            let off =
                [(found.focal - true_ratio, focal, lens.focal.sd), (found.k1 + k1, k1, lens.k1.sd)];
            for (off, given, sd) in off.into_iter().filter(|(_, given, _)| *given != 0.0) {
                let most = if given.abs() < 0.01 { MOST_OFF_SMALL } else { MOST_OFF };
                assert!((off / given).abs() <= most, "{case}: {found:?}");
                assert!(off.abs() <= MOST_SD * sd, "{case}: {found:?}, sd {sd}");
            }
        }
    }
}
