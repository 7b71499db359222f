//! Tests of the bank of filters.

use super::*;
use crate::algebra::normal_equations::tests::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Deviations of the factory yaw, of the yaw of the lens, of the noise of a pair and of the filter's scatter, rad.
const FACTORY: f64 = 8.7e-4;
const LENS: f64 = 4.6e-3;
const NOISE: f64 = 3.5e-4;
const SCENE: f64 = 6e-4;
const DEGREE: f64 = 0.017_453_3;

/// Errors of the mount yaw after a run, rad.
struct Run {
    /// Error after the last pair.
    end: f64,
    /// Largest error after the first 50 pairs.
    worst: f64,
    /// Largest ratio of error and reported deviation after the first 50 pairs.
    ratio: f64,
}

/// Runs the bank of a commissioned rig over the yaws of pairs.
///
/// * `lens`: yaw of the lens, rad; `turn`: yaw of the mount after a number of pairs, rad.
fn run(lens: f64, pairs: u32, seed: u64, turn: impl Fn(f64) -> f64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let single = f32::lit;
    let prior = YawEstimate::of_mount(0.0, single(FACTORY * FACTORY), single(LENS * LENS));
    let mut bank = None::<Bank<f32>>;
    // Scenes resemble their neighbours. Recorded pairs have such a scatter and correlation: 0.5 mrad; 0.4, 0.3 and 0.2
    // over one to three pairs.
    let mut scene = 0.0;
    let mut found = Run { end: 0.0, worst: 0.0, ratio: 0.0 };
    for pair in 0..pairs {
        scene = 0.8 * scene + 0.6 * 4e-4 * normal(&mut rng);
        let mount = turn(f64::from(pair));
        let rows = mount + lens + scene + NOISE * normal(&mut rng);
        let (rows, variance) = (single(rows), single(NOISE * NOISE + SCENE * SCENE));
        let with_first = || Bank::at_rest(prior.with(Measured::Rows, rows, variance));
        match &mut bank {
            Some(bank) => bank.add_rows(rows, variance),
            None => bank = Some(with_first()),
        }
        let yaw = bank.unwrap().estimate();
        found.end = f64::from(yaw.mount()) - mount;
        if pair >= 50 {
            found.worst = found.worst.max(found.end.abs());
            let sd = f64::from(yaw.var_mount()).sqrt();
            found.ratio = found.ratio.max(found.end.abs() / sd);
        }
    }
    found
}

#[test]
fn a_mount_at_rest_keeps_its_factory_yaw_whatever_the_lens_is() {
    for lens in [0.0, 0.003, -0.009] {
        for seed in 0..8 {
            let Run { worst, ratio, .. } = run(lens, 1000, seed, |_| 0.0);
            assert!(worst < 1.5e-3 && ratio < 1.5, "{lens} {seed}: {worst} {ratio}");
        }
    }
}

#[test]
fn drift_at_any_rate_and_warm_up_are_followed() {
    for lens in [0.0, 0.003] {
        for (rate, pairs) in [(3e-7, 2000), (1e-6, 1000), (1e-5, 600), (3e-5, 600), (3e-4, 100)] {
            for seed in 0..6 {
                let Run { worst, ratio, .. } = run(lens, pairs, seed, |pair| rate * pair);
                assert!(worst < 2.5e-3 && ratio < 2.5, "{rate} {lens} {seed}: {worst} {ratio}");
            }
        }
        // To a new place, and there and back.
        for fall in [f64::INFINITY, 300.0] {
            let turn = |pair: f64| 2e-3 * (1.0 - (-pair / 100.0).exp()) * (-pair / fall).exp();
            let Run { worst, ratio, .. } = run(lens, 1500, 3, turn);
            assert!(worst < 1.5e-3 && ratio < 2.5, "{lens} {fall}: {worst} {ratio}");
        }
    }
}

#[test]
fn knocks_from_a_tenth_of_a_degree_to_three_degrees_turn_the_mount_and_not_the_lens() {
    for lens in [0.0, 0.003] {
        for knock in [0.1, -0.1, 0.3, -1.0, 3.0] {
            for seed in 0..6 {
                let turn = |pair| if pair < 50.0 { 0.0 } else { knock * DEGREE };
                let Run { end, .. } = run(lens, 100, seed, turn);
                assert!(end.abs() < 1.2e-3, "{knock} {lens} {seed}: {end}");
            }
        }
    }
}

#[test]
fn weights_stay_finite_and_sum_to_one_whatever_the_pairs_show() {
    let prior = YawEstimate::of_mount(0.0, 7.6e-7_f32, 2.1e-5);
    for yaw in [0.0, 1e-12, 1.0, -3.0] {
        for variance in [1e-12, 1e-7, 1e3] {
            let mut bank = Bank::of(prior);
            for sign in [1.0, -1.0, 1.0, 1.0] {
                bank.add_rows(sign * yaw, variance);
                let sum: f32 = bank.0.iter().map(|(weight, _)| *weight).sum();
                assert!((sum - 1.0).abs() < 1e-6, "{yaw} {variance}: {bank:?}");
                let valid = YawEstimate::of(bank.estimate().numbers());
                assert!(valid.is_some(), "{yaw} {variance}: {bank:?}");
            }
        }
    }
}

#[test]
fn a_witness_tells_the_lens_in_all_members() {
    let mut bank = Bank::of(YawEstimate::of_mount(0.0, 7.6e-7_f32, 2.1e-5));
    (0..20).for_each(|_| bank.add_rows(0.005, 5e-7));
    bank.add(Measured::Mount, 0.001, 1e-8);
    let Bank(members) = bank;
    assert!(members.iter().all(|(_, yaws)| (yaws.mount() - 0.001).abs() < 2e-5), "{members:?}");
    assert!((bank.estimate().lens() - 0.004).abs() < 2e-4, "{:?}", bank.estimate());
}

#[test]
fn weights_stay_finite_when_measurements_of_the_mount_contradict_each_other() {
    let prior = YawEstimate::of_mount(0.0, f32::lit(FACTORY * FACTORY), f32::lit(LENS * LENS));
    let mut bank = Bank::at_rest(prior);
    // The members differ after a knock.
    (0..5).for_each(|pair| bank.add_rows(if pair < 3 { 0.0 } else { 0.02 }, 1e-8));
    for yaw in [0.0, 0.02, -0.02, 0.3, -0.3, 0.0] {
        bank.add(Measured::Mount, yaw, 1e-10);
        let found = bank.estimate();
        assert!(found.numbers().iter().all(|x| x.is_finite()), "{yaw}: {found:?}");
    }
}
