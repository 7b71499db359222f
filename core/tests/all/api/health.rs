//! Health: the report to the user before the vehicle moves.

use crate::api::disturbed::garbage;
use crate::api::presets::{calibrated, robust};
use crate::api::scene::{correspondences, fill, rig, take};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::nalgebra::Matrix5;
use stereo_selfcal::outcome::{DEPTHS_M, Direction};
use stereo_selfcal::{
    Band, Calibrator, Correspondence, NoHealth, Reason, Rejection, Scalar, State,
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
fn health_needs_an_estimate_and_matches_that_fit_it() {
    assert_eq!(after(0).health(), Err(NoHealth::NoEstimate(None)));
    let mut calibrator = after(5);
    assert!(calibrator.health().is_ok());
    calibrator.discard_pair();
    assert_eq!(calibrator.health(), Err(NoHealth::NoMatch(None)));
}

#[test]
fn the_band_rates_the_extrinsics_in_use() {
    let mut calibrator = after(6);
    assert_eq!(calibrator.health().unwrap().band, Band::Recalibrate);
    calibrator.apply().unwrap();
    let health = calibrator.health().unwrap();
    assert_eq!((health.band, health.in_use_px), (Band::Good, health.proposed_px));

    // The pitch of the factory extrinsics is off by 0.02 degrees: half a pixel.
    let [x, y, z] = ROTATION;
    let mut calibrator = calibrated(rig([x + 0.02, y, z], BASELINE));
    for seed in 0..6 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    let health = calibrator.health().unwrap();
    assert_eq!(health.band, Band::Improvable, "{health:?}");
    assert!(health.in_use_px < 1.0 && health.proposed_px < 0.9 * health.in_use_px);
}

#[test]
fn health_says_why_a_rig_may_not_arm() {
    let mut calibrator = after(2);
    let health = calibrator.health().unwrap();
    assert!(health.reasons.contains(Reason::NotLocked) && !health.may_arm());
    for seed in 2..6 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    let health = calibrator.health().unwrap();
    let forbids: Vec<_> = health.reasons.iter().take(1).collect();
    assert_eq!((forbids, health.may_arm()), (vec![Reason::Misaligned], false));
    calibrator.apply().unwrap();
    assert!(calibrator.health().unwrap().may_arm());

    // The first pair after a knock forbids arming.
    let [x, y, z] = ROTATION;
    let knocked = rig([x + 0.3, y, z], BASELINE);
    take(&mut calibrator, &correspondences(&knocked, 250, 0.5, 10)).unwrap();
    let health = calibrator.health();
    assert!(
        health.ok().is_none_or(|health| health.reasons.contains(Reason::NotLocked)),
        "{health:?}"
    );
    fill(&mut calibrator, &scene(11));
    let health = calibrator.health().unwrap();
    assert!(health.state == State::Suspect && health.reasons.contains(Reason::NotLocked));
    assert!(!health.may_arm());
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
        let health = calibrator.health().unwrap();
        assert_eq!((health.state, health.may_arm()), (State::Locked, arms), "{health:?}");
        assert_eq!(health.reasons.contains(Reason::Misaligned), !arms);
        assert!(health.proposed_px > 2.0 && health.in_use_px > 2.0);
        // At most a few matches are left out as outliers.
        assert!(health.fit_proposed > 245, "{health:?}");
        let off = if arms { 0.0..1.0 } else { 1.5..3.5 };
        assert!(off.contains(&health.off_px), "{health:?}");
    }
}

#[test]
fn coverage_is_the_share_of_the_image_with_matches_that_fit() {
    let mut calibrator = after(6);
    assert!(calibrator.health().unwrap().coverage > 0.9);
    let left: Vec<_> = scene(7).into_iter().filter(|c| c.left[0] < 480.0).collect();
    fill(&mut calibrator, &left);
    let quarter = calibrator.health().unwrap().coverage;
    assert!(quarter > 0.15 && quarter <= 0.25, "{quarter}");
    let one: Vec<_> = scene(7).into_iter().take(1).collect();
    fill(&mut calibrator, &one);
    assert_eq!(calibrator.health().unwrap().coverage, 1.0 / 48.0);
    // Outliers elsewhere do not count for coverage.
    let wrong = |c: &Correspondence<f32>| (c.left[1] - c.right[1]).abs() > 100.0;
    let elsewhere = garbage(250, 8).into_iter().filter(|c| wrong(c));
    fill(&mut calibrator, &one.into_iter().chain(elsewhere).collect::<Vec<_>>());
    assert_eq!(calibrator.health().unwrap().coverage, 1.0 / 48.0);
}

