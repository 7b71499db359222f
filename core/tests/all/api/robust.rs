//! The robust preset: exact without noise, with a bounded number of passes, and with the same bits pass by pass.

use crate::api::disturbed::garbage;
use crate::api::presets::{robust, with};
use crate::api::scene::{correspondences, fill, rig, take};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::outcome::Stop;
use stereo_selfcal::{
    Calibrator, Config, ConfigError, Correspondence, PairReport, PushError, Rejection, Scalar,
    State,
};

const ROTATION: [f64; 3] = [3.0, -2.5, 4.0];
const BASELINE: [f64; 2] = [4.0, -3.0];

/// A pair of 250 matches in which the first 74 have the right point of the next match: outliers.
fn among_outliers<T: Scalar>(noise_px: f64, seed: u64) -> Vec<Correspondence<T>> {
    let mut all = correspondences::<T>(&rig(ROTATION, BASELINE), 250, noise_px, seed);
    for i in 0..74 {
        let other = all[i + 1].right;
        all[i].right = other;
    }
    all
}

fn filled<T: Scalar>(config: Config, noise_px: f64, seed: u64) -> Calibrator<T, 256> {
    let mut calibrator = with(config);
    fill(&mut calibrator, &among_outliers(noise_px, seed));
    calibrator
}

fn solved<T: Scalar>(noise_px: f64, seed: u64) -> PairReport<T> {
    filled(Config::robust(), noise_px, seed).solve_pair().pair.unwrap()
}

/// A calibrator that has locked on the rig.
fn locked<T: Scalar>() -> Calibrator<T, 256> {
    let mut calibrator = robust();
    for seed in 100..105 {
        take(&mut calibrator, &among_outliers(0.5, seed)).unwrap();
    }
    assert_eq!(calibrator.state(), State::Locked);
    calibrator
}

#[test]
fn exact_correspondences_among_outliers_give_the_rig() {
    let truth = rig(ROTATION, BASELINE);
    let error = Deviation::between(&solved::<f64>(0.0, 1).extrinsics, &truth);
    // At a noise floor of 0.15 px, the prior of 0.1 rad may bias the result by this much.
    assert!(error.translation < 2e-4 && error.rotation < 2e-4, "{error:?}");
}

#[test]
fn a_knock_before_the_lock_takes_no_more_passes_than_the_limit() {
    let knocked = rig([ROTATION[0] + 1.0, ROTATION[1], ROTATION[2]], BASELINE);
    let longest = |limit: u16, seed: u64| {
        let config = Config::robust().with_max_passes(limit).unwrap();
        let mut calibrator = with::<f64, 256>(config);
        for n in 0..3 {
            let matches = correspondences(&rig(ROTATION, BASELINE), 250, 0.5, 3 * seed + n);
            let _ = take(&mut calibrator, &matches);
        }
        // This pair may take a search with a turned baseline, a track of the challenger, and a last search.
        fill(&mut calibrator, &correspondences(&knocked, 250, 0.5, 100 + seed));
        let outcome = calibrator.solve_pair();
        assert_ne!(outcome.fused, Err(Rejection::NotBegun), "{limit}, {seed}");
        outcome.pair.map_or(0, |report| {
            let off = Deviation::between(&report.extrinsics, &knocked);
            assert!(limit < 24 || off.rotation < 0.01, "{off:?}");
            report.passes
        })
    };
    for limit in 2..=24 {
        let most = (0..12).map(|seed| longest(limit, seed)).max().unwrap();
        assert!(most <= limit.max(9), "{limit}: {most}");
        assert!(limit < 24 || most >= 20, "{most}");
    }
}

#[test]
fn a_search_takes_no_more_than_twelve_passes_and_reports_them() {
    let report = solved::<f32>(0.5, 2);
    assert!(report.passes <= 12 && report.stop == Stop::Converged, "{report:?}");
    assert!(report.rms_px_after < 0.6 && report.cost_after < report.cost_before);
    // Uniform noise of +-0.5 px has a standard deviation of 1 px over the root of 12.
    assert!((report.noise_px * 12.0_f32.sqrt() - 1.0).abs() < 0.2, "{}", report.noise_px);
}

/// The report of a pair that is solved with one pass per call, and the number of calls.
fn stepped(calibrator: &mut Calibrator<f32, 256>) -> (PairReport<f32>, u16) {
    let (outcome, calls) =
        (1..=16).find_map(|calls| Some((calibrator.advance_pair()?, calls))).unwrap();
    (outcome.pair.unwrap(), calls)
}

#[test]
fn pass_by_pass_gives_the_same_bits_as_one_call() {
    let [mut one, mut other] = [(); 2].map(|()| filled(Config::robust(), 0.5, 3));
    let whole = one.solve_pair().pair.unwrap();
    let (by_pass, calls) = stepped(&mut other);
    assert_eq!(by_pass, whole);
    // Each call takes one pass; two further calls fuse and judge.
    assert_eq!(calls, whole.passes + 2);
}

