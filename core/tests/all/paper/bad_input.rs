//! Bad input leads to a typed refusal or a counted skip, and the estimate stays as it was, bit for bit.

use super::{published, take, with};
use crate::api::bad_input::{at, noisy_infinity};
use crate::api::scene::{cameras, correspondences, correspondences_within, rig};
use stereo_selfcal::paper::{PaperCalibrator, Settings};
use stereo_selfcal::{Camera, Correspondence, Extrinsics, Intrinsics, Lens, PushError, Rejection};

const ROTATION: [f64; 3] = [1.0, 2.0, -1.0];
const BASELINE: [f64; 2] = [2.0, 1.0];

#[test]
fn a_refused_match_is_counted_and_the_others_are_solved() {
    let mut calibrator = published::<f32>();
    let all = correspondences(&rig(ROTATION, BASELINE), 100, 0.3, 7);
    let bad = Correspondence { score: 2.0, ..all[0] };
    assert_eq!(calibrator.push(&bad), Err(PushError::Score));
    let outcome = calibrator.take_pair([bad].into_iter().chain(all));
    assert_eq!((calibrator.batch().refused(), outcome.pair.unwrap().usable), (1, 100));
}

#[test]
fn one_point_many_times_and_points_on_one_line_are_unobservable() {
    let point = [at([1100.0, 300.0], [1050.0, 310.0]); 200].to_vec();
    // Columns, rows and disparities change linearly along the line.
    let line = (0..200_u8).map(|i| {
        let s = f32::from(i);
        at([400.0 + 4.0 * s, 200.0 + 3.0 * s], [360.0 + 3.8 * s, 202.0 + 3.0 * s])
    });
    for matches in [point, line.collect()] {
        assert_eq!(take(&mut published(), &matches).fused, Err(Rejection::Unobservable));
    }
}

#[test]
fn points_at_infinity_are_never_fused_with_or_without_noise() {
    let mut scene = correspondences::<f32>(&Extrinsics::SIDE_BY_SIDE, 200, 0.0, 3);
    for c in &mut scene {
        c.right = c.left;
    }
    let mut calibrator = published();
    assert_eq!(take(&mut calibrator, &scene).fused, Err(Rejection::Unobservable));
    // The disparities consist of noise only.
    for seed in 0..50 {
        // The noise of some pairs looks like a baseline far from the start.
        let refused = matches!(
            take(&mut calibrator, &noisy_infinity(seed)).fused,
            Err(Rejection::CorrectionLimit | Rejection::Unobservable)
        );
        assert!(refused, "{seed}");
    }
    assert_eq!(calibrator.estimate(), None);
}

type Change = fn(Correspondence<f32>) -> Correspondence<f32>;

#[test]
fn points_behind_the_cameras_are_never_fused() {
    let exchanged: Change = |c| Correspondence { left: c.right, right: c.left, ..c };
    let mirrored: Change = |c| Correspondence { right: [1919.0 - c.right[0], c.right[1]], ..c };
    let upside_down: Change = |c| {
        let turned = |[u, v]: [f32; 2]| [1919.0 - u, 1199.0 - v];
        Correspondence { left: turned(c.left), right: turned(c.right), ..c }
    };
    for mistake in [exchanged, mirrored, upside_down] {
        for depths in [[3.0, 80.0], [30.0, 800.0]] {
            let mut calibrator = published::<f32>();
            for seed in 0..60 {
                let all = correspondences_within(&rig(ROTATION, BASELINE), depths, 250, 0.5, seed);
                let all: Vec<_> = all.into_iter().map(mistake).collect();
                assert!(take(&mut calibrator, &all).fused.is_err(), "{depths:?} {seed}");
            }
            assert_eq!(calibrator.estimate(), None);
        }
    }
}