#[test]
fn counts_and_rms_are_over_the_matches_that_fit_the_estimate() {
    let mut calibrator = after(6);
    let mut matches = scene(7);
    for c in matches.iter_mut().take(50) {
        c.right[1] = if c.right[1] > 600.0 { c.right[1] - 50.0 } else { c.right[1] + 50.0 };
    }
    fill(&mut calibrator, &matches);
    let health = calibrator.health().unwrap();
    assert_eq!([health.fit_in_use, health.fit_proposed], [0, 200]);
    // Uniform noise of +-0.5 px on two rows.
    assert!((health.proposed_px / (0.5 * (2.0_f32 / 3.0).sqrt()) - 1.0).abs() < 0.2);
    assert!(health.in_use_px > 10.0, "{health:?}");
}

#[test]
fn the_error_of_depth_is_yaw_over_the_baseline_times_the_square_of_distance() {
    let mut calibrator = after(6);
    let health = calibrator.health().unwrap();
    let proposal = calibrator.proposal().unwrap();
    let [estimate, in_use] =
        [&proposal.extrinsics, &calibrator.in_use().extrinsics].map(RectifyingRotations::from);
    let off = estimate.unknowns_to(&in_use).y;
    let own = proposal.covariance_lens.unwrap().m22.sqrt();
    assert!((health.yaw / off.hypot(own) - 1.0).abs() < 1e-6);
    assert!((off.abs() - 0.5_f32.to_radians()).abs() < 0.2_f32.to_radians(), "{off}");
    for (error, z) in health.depth_errors(0.12).unwrap().into_iter().zip(DEPTHS_M) {
        let z = f32::lit(z);
        assert!((error / (z * z * health.yaw / 0.12) - 1.0).abs() < 1e-6, "{z} {error}");
    }
    calibrator.apply().unwrap();
    assert_eq!(calibrator.health().unwrap().yaw, own);
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
    let (direction, sd) = proposal.weakest().unwrap();
    // Yaw moves rows by the product of column and row, and the forward baseline by the product of disparity and row.
    // Both products are small everywhere in a narrow band.
    assert!(matches!(direction, Direction::Yaw | Direction::BaselineForward));
    let largest = |covariance: Option<Matrix5<f32>>| {
        covariance.unwrap().map(f64::from).symmetric_eigen().eigenvalues.max().sqrt()
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
fn health_says_why_the_last_pair_was_not_fused() {
    let mut calibrator = after(6);
    let rejection = |calibrator: &Calibrator<f32, 256>| calibrator.health().unwrap().rejection;
    assert_eq!(rejection(&calibrator), None);

    fill(&mut calibrator, &scene(10)[..11]);
    let few = Rejection::TooFew { usable: 11, needed: 12 };
    assert_eq!(calibrator.solve_pair().fused, Err(few));
    assert_eq!(rejection(&calibrator), Some(few));

    take(&mut calibrator, &scene(11)).unwrap();
    assert_eq!(rejection(&calibrator), None);

    let unsolved = take(&mut calibrator, &garbage(250, 12)).unwrap_err();
    fill(&mut calibrator, &scene(13));
    assert_eq!(rejection(&calibrator), Some(unsolved));
    take(&mut calibrator, &scene(14)).unwrap();
    assert_eq!(rejection(&calibrator), None);
}

#[test]
fn reasons_name_what_speaks_against_a_calibration_also_where_it_may_arm() {
    let of = |calibrator: &Calibrator<f32, 256>| calibrator.health().unwrap().reasons;
    let mut calibrator = after(2);
    let begun = of(&calibrator);
    assert_eq!(
        begun.iter().collect::<Vec<_>>(),
        [Reason::NotLocked, Reason::Misaligned, Reason::Yaw]
    );
    let named = "estimate not locked, in use off by 1 px or more, yaw not confirmed";
    assert_eq!(begun.to_string(), named);
    for seed in 2..6 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    assert_eq!(of(&calibrator).iter().collect::<Vec<_>>(), [Reason::Misaligned, Reason::Yaw]);
    calibrator.apply().unwrap();
    // The factory calibration is a guess, so the yaw is not confirmed.
    assert_eq!(of(&calibrator).iter().collect::<Vec<_>>(), [Reason::Yaw]);

    take(&mut calibrator, &scene(5)).unwrap();
    let health = calibrator.health().unwrap();
    assert!(health.may_arm());
    assert_eq!(health.reasons.iter().collect::<Vec<_>>(), [Reason::Repeated, Reason::Yaw]);
    assert!(health.to_string().contains("against it: repeated scene"), "{health}");
    take(&mut calibrator, &scene(6)).unwrap();
    assert_eq!(of(&calibrator).iter().collect::<Vec<_>>(), [Reason::Yaw]);
}

#[test]
fn the_bit_of_each_reason_is_its_own() {
    let all = Reason::ALL.iter().map(Reason::code);
    assert_eq!(all.clone().fold(0, |bits, code| bits | code), all.sum::<u16>());
    assert!(Reason::ALL.iter().all(|reason| reason.code().is_power_of_two()));
}
