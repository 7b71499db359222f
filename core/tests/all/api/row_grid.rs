//! Rows that a matcher has not measured, and rows on a grid that it does not state.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::{
    Calibrator, Cause, Config, Correspondence, Extrinsics, FactoryCalibration, Rejection,
};

use crate::api::presets::calibrated;
use crate::api::scene::{SIZE, cameras, correspondences, rig, take};

type Pair = Vec<Correspondence<f32>>;

const NOISE_PX: f64 = 0.3;
const BASELINE: [f64; 2] = [0.3, -0.2];

/// Angles by which a rig is off from identity, degrees: 0.2 to 3 mrad about each axis.
fn angles(seed: u64) -> [f64; 3] {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    [(); 3].map(|()| {
        let mrad: f64 = rng.random_range(0.2..3.0);
        (if rng.random() { mrad } else { -mrad } * 1e-3).to_degrees()
    })
}

fn scene(truth: &Extrinsics<f64>, seed: u64) -> Pair {
    correspondences(truth, 250, NOISE_PX, seed)
}

/// A pair of a matcher that searches along the rows of the images.
fn copied(truth: &Extrinsics<f64>, seed: u64) -> Pair {
    let one = |c: Correspondence<f32>| Correspondence { right: [c.right[0], c.left[1]], ..c };
    scene(truth, seed).into_iter().map(one).collect()
}

/// Random disparities with equal rows.
fn random(seed: u64) -> Pair {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let [width, height] = SIZE.map(f32::from);
    let one = |_| {
        let [u, v] = [rng.random_range(120.0..width - 1.0), rng.random_range(0.0..height - 1.0)];
        let right = [u - rng.random_range(0.0..120.0), v];
        Correspondence { left: [u, v], right, score: 1.0, grid_step: 0.0 }
    };
    (0..200).map(one).collect()
}

/// A pair of a matcher that searches along the rows after rectification with `in_use`.
fn along_rectified_rows(truth: &Extrinsics<f64>, in_use: &Extrinsics<f64>, seed: u64) -> Pair {
    let (cameras, rotations) = (cameras::<f64>(), RectifyingRotations::from(in_use));
    let one = |c: Correspondence<f64>| {
        let rays = cameras.rays(&c).ok()?;
        let [l, r] = [rays.left(), rays.right()].map(|[x, y]| Vector3::new(x, y, 1.0));
        let (l, r) = (rotations.left() * l, rotations.right() * r);
        let r = rotations.right().inverse() * Vector3::new(r.x / r.z, l.y / l.z, 1.0);
        let right = cameras.right.pixel([r.x / r.z, r.y / r.z].into()).ok()?;
        let [left, right] = [c.left, right].map(|p| p.map(|x| x as f32));
        Some(Correspondence { left, right, score: 1.0, grid_step: 0.0 })
    };
    correspondences(truth, 250, NOISE_PX, seed).into_iter().filter_map(one).collect()
}

/// A pair of a matcher of whole pixels, which states `grid_step`.
fn whole(pair: &[Correspondence<f32>], grid_step: f32) -> Pair {
    let round = |[u, v]: [f32; 2]| [u.round(), v.round()];
    let one = |c: &Correspondence<f32>| Correspondence {
        left: round(c.left),
        right: round(c.right),
        grid_step,
        ..*c
    };
    pair.iter().map(one).collect()
}

/// Checks that pairs whose rows were not measured change nothing, and that the cause is named.
fn learns_nothing(factory: Extrinsics<f32>, pairs: impl Iterator<Item = Pair>) {
    let mut calibrator = calibrated(factory);
    for pair in pairs {
        let fused = calibrator.take_pair(pair).fused; // a pixel beyond the border is refused
        assert_eq!(fused, Err(Rejection::RowsNotMeasured));
        assert!(calibrator.apply().is_err() && !calibrator.verdict().may_arm);
    }
    assert_eq!(calibrator.in_use().extrinsics, factory);
    assert_eq!(calibrator.verdict().cause, Some(Cause::RowsNotMeasured));
    assert!(calibrator.proposal().is_none());
}

#[test]
fn copied_rows_teach_nothing_in_the_images_or_after_rectification() {
    for seed in 0..12 {
        let [x, y, z] = angles(seed);
        let (truth, factory) = (rig([x, y, z], BASELINE), rig([x, y, z], BASELINE));
        let seeds = 20 * seed..20 * seed + 8;
        learns_nothing(factory, seeds.clone().map(|seed| copied(&truth, seed)));
        learns_nothing(factory, seeds.clone().map(random));
        let off = [x + 0.1, y, z - 0.1];
        let in_use = rig(off, BASELINE);
        let rectified = seeds.map(|seed| along_rectified_rows(&truth, &in_use, seed));
        learns_nothing(rig(off, BASELINE), rectified);
    }
}

#[test]
fn a_locked_rig_keeps_its_calibration_when_its_matcher_stops_measuring_rows() {
    let angles = [0.5, -0.3, 0.4];
    let mut calibrator = calibrated(rig(angles, BASELINE));
    for seed in 0..6 {
        take(&mut calibrator, &scene(&rig(angles, BASELINE), seed)).unwrap();
        let _ = calibrator.apply();
    }
    let (proposal, in_use) = (calibrator.proposal(), calibrator.in_use());
    for seed in 0..12 {
        assert!(take(&mut calibrator, &random(seed)).is_err());
        assert_eq!(calibrator.verdict().may_arm, seed < 9, "{}", calibrator.verdict());
    }
    assert_eq!((calibrator.proposal(), calibrator.in_use()), (proposal, in_use));
}

/// Errors of the five unknowns over their deviations, and the largest error, after 60 pairs of whole pixels.
fn after_60(seed: u64, grid_step: f32) -> ([f32; 5], f32) {
    let truth = rig(angles(seed), BASELINE);
    let made = FactoryCalibration::new(cameras(), rig([0.0; 3], [0.0; 2])).without_yaw();
    let mut calibrator = Calibrator::<f32, 256>::new(Config::robust(), &made);
    for pair in 0..60 {
        let _ = take(&mut calibrator, &whole(&scene(&truth, 1000 * seed + pair), grid_step));
    }
    let proposal = calibrator.proposal().unwrap();
    let truth = rig::<f32>(angles(seed), BASELINE);
    let [found, truth] = [&proposal.extrinsics, &truth].map(RectifyingRotations::from);
    let (off, covariance) = (truth.unknowns_to(&found), proposal.covariance);
    (core::array::from_fn(|i| off[i] / covariance[(i, i)].sqrt()), off.amax())
}

#[test]
fn whole_pixels_that_are_not_stated_are_as_good_as_stated_ones() {
    let mut squares = [0.0; 2];
    for seed in 0..12 {
        let both = [0.0, 1.0].map(|step| after_60(seed, step));
        for ((over, _), sum) in both.iter().zip(&mut squares) {
            *sum += over.iter().map(|x| x * x).sum::<f32>() / 60.0;
        }
        let [(_, untold), (_, told)] = both;
        assert!((told - untold).abs() < 0.1 * told + 1e-5, "{seed}: {told} {untold}");
    }
    let [untold, told] = squares.map(f32::sqrt);
    println!("RMS of error over deviation: {untold:.2}, stated {told:.2}");
    assert!(untold < 2.5 && told < 2.5, "RMS of error over deviation: {untold}, stated {told}");
}
