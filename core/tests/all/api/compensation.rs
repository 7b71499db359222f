//! Compensation of wrong lens models.

use crate::api::depth::NONE;
use crate::api::lens::pair;
use crate::api::presets::{ROWS_ALONE, with};
use crate::api::scene::{FOCAL, cameras, rig, take};
use crate::api::witness::tracked;
use stereo_selfcal::batch::RayPair;
use stereo_selfcal::depth::{Range, RangeReading, Witnessed};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::geometry::{LensCorrection, RectifyingRotations};
use stereo_selfcal::nalgebra::Vector3;
use stereo_selfcal::{
    Calibration, Calibrator, Config, Extrinsics, FactoryCalibration, Fused, Lens, LensTracking,
    RestoreError, State,
};

type Tested = Calibrator<f32, 256>;

const COMPENSATE: Config = ROWS_ALONE.with_lens_tracking(LensTracking::Compensate);

fn truth() -> Extrinsics<f32> {
    rig([1.0, -0.5, 0.8], [0.5, -0.4])
}

/// Takes pairs of a wrong right lens, and applies after each; returns the pairs that corrected the lens.
fn drive(calibrator: &mut Tested, focal: f32, k1: f32, seeds: core::ops::Range<u64>) -> Vec<u64> {
    let corrects = |seed: &u64| {
        let fused = take(calibrator, &pair(focal, k1, *seed)).unwrap();
        if fused == Fused::LensCorrected {
            assert_eq!((calibrator.state(), calibrator.proposal()), (State::Acquiring, None));
            assert_eq!((calibrator.batch().offered(), calibrator.details()), (0, None));
        }
        let _ = calibrator.apply();
        fused == Fused::LensCorrected
    };
    seeds.filter(corrects).collect()
}

fn off(extrinsics: &Extrinsics<f32>) -> Deviation<f32> {
    Deviation::between(extrinsics, &truth())
}

#[test]
fn a_wrong_right_lens_is_corrected_and_handed_out_with_its_extrinsics() {
    let mut reporting: Tested = with(Config::robust());
    assert_eq!(drive(&mut reporting, 0.003, 0.002, 0..100), [0; 0]);
    let mut calibrator: Tested = with(COMPENSATE);
    assert!(!drive(&mut calibrator, 0.003, 0.002, 0..100).is_empty());

    let Calibration { cameras: corrected, extrinsics, .. } = calibrator.apply().unwrap();
    let [reported, proposal] = [&reporting, &calibrator].map(|c| c.proposal().unwrap());
    let (error, sd) = (off(&extrinsics), proposal.sd_lens);
    assert!(error.translation < 0.1 * off(&reported.extrinsics).translation, "{error:?}");
    assert!(error.translation < 3.0 * sd.translation && error.rotation < 3.0 * sd.rotation);
    assert!(sd.translation < 0.2 * reported.sd_lens.translation, "{sd:?}");

    let LensCorrection { focal, k1 } = proposal.correction;
    let found = proposal.lens.unwrap();
    assert_eq!((found.focal.value, found.k1.value), (focal, k1));
    assert!((focal - 0.003).abs() < 3.0 * found.focal.sd && found.focal.sd < 2e-4, "{found:?}");
    assert!((k1 - 0.002).abs() < 3.0 * found.k1.sd && found.k1.sd < 5e-4, "{found:?}");
    assert_eq!(corrected, cameras().corrected(&proposal.applicable_correction).unwrap());
    assert_eq!(corrected.left, cameras().left);
    let f = corrected.right.intrinsics().focal[0];
    assert!((f / 1.003 - 1400.0).abs() < 0.3, "{f} of {FOCAL}");
    assert!(matches!(corrected.right.lens(), Lens::RadialTangential(_)));
    let in_use = calibrator.in_use();
    assert_eq!((in_use.cameras, in_use.extrinsics), (corrected, extrinsics));

    take(&mut calibrator, &pair(0.003, 0.002, 200)).unwrap();
    let [good, poor] = [&calibrator, &reporting].map(|c| c.details().unwrap());
    assert!(calibrator.verdict().may_arm);
    assert!(good.in_use_px < 0.5 && good.in_use_px < poor.in_use_px, "{good} {poor}");
}

#[test]
fn a_right_lens_stays_as_given_and_every_bit_equals_report() {
    let [mut compensating, mut reporting] = [COMPENSATE, ROWS_ALONE].map(with);
    for calibrator in [&mut compensating, &mut reporting] {
        assert_eq!(drive(calibrator, 0.0, 0.0, 0..60), [0; 0]);
    }
    assert_eq!(compensating.proposal(), reporting.proposal());
    assert_eq!(compensating.in_use(), reporting.in_use());
}

