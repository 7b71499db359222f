//! The verdict after a pair, and the details of the last one.

use crate::api::disturbed::garbage;
use crate::api::presets::{calibrated, robust};
use crate::api::scene::{cameras, correspondences, fill, rig, take};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::nalgebra::Matrix5;
use stereo_selfcal::outcome::{DEPTHS_M, Direction};
use stereo_selfcal::{
    Calibrator, Config, Correspondence, FactoryCalibration, Reason, Scalar, State,
};

const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
const BASELINE: [f64; 2] = [0.5, -0.4];

fn scene(seed: u64) -> Vec<Correspondence<f32>> {
    correspondences(&rig(ROTATION, BASELINE), 250, 0.5, seed)
}

/// The calibrator after `pairs` pairs of the rig; the last pair is still in the batch.
fn after(pairs: u64) -> Calibrator<f32, 256> {
    let mut calibrator = robust();
    for seed in 0..pairs {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    calibrator
}

#[test]
fn a_verdict_before_the_first_pair_permits_nothing() {
    let calibrator = after(0);
    let verdict = calibrator.verdict();
    assert!(!(verdict.may_arm || verdict.should_apply || verdict.rows_ok || verdict.depth_ok));
    assert_eq!([verdict.rows_px, verdict.depth_px], [f32::INFINITY; 2]);
    assert_eq!(calibrator.details(), None);
}

#[test]
fn a_verdict_stays_until_the_next_pair_has_ended() {
    let mut calibrator = after(6);
    let before = *calibrator.verdict();
    fill(&mut calibrator, &scene(7)[..40]);
    assert_eq!(*calibrator.verdict(), before);
    calibrator.discard_pair();
    assert_eq!(*calibrator.verdict(), before);
    assert_eq!(calibrator.details(), None);
}

#[test]
fn applying_is_worthwhile_where_the_estimate_is_clearly_better() {
    let mut calibrator = after(6);
    assert!(calibrator.verdict().should_apply && !calibrator.verdict().rows_ok);
    calibrator.apply().unwrap();
    take(&mut calibrator, &scene(6)).unwrap();
    let verdict = calibrator.verdict();
    assert!(verdict.rows_ok && !verdict.should_apply && verdict.may_arm, "{verdict}");

    // The pitch of the factory extrinsics is off by 0.02 degrees: half a pixel.
    let [x, y, z] = ROTATION;
    let mut calibrator = calibrated(rig([x + 0.02, y, z], BASELINE));
    for seed in 0..6 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    let verdict = calibrator.verdict();
    assert!(verdict.should_apply && verdict.may_arm, "{verdict}");
    assert!((0.4..0.6).contains(&verdict.rows_px), "{verdict}");
}

#[test]
fn a_calibrated_rig_arms_with_the_lock_and_a_corrected_one_with_the_next_pair() {
    let mut calibrated = calibrated(rig(ROTATION, BASELINE));
    let mut guessed = robust();
    for seed in 0..5 {
        take(&mut calibrated, &scene(seed)).unwrap();
        take(&mut guessed, &scene(seed)).unwrap();
        assert_eq!(calibrated.verdict().may_arm, seed >= 3, "{seed}");
        assert_eq!(guessed.verdict().may_arm, seed >= 4, "{seed}");
        let _ = guessed.apply();
    }
}

#[test]
fn one_disagreeing_pair_keeps_a_rig_armed_and_the_second_disarms_it() {
    let [x, y, z] = ROTATION;
    // A knock of 0.1 degrees about x moves rows by 2.4 px, one of 1 degree by 24 px.
    for knock in [0.1, 0.3, 1.0] {
        let mut calibrator = calibrated(rig(ROTATION, BASELINE));
        for seed in 0..8 {
            take(&mut calibrator, &scene(seed)).unwrap();
            let _ = calibrator.apply();
        }
        let knocked = rig([x + knock, y, z], BASELINE);
        let armed: Vec<_> = (0..6)
            .map(|seed| {
                let _ = take(&mut calibrator, &correspondences(&knocked, 250, 0.5, 20 + seed));
                let armed = calibrator.verdict().may_arm;
                let _ = calibrator.apply();
                armed
            })
            .collect();
        assert_eq!(armed[..2], [true, false], "{knock}: {armed:?}");
        assert!(armed[4] && armed[5], "{knock}: {armed:?}");
    }
    let mut calibrator = calibrated(rig(ROTATION, BASELINE));
    for seed in 0..6 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    for seed in 0..12 {
        let _ = take(&mut calibrator, &garbage(250, seed));
        // Pairs without a solution are no evidence; after ten of them, the last evidence is too old.
        assert_eq!(calibrator.verdict().may_arm, seed < 9, "{seed} {}", calibrator.verdict());
    }
    assert!(calibrator.verdict().reasons.contains(Reason::Evidence));
}

#[test]
fn noise_alone_does_not_disarm_but_a_row_offset_does() {
    let [x, y, z] = ROTATION;
    // 0.1 degrees of pitch: 2.4 px.
    for (factory, arms) in [(x, true), (x + 0.1, false)] {
        let mut calibrator = calibrated(rig([factory, y, z], BASELINE));
        for seed in 0..6 {
            // Uniform noise of +-3.5 px has a standard deviation of 2 px.
            let matches = correspondences(&rig(ROTATION, BASELINE), 250, 3.5, seed);
            take(&mut calibrator, &matches).unwrap();
        }
        let (details, verdict) = (calibrator.details().unwrap(), calibrator.verdict());
        assert_eq!((verdict.state, verdict.may_arm), (State::Locked, arms), "{verdict}");
        assert_eq!(verdict.reasons.contains(Reason::Rows), !arms);
        assert!(details.proposed_px > 2.0 && details.in_use_px > 2.0);
        // At most a few matches are left out as outliers.
        assert!(details.fit_proposed > 245, "{details}");
        let off = if arms { 0.0..1.0 } else { 1.5..3.5 };
        assert!(off.contains(&verdict.rows_px) && off.contains(&details.off_px), "{verdict}");
    }
}

#[test]
fn depth_forbids_arming_until_a_calibration_confirms_the_yaw() {
    let guess = FactoryCalibration::guess(cameras());
    let mut calibrator = Calibrator::<f32, 256>::new(Config::robust(), &guess);
    for seed in 0..12 {
        take(&mut calibrator, &scene(seed)).unwrap();
        let _ = calibrator.apply();
    }
    let verdict = calibrator.verdict();
    assert!(verdict.rows_ok && !verdict.depth_ok && !verdict.may_arm, "{verdict}");
    assert!(verdict.reasons.contains(Reason::Depth) && verdict.reasons.contains(Reason::Yaw));
    // The deviation of the lens's yaw, 4.6 mrad, at 1400 px.
    assert!((5.0..8.0).contains(&verdict.depth_px), "{verdict}");
}

#[test]
fn coverage_is_the_share_of_the_image_with_matches_that_fit() {
    let mut calibrator = calibrated(rig(ROTATION, BASELINE));
    let mut covered = |matches: &[Correspondence<f32>]| {
        let _ = take(&mut calibrator, matches);
        let verdict = calibrator.verdict();
        (verdict.image_coverage, verdict.reasons.contains(Reason::Coverage), verdict.coverage)
    };
    (0..6).for_each(|seed| assert!(covered(&scene(seed)).0 > 0.8));
    let within = |width: f32| {
        let all = correspondences::<f32>(&rig(ROTATION, BASELINE), 4000, 0.5, 7);
        all.into_iter().filter(|c| c.left[0] < width).take(200).collect::<Vec<_>>()
    };
    let (quarter, is_reason, fits) = covered(&within(480.0));
    assert!(quarter > 0.15 && quarter <= 0.25 && !is_reason && fits > 0.95, "{quarter}");
    let (eighth, is_reason, _) = covered(&within(240.0));
    assert!(eighth > 0.1 && eighth <= 0.125 && is_reason, "{eighth}");
    // Wrong matches elsewhere do not count.
    let mut matches = within(240.0);
    let wrong = |c: &Correspondence<f32>| (c.left[1] - c.right[1]).abs() > 100.0;
    matches.extend(garbage(100, 8).into_iter().filter(wrong));
    assert_eq!(covered(&matches).0, eighth);
}

#[test]
fn counts_and_rms_are_over_the_matches_that_fit_the_estimate() {
    let mut calibrator = after(6);
    let mut matches = scene(7);
    for c in matches.iter_mut().take(50) {
        c.right[1] = if c.right[1] > 600.0 { c.right[1] - 50.0 } else { c.right[1] + 50.0 };
    }
    fill(&mut calibrator, &matches);
    let details = calibrator.details().unwrap();
    assert_eq!([details.fit_in_use, details.fit_proposed], [0, 200]);
    // Uniform noise of +-0.5 px on two rows.
    assert!((details.proposed_px / (0.5 * (2.0_f32 / 3.0).sqrt()) - 1.0).abs() < 0.2);
    assert!(details.in_use_px > 10.0, "{details}");
}

#[test]
fn the_error_of_depth_is_yaw_over_the_baseline_times_the_square_of_distance() {
    let mut calibrator = after(6);
    let details = calibrator.details().unwrap();
    let proposal = calibrator.proposal().unwrap();
    let [estimate, in_use] =
        [&proposal.extrinsics, &calibrator.in_use().extrinsics].map(RectifyingRotations::from);
    let off = estimate.unknowns_to(&in_use).y;
    let own = proposal.covariance_lens.m22.sqrt();
    assert!((details.yaw / off.hypot(own) - 1.0).abs() < 1e-6);
    assert!((off.abs() - 0.5_f32.to_radians()).abs() < 0.2_f32.to_radians(), "{off}");
    for (error, z) in details.depth_errors(0.12).into_iter().zip(DEPTHS_M) {
        let z = f32::lit(z);
        assert!((error / (z * z * details.yaw / 0.12) - 1.0).abs() < 1e-6, "{z} {error}");
    }
    calibrator.apply().unwrap();
    assert_eq!(calibrator.details().unwrap().yaw, own);
}

#[test]
fn the_weakest_direction_is_the_largest_of_the_covariance_and_in_a_narrow_band_about_y() {
    let mut calibrator = robust::<f32>();
    let band = |seed| {
        let all = correspondences::<f32>(&rig(ROTATION, BASELINE), 3000, 0.5, seed);
        let middle = all.into_iter().filter(|c| (c.left[1] - 600.0).abs() < 60.0);
        middle.take(250).collect::<Vec<_>>()
    };
    for seed in 0..8 {
        take(&mut calibrator, &band(seed)).unwrap();
    }
    let proposal = calibrator.proposal().unwrap();
    let (direction, sd) = proposal.weakest();
    // Yaw moves rows by the product of column and row, and the forward baseline by the product of disparity and row.
    // Both products are small everywhere in a narrow band.
    assert!(matches!(direction, Direction::Yaw | Direction::BaselineForward));
    let largest = |covariance: Matrix5<f32>| {
        covariance.map(f64::from).symmetric_eigen().eigenvalues.max().sqrt()
    };
    let with_lens = largest(proposal.covariance_lens);
    assert!((f64::from(sd) / with_lens - 1.0).abs() < 0.01, "{sd} {with_lens}");
    // With matches over the whole image, the deviation of the weakest direction is less than half of this. The two
    // deviations do not include the lens.
    let whole = largest(after(8).proposal().unwrap().covariance);
    let sd = largest(proposal.covariance);
    assert!(whole < 0.5 * sd, "{whole} {sd}");
}

#[test]
fn reasons_name_what_speaks_against_a_calibration_also_where_it_may_arm() {
    let of =
        |calibrator: &Calibrator<f32, 256>| calibrator.verdict().reasons.iter().collect::<Vec<_>>();
    let mut calibrator = after(2);
    let begun = [Reason::NotLocked, Reason::Evidence, Reason::Rows, Reason::Coverage, Reason::Yaw];
    assert_eq!(of(&calibrator), begun);
    let named = "estimate not locked, in use not confirmed by the last pairs, rows in use off, ";
    assert!(calibrator.verdict().reasons.to_string().starts_with(named));
    for seed in 2..6 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    assert_eq!(of(&calibrator), begun[1..]);
    calibrator.apply().unwrap();
    take(&mut calibrator, &scene(6)).unwrap();
    // The factory calibration is a guess, so the yaw is not confirmed.
    assert_eq!(of(&calibrator), [Reason::Yaw]);

    take(&mut calibrator, &scene(6)).unwrap();
    let verdict = calibrator.verdict();
    assert!(verdict.may_arm);
    assert_eq!(of(&calibrator), [Reason::Repeated, Reason::Yaw]);
    assert!(verdict.to_string().contains("against it: repeated scene"), "{verdict}");
    take(&mut calibrator, &scene(7)).unwrap();
    assert_eq!(of(&calibrator), [Reason::Yaw]);
}

#[test]
fn the_bit_of_each_reason_is_its_own() {
    let all = Reason::ALL.iter().map(Reason::code);
    assert_eq!(all.clone().fold(0, |bits, code| bits | code), all.sum::<u16>());
    assert!(Reason::ALL.iter().all(|reason| reason.code().is_power_of_two()));
}
