//! Ranges and motions are witnesses: they separate the yaw of the mount, which depth needs, from the apparent yaw of
//! the lens. The details count and name witnesses that contradict the yaw.

use crate::api::depth::{
    Knock, NONE, Tested, calibrated, knocked, made, off, reading, run, warped, with_baseline,
};
use crate::api::scene::{fill, take};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::batch::RayPair;
use stereo_selfcal::depth::{MotionError, Range, RangeError, RangeReading, Witnessed};
use stereo_selfcal::geometry::{UndistortError, so3};
use stereo_selfcal::nalgebra::Vector3;
use stereo_selfcal::{Config, ConfigError, Extrinsics, Reason, Scalar};

#[test]
fn five_ranges_tell_the_yaw_of_the_mount_after_a_knock_before_the_first_pair() {
    for (knock, a) in [(1.0, 0.009), (-1.0, 0.009), (0.0, 0.009), (0.3, -0.005)] {
        let mut calibrator = with_baseline();
        let rig = [0.0, knock, 0.0];
        run(&mut calibrator, rig, a, 0..8);
        let pair = warped(rig, a, 8);
        take(&mut calibrator, &pair).unwrap();
        let mut taken = 0;
        for c in pair.iter().step_by(9).take(7) {
            taken += u32::from(calibrator.push_range(&reading(rig, c, 1.0)).is_ok());
        }
        assert!(taken >= 5, "{knock} {a}: {taken}");
        calibrator.apply().unwrap();
        let details = calibrator.details().unwrap();
        let yaw = off(&calibrator, rig).y;
        assert!(yaw.abs() < 3e-4, "{knock} {a}: {yaw}");
        assert!(
            yaw.abs() < 2.5 * details.yaw && details.yaw < 1e-3,
            "{knock} {a}: {yaw} {details}"
        );
        assert!(!calibrator.proposal().unwrap().reasons().contains(Reason::Yaw), "{details}");
        // The lens is known now, so a further knock is followed.
        let again = [0.0, knock - 0.7, 0.0];
        run(&mut calibrator, again, a, 20..34);
        assert!(off(&calibrator, again).y.abs() < 5e-4, "{knock} {a}");
    }
}

#[test]
fn an_impossible_reading_is_refused_and_a_single_contradiction_moves_nothing() {
    let mut calibrator = with_baseline();
    run(&mut calibrator, NONE, 0.002, 0..8);
    let pair = warped(NONE, 0.002, 8);
    take(&mut calibrator, &pair).unwrap();
    let before = calibrator.snapshot();
    let good = reading(NONE, &pair[0], 1.0);
    let with = |range, sd_m| RangeReading { range, sd_m, ..good };
    for bad in [
        with(Range::AlongAxis(f32::NAN), 0.1),
        with(Range::AlongRay(-3.0), 0.1),
        with(Range::AlongRay(f32::INFINITY), 0.1),
        with(good.range, f32::NAN),
        with(good.range, 0.0),
    ] {
        assert_eq!(calibrator.push_range(&bad), Err(RangeError::Reading), "{bad:?}");
    }
    let outside = RangeReading { pixel: [-5.0, 3.0], ..good };
    let error = RangeError::Pixel(UndistortError::OutsideImage);
    assert_eq!(calibrator.push_range(&outside), Err(error));
    // Readings of another point: of a window pane in front of the match, or of something behind the match.
    for factor in [0.1, 0.5, 10.0] {
        let near = pair.iter().find(|c| c.left[0] - c.right[0] > 60.0).unwrap();
        let wrong = reading(NONE, near, factor);
        assert_eq!(calibrator.push_range(&wrong), Err(RangeError::Contradicts), "{factor}");
    }
    assert_eq!(calibrator.snapshot(), before);

    let mut none = calibrated(Config::robust());
    assert_eq!(none.push_range(&good), Err(RangeError::NoBaseline));
    fill(&mut none, &pair);
    let mut early = with_baseline();
    assert_eq!(early.push_range(&good), Err(RangeError::NotLocked));
    for metres in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(made().with_baseline_m(metres), Err(ConfigError::BaselineLength));
    }
}