#[test]
fn extrinsics_never_go_with_the_cameras_of_another_lens() {
    let mut calibrator: Tested = with(COMPENSATE);
    let corrected = drive(&mut calibrator, 0.003, 0.0, 0..60);
    let first = *corrected.first().unwrap();
    let mut calibrator: Tested = with(COMPENSATE);
    drive(&mut calibrator, 0.003, 0.0, 0..first + 1);
    // The estimate restarts. The calibration in use stays, with the cameras that belong to it.
    let before = calibrator.in_use();
    assert_eq!(before.cameras, cameras());
    assert!(off(&before.extrinsics).translation > 5e-3, "that of the given lens");
    let generation = calibrator.in_use().generation;
    for seed in first + 1..first + 5 {
        take(&mut calibrator, &pair(0.003, 0.0, seed)).unwrap();
        assert_eq!(calibrator.in_use(), before);
    }
    let after = calibrator.apply().unwrap();
    assert_eq!((calibrator.in_use(), calibrator.in_use().generation), (after, generation + 1));
    assert_ne!(after.cameras, cameras());
    assert!(off(&after.extrinsics).translation < 2e-3);
    let undone = Calibration { generation: generation + 2, ..before };
    assert_eq!(calibrator.undo(), Ok(undone));
    assert_eq!(
        (calibrator.in_use(), calibrator.in_use().generation),
        (Calibration { generation: generation + 2, ..before }, generation + 2)
    );
    calibrator.reset();
    assert_eq!(calibrator.in_use().cameras, cameras());
    assert_eq!(drive(&mut calibrator, 0.0, 0.0, 0..30), [0; 0], "rays use the given lens");
}

#[test]
fn a_changed_left_lens_is_covered_by_the_deviations() {
    // A shorter left focal length gives the same rows as a longer right one.
    let mut calibrator: Tested = with(COMPENSATE);
    for seed in 0..100 {
        let mut matches = pair(0.0, 0.0, seed);
        for c in &mut matches {
            for (x, centre) in c.left.iter_mut().zip([959.5, 599.5]) {
                *x = centre + (*x - centre) * (1.0 - 0.003);
            }
        }
        take(&mut calibrator, &matches).unwrap();
    }
    let proposal = calibrator.proposal().unwrap();
    assert!((proposal.correction.focal - 0.003).abs() < 2e-4, "{:?}", proposal.correction);
    let (error, sd) = (off(&proposal.extrinsics), proposal.sd_lens);
    assert!(
        error.translation < 3.0 * sd.translation && error.translation < 1.5e-3,
        "{error:?} {sd:?}"
    );
    assert!(error.rotation < 3.0 * sd.rotation, "{error:?} {sd:?}");
}

#[test]
fn a_record_resumes_the_corrected_lens() {
    let mut before = with(COMPENSATE);
    assert!(!drive(&mut before, 0.002, 0.0, 0..40).is_empty());
    let mut after = with(COMPENSATE);
    after.restore(&before.snapshot()).unwrap();
    let [one, other] = [&before, &after].map(Calibrator::in_use);
    assert!((one.cameras.right.mean_focal() / other.cameras.right.mean_focal() - 1.0).abs() < 1e-6);
    for seed in 40..60 {
        let matches = pair(0.002, 0.0, seed);
        let [_, _] = [&mut before, &mut after].map(|c| take(c, &matches).unwrap());
        // Each estimate restarts when its lens is corrected further.
        let [one, other] = [&before, &after].map(Calibrator::proposal);
        let Some((one, other)) = one.zip(other) else { continue };
        let apart = Deviation::between(&one.extrinsics, &other.extrinsics);
        assert!(apart.rotation < 0.2 * one.sd_lens.rotation, "{seed} {apart:?}");
        assert!(apart.translation < 0.2 * one.sd_lens.translation, "{seed} {apart:?}");
        assert!((one.correction.focal - other.correction.focal).abs() < 1e-4, "{seed}");
    }
    after.apply().unwrap();
    after.undo().unwrap();
}

#[test]
fn a_record_of_corrected_cameras_is_refused_where_the_configuration_only_reports() {
    let mut compensating = with(COMPENSATE);
    let corrected = *drive(&mut compensating, 0.003, 0.0, 0..60).first().unwrap();
    let refused = |from: &Tested| {
        let record = from.snapshot();
        let mut reporting: Tested = with(Config::robust());
        assert_eq!(reporting.restore(&record), Err(RestoreError::Config));
        assert_eq!(reporting.in_use(), with::<f32, 256>(Config::robust()).in_use());
        assert_eq!((reporting.state(), reporting.proposal()), (State::Acquiring, None));
        assert_eq!(drive(&mut reporting, 0.0, 0.0, 100..120), [0; 0]);
        assert_eq!(reporting.state(), State::Locked, "goes on with the given cameras");
    };
    assert_ne!(compensating.in_use().cameras, cameras());
    refused(&compensating);

    // The calibration in use belongs to the given cameras, but the rays belong to corrected ones.
    let mut compensating = with(COMPENSATE);
    drive(&mut compensating, 0.003, 0.0, 0..corrected + 1);
    assert_eq!(compensating.in_use().cameras, cameras());
    refused(&compensating);

    // The lens was not corrected.
    let mut compensating = with(COMPENSATE);
    drive(&mut compensating, 0.0, 0.0, 0..30);
    let mut reporting: Tested = with(Config::robust());
    assert_eq!(reporting.restore(&compensating.snapshot()), Ok(()));
}