#[test]
fn a_locked_rig_is_tracked_in_four_passes_and_with_the_same_bits_pass_by_pass() {
    let [mut one, mut other] = [(); 2].map(|()| locked::<f32>());
    for calibrator in [&mut one, &mut other] {
        fill(calibrator, &among_outliers(0.5, 4));
    }
    let whole = one.solve_pair().pair.unwrap();
    assert_eq!(stepped(&mut other).0, whole);
    assert!(whole.passes <= 4, "{}", whole.passes);
    let error = Deviation::between(&whole.extrinsics, &rig(ROTATION, BASELINE));
    let sd = whole.information.standard_deviations().unwrap();
    assert!(error.translation < 4.0 * sd.translation && error.rotation < 4.0 * sd.rotation);
}

#[test]
fn the_prior_counts_once_however_many_pairs() {
    // The baseline is off by four standard deviations of the prior, and each pair is weaker than the prior.
    let truth = rig::<f64>([0.0; 3], [0.3, 0.4]);
    let config = Config::robust().with_prior_sd_rad(0.002).unwrap();
    let mut calibrator = with::<f64, 256>(config);
    for seed in 0..100 {
        // With so few matches some pairs have no consensus.
        let _ = take(&mut calibrator, &correspondences(&truth, 16, 1.0, seed));
    }
    let proposal = calibrator.proposal().unwrap();
    let error = Deviation::between(&proposal.extrinsics, &truth);
    // The baseline starts 8.7e-3 rad off. If every pair added the prior, it would stay off by twice this limit.
    assert!(error.translation < 4e-3 && error.rotation < 6e-4, "{error:?}");
}

#[test]
fn the_first_pair_is_its_own_estimate_and_claims_its_own_deviation() {
    let mut calibrator = filled::<f32>(Config::robust(), 0.5, 4);
    let outcome = calibrator.solve_pair();
    assert!(outcome.fused.is_ok());
    let report = outcome.pair.unwrap();
    let proposal = calibrator.proposal().unwrap();
    let sd = report.information.standard_deviations().unwrap();
    let error = Deviation::between(&proposal.extrinsics, &report.extrinsics);
    // The prior of 0.1 rad may bias the result by this much.
    assert!(error.translation < 0.1 * sd.translation && error.rotation < 0.1 * sd.rotation);
    assert!((proposal.sd.translation / sd.translation - 1.0).abs() < 0.02);
    assert!((proposal.sd.rotation / sd.rotation - 1.0).abs() < 0.02);
    assert_eq!(proposal.pairs, 1);
}

#[test]
fn the_covariance_is_of_the_unknowns_to_the_truth_and_sums_up_to_the_deviations() {
    let truth = RectifyingRotations::from(&rig::<f64>(ROTATION, BASELINE));
    let [mut sum, runs] = [0.0, 30.0];
    for run in 0..30 {
        let mut calibrator = robust::<f64>();
        for seed in 0..8 {
            take(&mut calibrator, &among_outliers(0.5, 8 * run + seed)).unwrap();
        }
        let proposal = calibrator.proposal().unwrap();
        let covariance = proposal.covariance;
        let off = RectifyingRotations::from(&proposal.extrinsics).unknowns_to(&truth);
        sum += off.dot(&(covariance.try_inverse().unwrap() * off)) / 5.0 / runs;
        let [r, t] =
            [covariance.m11 + covariance.m22 + covariance.m33, covariance.m44 + covariance.m55];
        assert!((proposal.sd.rotation.powi(2) / r - 1.0).abs() < 1e-9);
        assert!((proposal.sd.translation.powi(2) / t - 1.0).abs() < 1e-9);
    }
    // The scatter of the pairs and the disagreement of image halves only increase the deviations.
    assert!((0.5..1.3).contains(&sum), "{sum}");
}

#[test]
fn a_pair_counts_once_and_not_after_a_reset() {
    let mut calibrator = with::<f32, 256>(Config::robust());
    take(&mut calibrator, &among_outliers(0.0, 5)).unwrap();
    let before = calibrator.proposal();
    assert!(before.is_some());
    let none = Err(Rejection::TooFew { usable: 0, needed: 12 });
    assert_eq!(calibrator.solve_pair().fused, none);
    assert_eq!(calibrator.proposal(), before);

    fill(&mut calibrator, &among_outliers(0.0, 8));
    assert_eq!([(); 2].map(|()| calibrator.advance_pair()), [None; 2]);
    calibrator.reset();
    assert_eq!(calibrator.solve_pair().fused, none);
    assert_eq!(calibrator.proposal(), None);
}