#[test]
fn a_reading_with_its_own_match_needs_no_match_of_the_pair() {
    let mut calibrator = with_baseline();
    let rig = [0.0, 1.0, 0.0];
    run(&mut calibrator, rig, 0.009, 0..8);
    let pair = warped(rig, 0.009, 8);
    // The pair is fused without the points of the readings and without their neighbours.
    let (read, fused): (Vec<_>, Vec<_>) = pair.iter().partition(|c| {
        pair[..60]
            .iter()
            .step_by(9)
            .any(|of| (of.left[0] - c.left[0]).hypot(of.left[1] - c.left[1]) < 4.0)
    });
    take(&mut calibrator, &fused).unwrap();
    for c in &read[..6] {
        let alone = reading(rig, c, 1.0);
        assert_eq!(calibrator.push_range(&alone), Err(RangeError::NoMatch));
        let own = |right| RangeReading { right: Some(right), ..alone };
        let [u, v] = c.right;
        assert_eq!(calibrator.push_range(&own([u, v + 9.0])), Err(RangeError::NoMatch));
        let outside = RangeError::Pixel(UndistortError::OutsideImage);
        assert_eq!(calibrator.push_range(&own([-5.0, v])), Err(outside));
        assert!(calibrator.push_range(&own([u, v])).is_ok());
    }
    calibrator.apply().unwrap();
    let yaw = off(&calibrator, rig).y;
    assert!(yaw.abs() < 5e-4, "{yaw}");
}

#[test]
fn readings_that_contradict_wait_until_they_outvote_the_earlier_ones() {
    let mut calibrator = with_baseline();
    // No witness has confirmed the yaw: a part of the yaw of the rows may belong to the mount.
    run(&mut calibrator, NONE, 0.009, 0..8);
    let pair = warped(NONE, 0.009, 8);
    take(&mut calibrator, &pair).unwrap();
    let far = pair.iter().find(|c| c.left[0] - c.right[0] < 30.0).unwrap();
    let before = calibrator.proposal().unwrap().extrinsics;
    assert_eq!(calibrator.push_range(&reading(NONE, far, 1.4)), Ok(Witnessed::Waiting));
    assert_eq!(calibrator.proposal().unwrap().extrinsics, before);
    assert_eq!(calibrator.push_range(&reading(NONE, far, 1.0)), Ok(Witnessed::Taken));
    // Two wrong readings outvote the right one. The right readings that follow are not refused: the fourth of them
    // outvotes the wrong ones.
    let taken = [1.4, 1.4, 1.4, 1.4, 1.0, 1.0, 1.0, 1.0].map(|factor| {
        calibrator.push_range(&reading(NONE, far, factor)).unwrap() == Witnessed::Taken
    });
    assert_eq!(taken, [false, true, true, true, false, false, false, true]);
    assert!(off(&calibrator, NONE).y.abs() < 1e-3);
}

/// Matches of 120 points in two pairs of a rig that moves between the pairs. Rows are off by `a x y`.
///
/// * `translation`: motion of the points in the left camera frame, baselines.
/// * `turn`: turn of the points about the y axis of the left camera, rad.
pub(crate) fn tracked(
    of: Knock,
    a: f64,
    translation: [f64; 3],
    turn: f64,
) -> Vec<[RayPair<f32>; 2]> {
    let rig: Extrinsics<f64> = knocked(of);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let turned = so3::exp(&Vector3::new(0.0, turn, 0.0)).unwrap();
    let mut found = Vec::new();
    while found.len() < 120 {
        let depth = 10.0 * 16.0_f64.powf(rng.random());
        let [x, y] = [rng.random_range(-0.6..0.6), rng.random_range(-0.4..0.4)];
        let one = Vector3::new(x, y, 1.0) * depth;
        let two = turned * one + Vector3::from(translation);
        let mut noise = || (rng.random::<f64>() * 2.0 - 1.0) * 0.5 / 1400.0;
        let mut seen = |p: &Vector3<f64>| {
            let right = rig.rotation() * p + rig.translation().into_inner();
            let [x, y] = [right.x / right.z, right.y / right.z];
            let left = [p.x / p.z + noise(), p.y / p.z + noise()];
            let right = [x + noise(), y + a * x * y + noise()];
            RayPair::try_new(left.map(f32::lit), right.map(f32::lit))
        };
        if two.z > 1.0
            && let Some(both) = seen(&one).zip(seen(&two))
        {
            found.push([both.0, both.1]);
        }
    }
    // The second match of every eighth point belongs to another point.
    for i in (0..found.len() - 1).step_by(8) {
        found[i][1] = found[i + 1][1];
    }
    found
}