/// Distance of the estimate from the factory extrinsics, rad: in `R` or in `t`, whichever is larger; 0 without an
/// estimate.
fn correction(calibrator: &Tested) -> f32 {
    let Some(proposal) = calibrator.proposal() else { return 0.0 };
    let Deviation { translation, rotation } =
        Deviation::between(&proposal.extrinsics, &rig([1.0, -0.5, 0.8], [0.0, 0.0]));
    translation.max(rotation)
}

/// A calibrator whose factory calibration differs from the true rig only in the baseline.
fn with_factory(config: Config) -> Tested {
    Tested::new(config, &FactoryCalibration::new(cameras(), rig([1.0, -0.5, 0.8], [0.0, 0.0])))
}

#[test]
fn a_compensated_lens_moves_no_estimate_beyond_the_correction_limit() {
    let mut free = with_factory(COMPENSATE);
    let first = *drive(&mut free, 0.003, 0.0, 0..60).first().unwrap();
    let mut free = with_factory(COMPENSATE);
    drive(&mut free, 0.003, 0.0, 0..first + 1);
    let corrections = (first + 1..first + 20).map(|seed| {
        drive(&mut free, 0.003, 0.0, seed..seed + 1);
        correction(&free)
    });
    let limit = corrections.fold(0.0, f32::max) * 0.999;
    let limited = COMPENSATE.with_max_correction_rad(limit).unwrap();
    let mut calibrator = with_factory(limited);
    for seed in 0..first + 40 {
        // At the limit some pairs are rejected.
        let _ = take(&mut calibrator, &pair(0.003, 0.0, seed));
        let _ = calibrator.apply();
        assert!(correction(&calibrator) <= limit, "{seed}");
        let record = calibrator.snapshot();
        assert_eq!(with_factory(limited).restore(&record), Ok(()), "{seed}");
    }
}

#[test]
fn witnesses_see_the_corrected_lens() {
    let factory = FactoryCalibration::new(cameras(), truth()).with_baseline_m(0.2).unwrap();
    let mut calibrator = Tested::new(COMPENSATE, &factory);
    let focal = 0.01;
    assert!(!drive(&mut calibrator, focal, 0.0, 0..100).is_empty());
    let last = pair(focal, 0.0, 100);
    take(&mut calibrator, &last).unwrap();
    calibrator.apply().unwrap();
    let Calibration { cameras: corrected, extrinsics, .. } = calibrator.in_use();
    let rotations = RectifyingRotations::from(&extrinsics);
    let yaw = |calibrator: &Tested, from: &RectifyingRotations<f32>| {
        let proposed = calibrator.proposal().unwrap().extrinsics;
        from.unknowns_to(&RectifyingRotations::from(&proposed)).y
    };
    // Points at the sides of the image, where the wrong focal length changes the disparities most.
    let sides = last.iter().filter(|c| (c.right[0] - 960.0).abs() > 500.0);
    for c in sides.take(5) {
        let rays = corrected.rays(c).unwrap();
        let [l, r] = [rays.left(), rays.right()];
        let a = rotations.left() * Vector3::new(l[0], l[1], 1.0);
        let b = rotations.right() * Vector3::new(r[0], r[1], 1.0);
        let depth = 0.2 / ((a.x / a.z - b.x / b.z) * a.z);
        let (range, sd_m) = (Range::AlongAxis(depth), 0.01 * depth);
        for right in [None, Some(c.right)] {
            let mut read = calibrator.clone();
            let reading = RangeReading { pixel: c.left, right, range, sd_m };
            assert_eq!(read.push_range(&reading), Ok(Witnessed::Taken), "{right:?}");
            let off = yaw(&read, &rotations);
            assert!(off.abs() < 3e-4, "{right:?}: {off}");
        }
    }
    // Rays of the factory cameras, which the witness corrects.
    let given = |rays: RayPair<f32>| {
        RayPair::try_new(rays.left(), rays.right().map(|x| x * (1.0 + focal))).unwrap()
    };
    for forward in [-4.0, 4.0] {
        let moved = tracked(NONE, 0.0, [0.5, 0.1, forward], 0.02);
        let moved: Vec<_> = moved.into_iter().map(|views| views.map(given)).collect();
        let mut read = calibrator.clone();
        assert_eq!(read.push_motion(&moved), Ok(Witnessed::Taken), "{forward}");
        let off = yaw(&read, &RectifyingRotations::from(&truth()));
        assert!(off.abs() < 5e-4, "{forward}: {off}");
    }
}
