//! Matches with a common error: rounded to a grid, shifted in one half of the image, or shifted as a second crowd.

use crate::api::presets::{robust, with};
use crate::api::scene::{cameras, correspondences, fill, rig, take};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    ApplyError, Calibrator, Config, Correspondence, FactoryCalibration, Reason, Reasons, State,
};

const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
const BASELINE: [f64; 2] = [0.5, -0.4];

fn scene(rotation: [f64; 3], seed: u64) -> Vec<Correspondence<f32>> {
    correspondences(&rig(rotation, BASELINE), 250, 0.5, seed)
}

/// The matches with their coordinates rounded to whole pixels.
fn rounded(mut matches: Vec<Correspondence<f32>>) -> Vec<Correspondence<f32>> {
    for c in &mut matches {
        (c.left, c.right) = (c.left.map(f32::round), c.right.map(f32::round));
        c.grid_step = 1.0;
    }
    matches
}

/// Whether no reason doubts the matches.
fn is_undoubted(reasons: Reasons) -> bool {
    let doubts = [Reason::SecondMode, Reason::Biased, Reason::ImageHalves];
    doubts.into_iter().all(|doubt| !reasons.contains(doubt))
}

#[test]
fn rows_rounded_to_whole_pixels_leave_the_estimate_unbiased() {
    // The rig is almost rectified, so the row offsets have only a few whole values.
    let truth = [0.01, 0.0, 0.01];
    let rectified = RectifyingRotations::from(&rig::<f32>(truth, [0.02, 0.01]));
    let mut calibrator = robust::<f32>();
    for seed in 0..60 {
        let matches = correspondences(&rig(truth, [0.02, 0.01]), 250, 0.3, seed);
        take(&mut calibrator, &rounded(matches)).unwrap();
    }
    let proposal = calibrator.proposal().unwrap();
    assert_eq!(proposal.state, State::Locked);
    let off = RectifyingRotations::from(&proposal.extrinsics).unknowns_to(&rectified);
    let covariance = proposal.covariance;
    let deviations = off.component_div(&covariance.diagonal().map(f32::sqrt));
    assert!(deviations.amax() < 3.5, "{deviations} {proposal:?}");
    // A bias of 0.25 px in the row offset would give 2e-4 rad of pitch.
    assert!(off.x.abs() < 5e-5, "{off}");
}

/// A pair in which the matches of the left half of the image are too low by `bias_px` in the right image.
fn biased(bias_px: f32, seed: u64) -> Vec<Correspondence<f32>> {
    let mut matches = scene(ROTATION, seed);
    for c in matches.iter_mut().filter(|c| c.left[0] < 960.0) {
        c.right[1] = (c.right[1] + bias_px).min(1199.0);
    }
    matches
}

/// A calibrator with exact lens models. It does not apply an estimate if the image halves disagree strongly.
fn exact_lens() -> Calibrator<f32, 256> {
    with(Config::robust().without_lens_prior())
}

#[test]
fn with_an_uncertain_lens_matches_biased_in_one_half_widen_the_deviations_and_do_not_block() {
    let truth = rig(ROTATION, BASELINE);
    let mut calibrator = robust::<f32>();
    for seed in 0..20 {
        take(&mut calibrator, &biased(1.5, seed)).unwrap();
        let proposal = calibrator.proposal().unwrap();
        assert!(proposal.reasons().contains(Reason::ImageHalves), "{seed}");
        assert!(!proposal.reasons().contains(Reason::Biased), "{seed}");
        let error = Deviation::between(&proposal.extrinsics, &truth);
        let sd = proposal.sd_lens;
        assert!(error.translation < 4.0 * sd.translation && error.rotation < 4.0 * sd.rotation);
    }
    assert_eq!(calibrator.state(), State::Locked);
    assert!(calibrator.apply().is_ok());
}