#[test]
fn a_noise_floor_whose_square_is_zero_or_above_all_noise_is_refused() {
    for px in [1e-30, 9.9e-4, 5.1, 100.1, 0.0, -1.0, f32::INFINITY, f32::NAN] {
        assert_eq!(Config::robust().with_noise_floor_px(px), Err(ConfigError::NoiseFloor), "{px}");
    }
}

#[test]
fn a_least_number_above_the_capacity_refuses_every_pair_and_says_both_numbers() {
    let config = Config::robust().with_min_correspondences(300).unwrap();
    let mut calibrator = with::<f32, 256>(config);
    fill(&mut calibrator, &correspondences(&rig(ROTATION, BASELINE), 400, 0.5, 9));
    assert_eq!(calibrator.solve_pair().fused, Err(Rejection::TooFew { usable: 256, needed: 300 }));
}

#[test]
fn a_pair_that_runs_out_of_passes_says_so() {
    let config = Config::robust().with_max_passes(5).unwrap();
    let report = filled::<f32>(config, 0.5, 8).solve_pair().pair.unwrap();
    assert_eq!((report.stop, report.passes), (Stop::PassesSpent, 5));
}

#[test]
fn passes_are_bounded_however_many_hypotheses_are_compared() {
    for limit in 2..=24 {
        let mut calibrator = with::<f32, 256>(Config::robust().with_max_passes(limit).unwrap());
        let mut most = 0;
        for seed in 0..60 {
            // Three rigs in turn, with pairs of only outliers in between; some of these are small.
            let turned = ROTATION.map(|angle| angle - (seed / 5 % 3) as f64);
            let mut matches = correspondences(&rig(turned, BASELINE), 250, 0.5, seed);
            if seed % 7 == 6 {
                matches = garbage(if seed % 2 == 0 { 64 } else { 250 }, seed);
            }
            fill(&mut calibrator, &matches);
            let (calls, outcome) =
                (1..100).find_map(|call| Some((call, calibrator.advance_pair()?))).unwrap();
            // The last two calls fuse and judge; after an error, the last one judges.
            let passes = calls - if outcome.pair.is_some() { 2 } else { 1 };
            most = most.max(passes);
            assert!(outcome.pair.is_none_or(|report| report.passes == passes));
        }
        assert!(most > 4 && most <= limit.max(9), "{limit}: {most}");
    }
}

#[test]
fn a_batch_of_the_least_number_is_solved() {
    let mut calibrator = with::<f32, 256>(Config::robust());
    fill(&mut calibrator, &correspondences(&rig(ROTATION, BASELINE), 12, 0.1, 9));
    assert!(!matches!(calibrator.solve_pair().fused, Err(Rejection::TooFew { .. })));
}

#[test]
fn a_batch_of_fewer_than_the_least_solves_nothing() {
    let mut small = with::<f32, 8>(Config::robust());
    fill(&mut small, &correspondences(&rig(ROTATION, BASELINE), 200, 0.5, 9));
    assert_eq!(small.batch().matches().len(), 8);
    assert_eq!(small.solve_pair().fused, Err(Rejection::TooFew { usable: 8, needed: 12 }));
}

#[test]
fn a_batch_that_selects_64_of_many_locks_on_the_rig() {
    let truth = rig::<f32>(ROTATION, BASELINE);
    let mut small = with::<f32, 64>(Config::robust());
    for seed in 0..10 {
        take(&mut small, &among_outliers(0.5, seed)).unwrap();
        assert_eq!(small.batch().matches().len(), 64);
    }
    let proposal = small.proposal().unwrap();
    assert_eq!((proposal.state, proposal.pairs), (State::Locked, 10));
    let error = Deviation::between(&proposal.extrinsics, &truth);
    let sd = proposal.sd;
    assert!(error.translation < 4.0 * sd.translation && error.rotation < 4.0 * sd.rotation);
}

#[test]
fn a_pair_that_is_being_solved_can_be_abandoned_and_leaves_no_trace() {
    let batch = |seed| correspondences::<f32>(&rig(ROTATION, BASELINE), 256, 0.5, seed);
    let mut calibrators = [0, 1].map(|_| with::<f32, 256>(Config::robust()));
    let [abandoned, fresh] = &mut calibrators;
    fill(abandoned, &batch(1));
    assert_eq!(abandoned.advance_pair(), None);
    assert_eq!(abandoned.push(&batch(1)[0]), Err(PushError::Busy));
    abandoned.discard_pair();
    let [report, expected] = [abandoned, fresh].map(|calibrator| {
        fill(calibrator, &batch(2));
        calibrator.solve_pair()
    });
    assert_eq!(report, expected);
}

#[test]
fn a_calibrator_of_256_correspondences_fits_11_kib() {
    let bytes = size_of::<Calibrator<f32, 256>>();
    println!("Calibrator<f32, 256>: {bytes} bytes");
    assert!(bytes <= 11_264);
}
