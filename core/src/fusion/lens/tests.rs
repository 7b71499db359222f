//! Tests that the inverse of the information on the lens equals nalgebra's, and that implausible estimates are refused.

extern crate std;

use super::super::hypothesis::tests::context;
use super::super::lens_change::hides_much;
use super::super::lens_reference::LensReference;
use super::equations::invert;
use super::*;
use nalgebra::SMatrix;
use std::vec::Vec;

type Full = SMatrix<f64, LENS_PARAMETERS, LENS_PARAMETERS>;

/// Returns the information of [`LENS_PARAMETERS`] rows whose columns differ greatly in size.
fn information() -> Full {
    let units = [1e3, 1e3, 1e2, 1e2, 1e2, 1e2, 30.0, 30.0, 50.0];
    let index = |i: usize| f64::from(u32::try_from(i).unwrap());
    let rows = Full::from_fn(|i, k| (1.3 * index(i) + 0.7 * index(k * k)).sin() * units[k]);
    rows.transpose() * rows
}

#[test]
fn values_and_variances_far_beyond_the_prior_are_refused() {
    let sd = [0.1; LENS_PARAMETERS];
    let is_sane = |value: f64, variance: f64, scale: f64| {
        let mut lens = HypothesisLens::EXACT;
        lens.values[7] = value;
        lens.covariance[7][7] = variance;
        lens.is_sane(&sd, scale)
    };
    let variances = [-1e-9, 0.0, 0.039, 0.041];
    assert_eq!(variances.map(|v| is_sane(0.0, v, 1.0)), [false, true, true, false]);
    assert_eq!([0.079, 0.081].map(|v| is_sane(0.0, v, 2.0)), [true, false]);
    assert_eq!([-99.0, 99.0, 101.0].map(|x| is_sane(x, 0.0, 1.0)), [true, true, false]);
    assert_eq!([f64::NAN, 0.0].map(|x| is_sane(x, f64::NAN, 1.0)), [false; 2]);
}

fn posterior(mut a: Square<f64>, sd: &[f64; LENS_PARAMETERS]) -> Option<Square<f64>> {
    invert(&mut a, sd).map(|()| a)
}

#[test]
fn the_posterior_is_the_inverse_of_information_and_prior_without_the_held_parameters() {
    let sd = [0.003, 0.003, 7e-4, 7e-4, 7e-4, 7e-4, 0.005, 0.0, 0.001];
    let got = Full::from(posterior(information().transpose().into(), &sd).unwrap());
    let free: Vec<usize> = [0, 1, 2, 3, 6, 8].into();
    let mut expected = SMatrix::<f64, 6, 6>::from_fn(|i, k| information()[(free[i], free[k])]);
    for (i, place) in free.iter().enumerate() {
        expected[(i, i)] += 1.0 / (sd[*place] * sd[*place]);
    }
    let expected = expected.try_inverse().unwrap();
    for i in 0..LENS_PARAMETERS {
        for k in 0..LENS_PARAMETERS {
            let place = |of: usize| free.iter().position(|free| *free == of);
            let expected = place(i).zip(place(k)).map_or(0.0, |at| expected[at]);
            let unit = sd[i].max(1e-4) * sd[k].max(1e-4);
            assert!((got[(i, k)] - expected).abs() < 1e-9 * unit, "{i} {k}");
        }
    }
}

#[test]
fn without_information_the_posterior_is_the_prior_and_nan_is_refused() {
    let sd: [f64; LENS_PARAMETERS] = [0.003, 0.002, 7e-4, 6e-4, 5e-4, 4e-4, 0.005, 0.004, 0.001];
    let got = posterior([[0.0; LENS_PARAMETERS]; LENS_PARAMETERS], &sd).unwrap();
    for (i, (row, sd)) in got.iter().zip(sd).enumerate() {
        let expected = if i == 4 || i == 5 { 0.0 } else { sd * sd };
        assert!((row[i] - expected).abs() < 1e-15, "{i}");
    }
    assert!(posterior([[f64::NAN; LENS_PARAMETERS]; LENS_PARAMETERS], &sd).is_none());
}

#[test]
fn a_difference_is_significant_beyond_three_deviations_with_the_part_that_weights_hide() {
    let is_significant = |sd: f64| {
        let mut lens = HypothesisLens::EXACT;
        lens.values[1] = 0.01;
        lens.covariance[1][1] = sd * sd;
        lens.is_significant()
    };
    // 0.01^2 = 9 (sd^2 + (0.17 * 0.01)^2) at 2.87e-3.
    assert_eq!([2.8e-3, 2.9e-3].map(is_significant), [true, false]);
}

#[test]
fn weights_hide_much_if_the_hidden_step_exceeds_a_tenth_of_the_deviation_of_t() {
    let mut lens = HypothesisLens::<f64>::EXACT;
    lens.effects[1][3] = 1.0;
    let hides = |lens: &HypothesisLens<f64>, sd: f64| {
        hides_much(lens, &Symmetric5::of_diagonal([sd * sd; 5]), &context())
    };
    assert!(!hides(&lens, 1e-2));
    // The weights may hide 0.17 of a step of 0.01 rad.
    lens.values[1] = 0.01;
    assert_eq!([1e-2, 1e-1].map(|sd| hides(&lens, sd)), [true, false]);
}

#[test]
fn a_lens_is_far_from_the_known_one_beyond_three_deviations_of_both() {
    let known = [4.0, 1.0].map(|unit: f64| 1.0 / (unit * unit * 1e-6));
    let is_far = |parameter: usize, value: f64, weights: [f64; 2]| {
        let mut lens = HypothesisLens::EXACT;
        lens.values[parameter] = value;
        lens.covariance[parameter][parameter] = 9e-6;
        LensReference { weights, ..LensReference::GIVEN }.is_far_from(&lens)
    };
    // Focal length: x^2 = 9 (9e-6 + (0.17 x)^2 + 16e-6) at 0.0174; k1: x^2 = 9 (9e-6 + (0.17 x)^2 + 1e-6) at 0.0110.
    assert_eq!([0.0172, 0.0176].map(|x| is_far(1, x, known)), [false, true]);
    assert_eq!([0.0109, 0.0112].map(|x| is_far(7, -x, known)), [false, true]);
    // Without information on a difference nothing is far from it.
    assert!(!is_far(1, 1.0, [0.0, known[1]]));
}