#[test]
fn a_fit_to_the_baseline_in_use_is_applied_once() {
    // Image halves that disagree hold the baseline in use, which is off by half a degree, so the rows stay better with
    // the estimate than with what is applied.
    let given = rig(ROTATION, [BASELINE[0] + 0.5, BASELINE[1] - 0.5]);
    let factory = FactoryCalibration::new(cameras(), given);
    for bias_px in [0.5, 0.6] {
        let config = Config::robust().without_lens_prior();
        let mut calibrator = Calibrator::<f32, 256>::new(config, &factory);
        let mut applied = 0;
        for seed in 0..60 {
            let _ = take(&mut calibrator, &biased(bias_px, seed));
            if calibrator.verdict().should_apply {
                calibrator.apply().unwrap();
                applied += 1;
            }
        }
        assert_eq!(applied, 1, "{bias_px}");
    }
}

#[test]
fn matches_biased_in_one_half_of_the_image_are_doubted_and_never_applied() {
    let [mut healthy, mut suspect] = [(); 2].map(|()| exact_lens());
    let truth = rig(ROTATION, BASELINE);
    for seed in 0..20 {
        take(&mut healthy, &scene(ROTATION, seed)).unwrap();
        assert!(is_undoubted(healthy.proposal().unwrap().reasons()), "{seed}");
        take(&mut suspect, &biased(1.5, seed)).unwrap();
        let proposal = suspect.proposal().unwrap();
        assert!(proposal.reasons().contains(Reason::ImageHalves), "{seed}");
        assert!(seed == 0 || proposal.reasons().contains(Reason::Biased), "{seed}");
        let refused = suspect.apply().unwrap_err();
        let locked = proposal.state == State::Locked;
        assert_eq!(refused == ApplyError::Doubtful, locked, "{seed} {refused:?}");
        let error = Deviation::between(&proposal.extrinsics, &truth);
        let sd = proposal.sd;
        assert!(error.translation < 4.0 * sd.translation && error.rotation < 4.0 * sd.rotation);
    }
    let verdict = suspect.verdict();
    assert!(verdict.reasons.contains(Reason::Biased) && !verdict.may_arm, "{verdict}");
    let [reported, usual] = [&suspect, &healthy].map(|c| c.proposal().unwrap().sd);
    assert!(reported.rotation > 5.0 * usual.rotation, "{reported:?} {usual:?}");
    assert!(reported.translation > 5.0 * usual.translation, "{reported:?} {usual:?}");
}

#[test]
fn where_halves_disagree_a_little_the_baseline_in_use_is_kept_and_the_rotation_fitted_to_it() {
    let factory = rig([0.9, -0.4, 0.7], [0.4, -0.3]);
    let made = FactoryCalibration::new(cameras(), factory);
    let config = Config::robust().without_lens_prior();
    let mut calibrator = Calibrator::<f32, 256>::new(config, &made);
    let mut seen = 0;
    for seed in 0..60 {
        take(&mut calibrator, &biased(0.2, seed)).unwrap();
        let proposal = calibrator.proposal().unwrap();
        let reasons = proposal.reasons();
        let [halves, biased] = [Reason::ImageHalves, Reason::Biased].map(|r| reasons.contains(r));
        let second = reasons.contains(Reason::SecondMode);
        if proposal.state == State::Locked && halves && !biased && !second {
            seen += 1;
            let applied = calibrator.apply().unwrap();
            assert_eq!(applied.extrinsics.translation(), factory.translation());
            // The row offset stays below half a pixel, although both angles of the baseline are off by 0.1 degrees.
            let details = calibrator.details().unwrap();
            assert!(details.in_use_px < 0.5, "{details}");
        }
    }
    assert!(seen > 0);
}

/// A pair of 250 matches at a repetitive structure, such as a fence: the first `matches` matches are shifted by
/// `across_px` across the rows.
pub(crate) fn fence(matches: usize, across_px: f32, seed: u64) -> Vec<Correspondence<f32>> {
    let mut all = scene(ROTATION, seed);
    for c in all.iter_mut().take(matches) {
        c.right[1] = (c.right[1] + across_px).clamp(0.0, 1199.0);
    }
    all
}

