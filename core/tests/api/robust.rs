//! The robust preset: exact where it can be, bounded, the same bits pass by pass, and its fusion.

use crate::scene::{cameras, correspondences, rig};
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Config, Correspondence, Extrinsics, InformationMean, PairError, PairReport,
    Refusal, Scalar, Stop,
};

const ROTATION: [f64; 3] = [3.0, -2.5, 4.0];
const BASELINE: [f64; 2] = [4.0, -3.0];

fn calibrator<T: Scalar>() -> Calibrator<T, 256> {
    let mut calibrator = Calibrator::new(Config::robust());
    calibrator.set_cameras(cameras());
    calibrator
}

/// Three in ten right points exchanged among themselves.
fn among_mismatches<T: Scalar>(noise_px: f64, seed: u64) -> Vec<Correspondence<T>> {
    let mut all = correspondences::<T>(&rig(ROTATION, BASELINE), 250, noise_px, seed);
    for i in 0..74 {
        let other = all[i + 1].right;
        all[i].right = other;
    }
    all
}

fn solved<T: Scalar>(noise_px: f64, seed: u64) -> PairReport<T> {
    let mut calibrator = calibrator::<T>();
    for c in among_mismatches(noise_px, seed) {
        calibrator.push(&c).unwrap();
    }
    calibrator.solve_pair().unwrap()
}

#[test]
fn exact_correspondences_among_mismatches_give_the_rig() {
    let truth = rig(ROTATION, BASELINE);
    let error = Deviation::between(&solved::<f64>(0.0, 1).extrinsics, &truth);
    // What the prior of 0.1 rad holds against a noise floor of 0.15 px.
    assert!(error.translation < 2e-4 && error.rotation < 2e-4, "{error:?}");
}

#[test]
fn takes_no_more_than_twelve_passes_and_reports_them() {
    let report = solved::<f32>(0.5, 2);
    assert!(report.passes <= 12 && report.stop == Stop::Converged, "{report:?}");
    assert!(report.rms_px_after < 0.6 && report.cost_after < report.cost_before);
    // Uniform noise of +-0.5 px.
    assert!((report.noise_px * 12.0_f32.sqrt() - 1.0).abs() < 0.2, "{}", report.noise_px);
}

#[test]
fn pass_by_pass_gives_the_same_bits_as_one_call() {
    let mut calibrator = calibrator::<f32>();
    for c in among_mismatches(0.5, 3) {
        calibrator.push(&c).unwrap();
    }
    let whole = calibrator.solve_pair().unwrap();
    calibrator.begin_pair().unwrap();
    let stepped = (0..13).find_map(|_| calibrator.advance_pair().unwrap()).unwrap();
    assert_eq!(stepped, whole);
}

#[test]
fn the_score_takes_most_of_the_prior_back_out() {
    // The baseline is four of the prior's deviations off, and each pair is weaker than the prior.
    let truth = rig::<f64>([0.0; 3], [0.3, 0.4]);
    let config = Config::robust().with_prior_sd_rad(0.002).unwrap();
    let mut calibrator = Calibrator::<f64, 256>::new(config);
    calibrator.set_cameras(cameras());
    for seed in 0..100 {
        for c in correspondences(&truth, 16, 1.0, seed) {
            calibrator.push(&c).unwrap();
        }
        // With so few matches some pairs have no consensus.
        if let Ok(report) = calibrator.solve_pair() {
            calibrator.fuse(&report).unwrap();
        }
        calibrator.clear_pair();
    }
    let estimate = calibrator.estimate().unwrap();
    let error = Deviation::between(&estimate.extrinsics, &truth);
    // 8.7e-3 off at the start; twice as far off if the pairs were fused as they are.
    assert!(error.translation < 4e-3 && error.rotation < 6e-4, "{error:?}");
}

