//! Compares the estimated variances with the true variances of simulated pairs.

extern crate std;

use super::samples::sort;
use super::*;
use crate::algebra::moments::Moments;
use crate::algebra::normal_equations::tests::normal;
use crate::config::Config;
use crate::geometry::extrinsics::Extrinsics;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::vec::Vec;

/// Standard deviations of the optimum of one pair, rad.
const PAIR_SD: [f64; 5] = [1e-4, 4e-4, 1e-4, 1e-3, 5e-4];

/// Adds the optima of a rig that follows `path` and vibrates. Returns the variances after each pair.
///
/// * `sd`: standard deviations of the vibration of rotation and baseline, rad.
fn followed(
    pairs: u32,
    sd: [f64; 2],
    seed: u64,
    path: impl Fn(u32) -> Vector5<f64>,
) -> Vec<BlockVariances<f64>> {
    scattered(1.0, pairs, sd, seed, path)
}

/// As [`followed`], with optima that scatter by `deviations` times their standard deviations.
fn scattered(
    deviations: f64,
    pairs: u32,
    [rotation, baseline]: [f64; 2],
    seed: u64,
    path: impl Fn(u32) -> Vector5<f64>,
) -> Vec<BlockVariances<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut estimator = VibrationEstimator::<f64>::RIGID;
    let covariance = Symmetric5::of_diagonal(PAIR_SD.map(|sd| sd * sd));
    let shakes = [rotation, rotation, rotation, baseline, baseline];
    (0..pairs)
        .map(|pair| {
            let sd = PAIR_SD.map(|sd| deviations * sd);
            let noise = Vector5::from_fn(|i, _| sd[i].hypot(shakes[i]) * normal(&mut rng));
            estimator.compare(path(pair) + noise, covariance);
            estimator.variances()
        })
        .collect()
}

fn still(_: u32) -> Vector5<f64> {
    Vector5::zeros()
}

#[test]
fn the_variances_of_rotation_and_baseline_are_told_apart() {
    for (rotation, baseline) in [(1e-3, 0.0), (1.7e-3, 3e-3), (0.0, 4e-3), (3e-4, 0.0)] {
        for seed in 0..20 {
            let last = followed(60, [rotation, baseline], seed, still)[59];
            let [found_r, found_b] = [last.rotation.sqrt(), last.baseline.sqrt()];
            assert!((found_r - rotation).abs() <= 0.3 * rotation, "{seed}: {rotation}, {found_r}");
            assert!((found_b - baseline).abs() <= 0.35 * baseline, "{seed}: {baseline}, {found_b}");
        }
    }
}

/// A vibration of both blocks raises all ratios, and so looks like scatter in part.
#[test]
fn a_vibration_of_both_blocks_is_not_taken_for_scatter() {
    for (sd, least) in [([3e-4, 2e-3], [20, 38]), ([5e-4, 3e-3], [36, 40]), ([7e-4, 3e-3], [40; 2])]
    {
        let mut found = [0; 2];
        for seed in 0..40 {
            let [.., BlockVariances { rotation, baseline }] = followed(60, sd, seed, still)[..]
            else {
                panic!()
            };
            found[0] += u32::from(rotation > 0.0);
            found[1] += u32::from(baseline > 0.0);
        }
        std::println!("{sd:?} rad: found in {found:?} of 40 runs");
        assert!(found[0] >= least[0] && found[1] >= least[1], "{sd:?}: {found:?}");
    }
}

#[test]
fn a_rigid_rig_a_drift_and_a_knock_are_no_vibration() {
    let drift = |pair: u32| Vector5::repeat(f64::from(pair) * 3.5e-4);
    let knock = |pair: u32| Vector5::repeat(if pair < 20 { 0.0 } else { 5e-3 });
    let mut told = [0; 3];
    for seed in 0..40 {
        let all = [
            followed(60, [0.0; 2], seed, still),
            followed(60, [0.0; 2], seed, drift),
            followed(60, [0.0; 2], seed, knock),
        ];
        for (told, all) in told.iter_mut().zip(all) {
            *told += all.iter().filter(|variances| !variances.is_zero()).count();
        }
    }
    // Each count is over 2,400 pairs, for a rigid rig, a drift and a knock.
    assert!(told.iter().all(|told| *told <= 12), "{told:?}");
}

#[test]
fn optima_that_scatter_beyond_their_covariance_are_no_vibration() {
    let mut told = [0; 2];
    for seed in 0..40 {
        for BlockVariances { rotation, baseline } in scattered(2.0, 60, [0.0; 2], seed, still) {
            told[0] += u32::from(rotation > 0.0);
            told[1] += u32::from(baseline > 0.0);
        }
        let [.., last] = scattered(2.0, 60, [1.7e-3, 3e-3], seed, still)[..] else { panic!() };
        assert!((1e-3..2.6e-3).contains(&last.rotation.sqrt()), "{seed}: {last:?}");
    }
    // Each count is over 2,400 pairs.
    assert!(told.iter().all(|told| *told <= 200), "{told:?}");
}

#[test]
fn a_vibration_that_begins_late_is_noticed_within_ten_pairs() {
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
        let shakes: Vec<f64> = (0..60).map(|_| 2e-3 * normal(&mut rng)).collect();
        let begun = |pair: u32| {
            let at = usize::try_from(pair).unwrap();
            let shake = if pair < 30 { 0.0 } else { shakes[at] };
            Vector5::new(shake, -shake, shake, 0.0, 0.0)
        };
        let all = followed(60, [0.0; 2], seed, begun);
        let noticed = all.iter().position(|variances| variances.rotation > 0.0);
        assert!(noticed.is_some_and(|at| (31..=40).contains(&at)), "{noticed:?}");
    }
}

#[test]
fn sorting_is_ascending() {
    let mut values = [3.0, -1.0, 2.0, 2.0, 0.5];
    sort(&mut values);
    assert_eq!(values, [-1.0, 0.5, 2.0, 2.0, 3.0]);
    sort::<f64>(&mut []);
}

#[test]
fn pairs_without_moments_are_left_out() {
    static CONFIG: Config = Config::robust();
    let factory = Extrinsics::<f64>::SIDE_BY_SIDE;
    let context = Context::new(&CONFIG, &factory, 1400.0);
    let mut estimator = VibrationEstimator::RIGID;
    let mut measurement = crate::pair::evaluate::EvaluatedPose::<f64>::NONE.measurement;
    measurement.moments = Moments::ZERO;
    for _ in 0..20 {
        estimator.add(&measurement, &context);
    }
    assert!(estimator.variances().is_zero());
}