#[test]
fn the_larger_of_two_crowds_of_matches_is_the_scene() {
    for (matches, across) in [(75, 3.0), (100, -3.0)] {
        let mut calibrator = robust::<f32>();
        for seed in 0..12 {
            take(&mut calibrator, &fence(matches, across, seed)).unwrap();
        }
        let proposal = calibrator.proposal().unwrap();
        let off = Deviation::between(&proposal.extrinsics, &rig(ROTATION, BASELINE));
        // The pose of the shifted matches is off by 2 mrad of pitch, and poses between the two crowds by 0.9 mrad.
        assert!(off.rotation < 3e-4, "{matches}: {off:?}");
        assert_eq!(proposal.state, State::Locked, "{matches}");
        assert!(is_undoubted(proposal.reasons()), "{matches}");
        calibrator.apply().unwrap();
        take(&mut calibrator, &scene(ROTATION, 40)).unwrap();
        assert!(calibrator.verdict().may_arm, "{}", calibrator.verdict());
    }
}

#[test]
fn poses_between_two_crowds_are_not_fused() {
    let truth = rig(ROTATION, BASELINE);
    for (shifted, least) in [(100, 95), (112, 85), (122, 40)] {
        let (mut of_scene, mut between) = (0, 0);
        for seed in 0..100 {
            let mut calibrator = robust::<f32>();
            fill(&mut calibrator, &fence(shifted, 3.0, seed));
            let outcome = calibrator.solve_pair();
            let Some(pair) = outcome.pair.filter(|_| outcome.fused.is_ok()) else { continue };
            // The noise of a coordinate is 0.29 px. Midway between the crowds the row offsets are 1.5 px, which looks
            // like a noise of 1 px.
            between += u32::from(pair.noise_px > 0.7);
            of_scene += u32::from(Deviation::between(&pair.extrinsics, &truth).rotation < 1.2e-3);
        }
        assert!(between <= 5 && of_scene >= least, "{shifted}: {between} {of_scene}");
    }
}

#[test]
fn a_second_crowd_after_many_good_pairs_is_doubted_within_35_pairs() {
    let mut calibrator = robust::<f32>();
    for seed in 0..60 {
        take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
    }
    let doubted = (0..40).position(|seed| {
        let _ = take(&mut calibrator, &fence(118, 3.0, 100 + seed));
        calibrator.proposal().unwrap().reasons().contains(Reason::SecondMode)
    });
    assert!(doubted.is_some_and(|pairs| (2..35).contains(&pairs)), "{doubted:?}");
}

#[test]
fn a_second_crowd_as_large_is_doubted_until_it_is_gone() {
    let mut calibrator = robust::<f32>();
    let before = calibrator.in_use().extrinsics;
    for seed in 0..12 {
        // Some of these pairs cannot be solved.
        let _ = take(&mut calibrator, &fence(122, 3.0, seed));
        assert!(calibrator.apply().is_err(), "{seed}");
    }
    assert_eq!(calibrator.in_use().extrinsics, before);
    let proposal = calibrator.proposal().unwrap();
    assert!(proposal.reasons().contains(Reason::SecondMode));
    let verdict = calibrator.verdict();
    assert!(verdict.reasons.contains(Reason::SecondMode) && !verdict.may_arm, "{verdict}");
    if proposal.state == State::Locked {
        assert_eq!(calibrator.apply(), Err(ApplyError::Doubtful));
    }
    // The record keeps the evidence of the second crowd over a loss of power.
    let record = calibrator.snapshot();
    let mut calibrator = robust::<f32>();
    calibrator.restore(&record).unwrap();
    assert!(calibrator.proposal().unwrap().reasons().contains(Reason::SecondMode));
    for seed in 20..40 {
        let _ = take(&mut calibrator, &scene(ROTATION, seed));
    }
    calibrator.apply().unwrap();
    let off = Deviation::between(&calibrator.in_use().extrinsics, &rig(ROTATION, BASELINE));
    assert!(off.rotation < 2e-4, "{off:?}");
    take(&mut calibrator, &scene(ROTATION, 40)).unwrap();
    let verdict = calibrator.verdict();
    assert_eq!((verdict.may_arm, verdict.reasons.bits()), (true, Reason::Yaw.code()), "{verdict}");
}
