//! Tests of the detection of small changes.

use nalgebra::Vector5;

use super::super::hypothesis::Update;
use super::super::hypothesis::tests::{context, evaluated_at, fused, truth};
use super::*;
use crate::algebra::symmetric5::Symmetric5;
use crate::pair::evaluate::EvaluatedPose;

/// Adds a pair to hypothesis and detector. Returns whether the window rejects the hypothesis.
fn add(
    hypothesis: &mut Hypothesis<f64>,
    detector: &mut ChangeDetector<f64>,
    pair: &EvaluatedPose<f64>,
) -> bool {
    let context = context();
    let mut update = Update::NONE;
    hypothesis.next_update(&pair.measurement, &context, &mut update).unwrap();
    hypothesis.apply(&pair.measurement, &mut update, &context);
    detector.add(hypothesis, &update.pair, &pair.measurement, &context);
    detector.has_changed(hypothesis, &context)
}

/// Returns the number of pairs after which the window rejects the hypothesis; `None` if it does not reject it. After
/// the 60th pair the rig turns about x by `rate` rad per pair.
fn pairs_until_rejected(rate: f64, seed: u64, pairs: u32) -> Option<u32> {
    let mut hypothesis = fused(&[evaluated_at(&truth(), seed)], 1, &context());
    let mut detector = ChangeDetector::NEW;
    (1..pairs).find(|k| {
        let turned = Vector5::ith(0, rate * f64::from(k.saturating_sub(60)));
        let pair = evaluated_at(&truth().stepped_by(&turned).unwrap(), seed + u64::from(*k));
        add(&mut hypothesis, &mut detector, &pair)
    })
}

#[test]
fn a_drift_of_half_an_arcsecond_per_pair_is_detected_and_a_rig_at_rest_is_not_rejected() {
    let until = pairs_until_rejected(3e-6, 1000, 100);
    assert!(until.is_some_and(|until| until > 60), "{until:?}");
    assert_eq!(pairs_until_rejected(0.0, 2000, 300), None);
}

#[test]
fn the_window_rejects_beyond_its_limit_times_the_reduced_chi_square() {
    let context = context();
    let pairs = fused(&[evaluated_at(&truth(), 0)], 1, &context);
    let mut detector = ChangeDetector::NEW;
    add(&mut pairs.clone(), &mut detector, &evaluated_at(&truth(), 1));
    let squared = pairs.normal_equations(&detector.moments).gradient.norm_squared();
    let mut changes = |statistic: f64, reduced_chi_square| {
        let variance = squared / statistic - context.prior;
        detector.variance = Information(Symmetric5::of_diagonal([variance; 5]));
        let hypothesis = pairs.scattered(reduced_chi_square);
        detector.has_changed(&hypothesis, &context)
    };
    assert_eq!([27.0, 29.0].map(|statistic| changes(statistic, 1.0)), [false, true]);
    assert_eq!([111.0, 113.0].map(|statistic| changes(statistic, 4.0)), [false, true]);
    // A reduced chi-square below 1 does not lower the limit.
    assert_eq!([27.0, 29.0].map(|statistic| changes(statistic, 0.5)), [false, true]);
}

#[test]
fn a_restart_of_the_window_keeps_the_mark_of_sums_with_pairs_from_before_a_change() {
    let context = context();
    let mut hypothesis = fused(&[evaluated_at(&truth(), 0)], 1, &context);
    let settles_after = |is_mixed: bool, hypothesis: &mut Hypothesis<f64>| {
        let mut detector = ChangeDetector { is_mixed, ..ChangeDetector::NEW };
        detector.restart();
        (1..=20).find(|k| {
            let pair = evaluated_at(&truth(), *k);
            let mut update = Update::NONE;
            hypothesis.next_update(&pair.measurement, &context, &mut update).unwrap();
            hypothesis.apply(&pair.measurement, &mut update, &context);
            detector.add(hypothesis, &update.pair, &pair.measurement, &context) == Finding::Settled
        })
    };
    let found = [true, false].map(|is_mixed| settles_after(is_mixed, &mut hypothesis));
    assert_eq!(found, [Some(WINDOW_PAIRS.into()), None]);
}