#[test]
fn motion_tells_the_yaw_of_the_mount_and_rest_says_nothing() {
    let forward = [0.5, 0.1, -4.0];
    for (knock, a) in [(0.0, 0.009), (1.0, 0.009), (-1.0, 0.009), (0.3, -0.005)] {
        let rig = [0.0, knock, 0.0];
        let mut calibrator = calibrated(Config::robust());
        run(&mut calibrator, rig, a, 0..10);
        let a = f64::from(a);
        // A rig at rest, and a rig that only turns.
        for turn in [0.0, 0.05] {
            let still = tracked(rig, a, [0.0; 3], turn);
            assert_eq!(calibrator.push_motion(&still), Err(MotionError::NoMotion), "{turn}");
        }
        let few = &tracked(rig, a, forward, 0.0)[..5];
        assert_eq!(calibrator.push_motion(few), Err(MotionError::TooFew));
        for turn in [0.0, 0.03, -0.03] {
            let pushed = calibrator.push_motion(&tracked(rig, a, forward, turn));
            assert!(pushed.is_ok(), "{knock} {a} {turn}: {pushed:?}");
        }
        calibrator.apply().unwrap();
        let (details, yaw) = (calibrator.details().unwrap(), off(&calibrator, rig).y);
        assert!(yaw.abs() < 4e-4, "{knock} {a}: {yaw}");
        assert!(
            yaw.abs() < 2.5 * details.yaw && details.yaw < 1e-3,
            "{knock} {a}: {yaw} {details}"
        );
        assert!(!calibrator.proposal().unwrap().reasons().contains(Reason::Yaw), "{details}");
    }
    let nothing = calibrated(Config::robust()).push_motion(&[]);
    assert_eq!(nothing, Err(MotionError::NotLocked));
}

/// A random number: of any bits, within +-2000, or within 0 to 1.
fn any_number(rng: &mut ChaCha8Rng) -> f32 {
    match rng.random_range(0..3_u8) {
        0 => f32::from_bits(rng.random()),
        1 => rng.random_range(-2e3..2e3),
        _ => rng.random_range(0.0..1.0),
    }
}

/// The whole state as text, without the counts of contradictions.
fn traces(calibrator: &Tested) -> String {
    let all = format!("{calibrator:?}");
    let (before, rest) = all.split_once("contradicting: [").unwrap();
    let (_, after) = rest.split_once(']').unwrap();
    [before, after].concat()
}

#[test]
fn witnesses_of_any_bits_leave_a_finite_estimate_or_no_trace() {
    let mut rng = ChaCha8Rng::seed_from_u64(38);
    let mut calibrator = with_baseline();
    run(&mut calibrator, NONE, 0.005, 0..8);
    take(&mut calibrator, &warped(NONE, 0.005, 8)).unwrap();
    let mut refused = 0;
    for _ in 0..3000 {
        let before = traces(&calibrator);
        let mut any = || any_number(&mut rng);
        let reading = RangeReading {
            pixel: [any(), any()],
            right: (any() > 0.5).then(|| [any(), any()]),
            range: if any() > 0.5 { Range::AlongAxis(any()) } else { Range::AlongRay(any()) },
            sd_m: any(),
        };
        if calibrator.push_range(&reading).is_err() {
            refused += 1;
            assert_eq!(traces(&calibrator), before, "{reading:?}");
        }
        let proposal = calibrator.proposal().unwrap();
        assert!(proposal.sd_lens.rotation.is_finite() && proposal.lens_yaw.sd.is_finite());
    }
    assert!(refused > 2000, "{refused}");
}

