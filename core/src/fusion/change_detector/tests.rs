//! Tests that each window alone detects the changes that it is designed for.

use super::super::hypothesis::Update;
use super::super::hypothesis::tests::{context, evaluated_at, fused, truth};
use super::*;
use crate::algebra::symmetric5::Symmetric5;
use crate::pair::evaluate::EvaluatedPose;

/// Adds a pair to hypothesis and detector. Returns whether the short window alone and the long window alone reject.
fn add(
    hypothesis: &mut Hypothesis<f64>,
    detector: &mut ChangeDetector<f64>,
    pair: &EvaluatedPose<f64>,
) -> [bool; 2] {
    let context = context();
    let mut update = Update::NONE;
    hypothesis.next_update(&pair.measurement, &context, &mut update).unwrap();
    let moved = hypothesis.apply(&pair.measurement, &mut update, &context);
    detector.add(hypothesis, &update.pair, &pair.measurement, &moved, &context);
    let no_long = ChangeDetector { long: NormalEquations::ZERO, ..detector.clone() };
    let no_short = ChangeDetector { short: Moments::ZERO, ..detector.clone() };
    [no_long, no_short].map(|detector| detector.has_changed(hypothesis, &context))
}

/// Returns the numbers of pairs after which the short window and the long window reject a rig that turns about x by
/// `rate` rad per pair after the 60th pair. `None` for a window that does not reject it.
fn pairs_until_rejected(rate: f64, seed: u64, pairs: u32) -> [Option<u32>; 2] {
    let mut hypothesis = fused(&[evaluated_at(&truth(), seed)], 1, &context());
    let mut detector = ChangeDetector::NEW;
    let mut until = [None; 2];
    for k in 1..pairs {
        let turned = Vector5::ith(0, rate * f64::from(k.saturating_sub(60)));
        let pair = evaluated_at(&truth().stepped_by(&turned).unwrap(), seed + u64::from(k));
        let rejects = add(&mut hypothesis, &mut detector, &pair);
        for (until, rejects) in until.iter_mut().zip(rejects) {
            *until = until.or(rejects.then_some(k));
        }
    }
    until
}

#[test]
fn only_the_long_window_detects_a_drift_of_a_fiftieth_of_an_arcsecond_per_pair() {
    let [short, long] = pairs_until_rejected(1e-7, 2000, 300);
    assert!(short.is_none() && long.is_some(), "{short:?} {long:?}");
    assert_eq!(pairs_until_rejected(0.0, 2000, 300), [None; 2]);
}

#[test]
fn the_short_window_detects_a_faster_drift_before_the_long_window() {
    let [short, long] = pairs_until_rejected(3e-6, 1000, 100);
    assert!(short.is_some_and(|short| long.is_none_or(|long| short < long)), "{short:?} {long:?}");
}

#[test]
fn a_window_rejects_beyond_its_limit_times_the_reduced_chi_square() {
    let context = context();
    let pairs = fused(&[evaluated_at(&truth(), 0)], 1, &context);
    let changes = |statistic: f64, reduced_chi_square| {
        let variance = 1e12;
        let mut detector = ChangeDetector::NEW;
        detector.long.gradient = Vector5::x() * (statistic * variance).sqrt();
        detector.long_variance = Information(Symmetric5::of_diagonal([variance; 5]));
        let hypothesis = pairs.scattered(reduced_chi_square);
        detector.has_changed(&hypothesis, &context)
    };
    assert_eq!([27.0, 29.0].map(|statistic| changes(statistic, 1.0)), [false, true]);
    assert_eq!([111.0, 113.0].map(|statistic| changes(statistic, 4.0)), [false, true]);
    // A reduced chi-square below 1 does not lower the limit.
    assert_eq!([27.0, 29.0].map(|statistic| changes(statistic, 0.5)), [false, true]);
}

#[test]
fn a_restart_of_the_windows_keeps_the_mark_of_sums_with_pairs_from_before_a_change() {
    let context = context();
    let mut hypothesis = fused(&[evaluated_at(&truth(), 0)], 1, &context);
    let settles_after = |is_mixed: bool, hypothesis: &mut Hypothesis<f64>| {
        let mut detector = ChangeDetector { is_mixed, ..ChangeDetector::NEW };
        detector.restart();
        (1..=20).find(|k| {
            let pair = evaluated_at(&truth(), *k);
            let mut update = Update::NONE;
            hypothesis.next_update(&pair.measurement, &context, &mut update).unwrap();
            let moved = hypothesis.apply(&pair.measurement, &mut update, &context);
            let measurement = &pair.measurement;
            detector.add(hypothesis, &update.pair, measurement, &moved, &context)
                == Finding::Settled
        })
    };
    let found = [true, false].map(|is_mixed| settles_after(is_mixed, &mut hypothesis));
    assert_eq!(found, [Some(SHORT_PAIRS.into()), None]);
}