#[test]
fn rays_behind_the_rectified_plane_are_skipped_and_counted() {
    // A very wide left camera sees these points 84 degrees off axis, and the rectification turns it by 8 degrees.
    let mut wide = cameras::<f32>();
    let intrinsics = Intrinsics { focal: [100.0; 2], ..*wide.left.intrinsics() };
    wide.left = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
    let start = rig([0.0, 8.0, 0.0], [0.0, 0.0]);
    let mut calibrator = PaperCalibrator::<f32, 256>::new(Settings::DEFAULT, wide, start);
    for c in correspondences::<f32>(&rig([0.0, 8.0, 0.0], [0.0, 0.0]), 200, 0.3, 3) {
        let left = c.left.map(|x| x / 14.0);
        let left = [left[0] + 959.5 * 13.0 / 14.0, left[1] + 599.5 * 13.0 / 14.0];
        calibrator.push(&Correspondence { left, ..c }).unwrap();
    }
    for v in [580.0, 600.0, 620.0] {
        calibrator.push(&at([1918.0, v], [1000.0, v])).unwrap();
    }
    let report = calibrator.solve_pair().pair.unwrap();
    assert_eq!([report.usable, report.skipped], [200, 3]);
}

#[test]
fn a_start_with_rays_behind_the_plane_is_recovered_from() {
    let start = rig([0.0, 65.0, 0.0], [0.0, 0.0]);
    let mut calibrator = PaperCalibrator::<f32, 256>::new(Settings::DEFAULT, cameras(), start);
    let outcome = take(&mut calibrator, &correspondences(&Extrinsics::SIDE_BY_SIDE, 200, 0.3, 3));
    let report = outcome.pair.unwrap();
    assert!(report.screened < 200, "none was behind at the start");
    assert_eq!([report.usable, report.skipped], [200, 0]);
    assert_eq!(outcome.fused, Err(Rejection::CorrectionLimit));
}

#[test]
fn a_pair_beyond_the_limits_is_refused_and_the_estimate_keeps_its_bits() {
    let refused = |settings: Settings, start: Extrinsics<f32>| {
        let mut calibrator = PaperCalibrator::<f32, 256>::new(settings, cameras(), start);
        let at_start = |seed| correspondences(&rig([0.1, 0.0, 0.1], [0.0; 2]), 200, 0.3, seed);
        for seed in 0..3 {
            let _ = take(&mut calibrator, &at_start(seed));
        }
        let before = calibrator.estimate();
        let pair = correspondences(&rig(ROTATION, BASELINE), 200, 0.3, 7);
        let why = take(&mut calibrator, &pair).fused.unwrap_err();
        assert_eq!(calibrator.estimate(), before);
        why
    };
    let near = Settings::DEFAULT.with_max_correction_rad(0.02).unwrap();
    assert_eq!(refused(near, Extrinsics::SIDE_BY_SIDE), Rejection::CorrectionLimit);
    // The baseline alone is beyond the limit.
    assert_eq!(refused(near, rig(ROTATION, [0.0, 0.0])), Rejection::CorrectionLimit);
    let strict = Settings::DEFAULT.with_max_sd_rad(1e-6).unwrap();
    assert_eq!(refused(strict, Extrinsics::SIDE_BY_SIDE), Rejection::TooUncertain);
}

#[test]
fn a_reset_forgets_the_pairs_and_a_pair_counts_once() {
    let mut calibrator = with::<f32>(Settings::DEFAULT);
    let pair = correspondences(&rig(ROTATION, BASELINE), 200, 0.3, 5);
    take(&mut calibrator, &pair).fused.unwrap();
    let before = calibrator.estimate();
    assert_eq!(before.unwrap().pairs, 1);
    let none = Err(Rejection::TooFew { usable: 0, needed: 12 });
    assert_eq!(calibrator.solve_pair().fused, none);
    assert_eq!(calibrator.estimate(), before);
    for c in &pair {
        calibrator.push(c).unwrap();
    }
    assert_eq!(calibrator.advance_pair(), None);
    calibrator.reset();
    assert_eq!((calibrator.solve_pair().fused, calibrator.estimate()), (none, None));
}