#[test]
fn tracks_of_random_rays_show_no_motion_and_leave_no_trace() {
    let mut rng = ChaCha8Rng::seed_from_u64(39);
    let mut calibrator = calibrated(Config::robust());
    run(&mut calibrator, NONE, 0.005, 0..8);
    for _ in 0..60 {
        let any = |_| {
            let mut pair = || {
                let of = |rng: &mut ChaCha8Rng| [any_number(rng), any_number(rng)];
                let small = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)];
                RayPair::try_new(of(&mut rng), of(&mut rng))
                    .or_else(|| RayPair::try_new(small, small))
            };
            [pair().unwrap(), pair().unwrap()]
        };
        let tracked: Vec<_> = (0..40).map(any).collect();
        let before = format!("{calibrator:?}");
        assert_eq!(calibrator.push_motion(&tracked), Err(MotionError::NoMotion));
        assert_eq!(format!("{calibrator:?}"), before);
    }
}

/// Counts of contradicting ranges and motions; checks that the text of the details names them if there are any.
fn counts(calibrator: &Tested) -> [u16; 2] {
    let details = calibrator.details().unwrap();
    let counts = [details.contradicting_ranges, details.contradicting_motions];
    let [ranges, motions] = counts;
    let named = format!("contradicted by {ranges} ranges and {motions} motions");
    assert_eq!(details.to_string().contains(&named), counts != [0; 2], "{details}");
    counts
}

#[test]
fn ranges_and_motions_that_contradict_are_counted_until_a_reset() {
    let mut calibrator = with_baseline();
    run(&mut calibrator, NONE, 0.002, 0..8);
    let pair = warped(NONE, 0.002, 8);
    take(&mut calibrator, &pair).unwrap();
    let near = pair.iter().find(|c| c.left[0] - c.right[0] > 60.0).unwrap();
    let right = reading(NONE, near, 1.0);
    // A reading that is not valid does not count, and a reading that agrees with the yaw does not count.
    let bad = RangeReading { sd_m: f32::NAN, ..right };
    assert_eq!(calibrator.push_range(&bad), Err(RangeError::Reading));
    assert_eq!(calibrator.push_range(&right), Ok(Witnessed::Taken));
    assert_eq!(counts(&calibrator), [0, 0]);
    for (factor, count) in [(0.1, 1), (0.5, 2), (10.0, 3)] {
        let wrong = reading(NONE, near, factor);
        assert_eq!(calibrator.push_range(&wrong), Err(RangeError::Contradicts), "{factor}");
        assert_eq!(counts(&calibrator), [count, 0]);
    }
    // A reading that waits also counts.
    let slightly = [0.97, 0.95, 0.93, 0.9].map(|factor| reading(NONE, near, factor));
    let mut waits = slightly.iter().map(|of| calibrator.push_range(of));
    assert!(waits.any(|of| of == Ok(Witnessed::Waiting)));
    assert_eq!(counts(&calibrator), [4, 0]);
    // Tracks of a rig whose yaw differs by two degrees.
    let other = tracked([0.0, 2.0, 0.0], 0.0, [0.5, 0.1, -4.0], 0.0);
    assert_eq!(calibrator.push_motion(&other), Err(MotionError::Contradicts));
    assert_eq!(counts(&calibrator), [4, 1]);
    calibrator.reset();
    run(&mut calibrator, NONE, 0.002, 0..8);
    assert_eq!(counts(&calibrator), [0, 0]);
}