#[test]
fn a_pair_fused_from_afar_is_its_own_estimate() {
    let report = solved::<f32>(0.5, 4);
    let mut fusion = InformationMean::from_prior(Extrinsics::SIDE_BY_SIDE, 10.0);
    assert!(fusion.add(&report));
    let estimate = fusion.estimate().unwrap();
    let error = Deviation::between(&estimate.extrinsics, &report.extrinsics);
    assert!(error.translation < 1e-4 && error.rotation < 1e-4, "{error:?}");
}

#[test]
fn a_million_pairs_in_f32_stay_where_they_are_and_claim_what_they_know() {
    let singles: Vec<PairReport<f32>> = (0..100).map(|seed| solved(0.5, seed)).collect();
    let mut fusion = InformationMean::from_prior(Extrinsics::SIDE_BY_SIDE, 0.1);
    let mut after = |rounds: u32| {
        for _ in 0..rounds {
            for report in &singles {
                assert!(fusion.add(report));
            }
        }
        fusion.estimate().unwrap()
    };
    let [first, last] = [after(1), after(9999)];
    assert_eq!(last.pairs, 1_000_000);
    let drift = Deviation::between(&last.extrinsics, &first.extrinsics);
    assert!(drift.translation < first.sd.translation / 2.0, "{drift:?} {:?}", first.sd);
    assert!(drift.rotation < first.sd.rotation / 2.0, "{drift:?} {:?}", first.sd);
    // A hundredth of the deviation for ten thousand times the information.
    let shrunk = first.sd.translation / last.sd.translation;
    assert!((95.0..105.0).contains(&shrunk), "{shrunk}");
}

#[test]
fn a_noise_floor_above_all_noise_is_a_refusal_and_no_panic() {
    let config = Config::robust().with_noise_floor_px(50.0).unwrap();
    let mut calibrator = Calibrator::<f32, 256>::new(config);
    calibrator.set_cameras(cameras());
    for c in among_mismatches(0.5, 5) {
        calibrator.push(&c).unwrap();
    }
    assert_eq!(calibrator.solve_pair(), Err(PairError::NoConsensus));
}

#[test]
fn a_pair_that_leads_to_no_rig_is_not_taken_and_changes_nothing() {
    let mut report = solved::<f32>(0.5, 6);
    let mut fusion = InformationMean::from_prior(Extrinsics::SIDE_BY_SIDE, 0.1);
    report.score = [0.0, 0.0, 0.0, f32::MAX, 0.0];
    assert!(!fusion.add(&report));
    assert_eq!((fusion.pairs(), fusion.estimate()), (0, None));
}

#[test]
fn weak_pairs_that_agree_on_what_is_beyond_the_correction_limit_stop_short_of_it() {
    let config = Config::robust().with_max_correction_rad(0.05).unwrap();
    let mut calibrator = Calibrator::<f32, 256>::new(config);
    calibrator.set_cameras(cameras());
    for c in correspondences(&rig([0.1, 0.0, 0.0], [0.0, 0.0]), 40, 0.5, 7) {
        calibrator.push(&c).unwrap();
    }
    let mut report = calibrator.solve_pair().unwrap();
    // What a prior held against a pair that says 0.2 rad more of the baseline.
    let pull = report.information.matrix() * nalgebra::Vector5::new(0.0, 0.0, 0.0, 0.2, 0.0);
    report.score = pull.into();
    let before = calibrator.estimate();
    assert_eq!(calibrator.fuse(&report), Err(Refusal::CorrectionLimit));
    assert_eq!(calibrator.estimate(), before);
}

#[test]
fn passes_that_only_anneal_give_no_consensus() {
    let solved_in = |passes| {
        let config = Config::robust().with_max_passes(passes).unwrap();
        let mut calibrator = Calibrator::<f32, 256>::new(config);
        calibrator.set_cameras(cameras());
        for c in among_mismatches(0.5, 8) {
            calibrator.push(&c).unwrap();
        }
        calibrator.solve_pair().map(|report| report.stop)
    };
    assert_eq!(solved_in(4), Err(PairError::NoConsensus));
    assert_eq!(solved_in(6), Ok(Stop::PassLimit));
}
