//! Tests of the promotion of a challenger, of the gates, and of the renewal of a champion.

use super::super::hypothesis::tests::{context, evaluated, evaluated_at, fused, truth};
use super::*;
use crate::algebra::block_variances::BlockVariances;
use crate::fusion::lens_reference::LensReference;
use crate::thresholds::{FOUND_NEAR, FOUND_NEAR_MOST, WINDOW_PAIRS};
use nalgebra::Vector5;
use std::vec::Vec;

extern crate std;

/// Returns hypotheses with a challenger that [`MIN_AGREED`] pairs agree with, with or without a champion.
fn hypotheses(champion: Option<&Hypothesis<f64>>, challenger: &Hypothesis<f64>) -> Hypotheses<f64> {
    let champion = champion
        .map(|hypothesis| Champion { hypothesis: *hypothesis, detector: ChangeDetector::NEW });
    let challenger = Some(Challenger { hypothesis: *challenger, agreed: MIN_AGREED, failed: 0 });
    Hypotheses { champion, challenger, rejected: 3, is_confirmed: true, begun: 0 }
}

fn pairs(turned: f64, seeds: core::ops::Range<u64>) -> Vec<EvaluatedPose<f64>> {
    let rig = truth().stepped_by(&Vector5::ith(0, turned)).unwrap();
    seeds.map(|seed| evaluated_at(&rig, seed)).collect()
}

#[test]
fn pairs_that_the_caller_discards_cause_no_search_with_a_turned_baseline() {
    let turned = |discards: bool| {
        let mut hypotheses = Hypotheses::<f64>::NONE;
        (0..10).any(|_| {
            if discards {
                hypotheses.forget_begun();
            }
            hypotheses.next_turn().is_some()
        })
    };
    assert_eq!([false, true].map(turned), [true, false]);
}

#[test]
fn a_challenger_takes_over_after_three_pairs_if_it_departs_and_else_after_eight() {
    let (context, mut reference) = (context(), LensReference::GIVEN);
    let champion = fused(&pairs(0.0, 0..10), 1, &context);
    let turned = 0.1_f64.to_radians();
    for (by, agreed, takes_over) in [(0.0, 7, false), (0.0, 8, true), (turned, 3, true)] {
        let challenger = fused(&pairs(by, 20..23), 1, &context);
        let mut both = hypotheses(Some(&champion), &challenger);
        both.challenger.as_mut().unwrap().agreed = agreed;
        let expected = if takes_over { Fused::TookOver } else { Fused::KeptApart };
        assert_eq!(both.promote(&mut reference, &context), expected);
        assert_eq!(both.challenger().is_none(), takes_over);
        // While the challenger stays, every pair disagrees with the champion, so the estimate is not locked.
        let state = if takes_over { State::Locked } else { State::Suspect };
        assert_eq!(both.state(), state);
        let after = both.champion().unwrap();
        assert_eq!(after.noise(), challenger.noise());
        assert_eq!(after.pose() == champion.pose(), !takes_over);
    }
}

#[test]
fn a_challenger_that_is_not_certain_does_not_lock() {
    let (context, mut reference) = (context(), LensReference::GIVEN);
    let certain = fused(&pairs(0.0, 0..4), 1, &context);
    let mut alone = hypotheses(None, &certain);
    assert_eq!(alone.promote(&mut reference, &context), Fused::Added);
    assert_eq!(alone.state(), State::Locked);
    let mut alone = hypotheses(None, &certain.drifting(Vector5::ith(0, 0.2)));
    assert_eq!(alone.promote(&mut reference, &context), Fused::Added);
    assert_eq!(alone.state(), State::Acquiring);
}

#[test]
fn a_pair_without_a_clear_peak_supports_no_challenger() {
    let context = context();
    let alone = hypotheses(None, &fused(&pairs(0.0, 0..4), 1, &context));
    let mut pair = evaluated::<f64>(9);
    assert!(alone.gate_of_challenger(&pair, &context));
    // With 9 residuals within 2 units of the loss and 6 from 2 to 4 units, the peak does not exceed chance.
    pair.stats.within = [9.0, 12.0, 15.0];
    pair.stats.usable = 20.0;
    assert!(!pair.has_clear_peak() && pair.has_peak());
    assert!(!alone.gate_of_challenger(&pair, &context));
}

#[test]
fn a_pair_passes_a_gate_only_with_a_peak_of_enough_matches() {
    let context = context();
    let hypothesis = fused(&pairs(0.0, 0..4), 1, &context);
    let pair = evaluated::<f64>(9);
    assert!(hypothesis.gate(&pair, 1.0, &context));
    // A tracked pose needs half of the share of near residuals that a pose found from afar needs.
    let near = pair.stats.within[0];
    let [base, per_px] = FOUND_NEAR;
    let of_pair = base + per_px * pair.measurement.noise;
    for (noise, share) in [(pair.measurement.noise, of_pair), (4.0, FOUND_NEAR_MOST)] {
        for (part, passes) in [(0.99, true), (1.01, false)] {
            let mut many = pair;
            many.measurement.noise = noise;
            many.stats.usable = part * near / (0.5 * share);
            assert_eq!(hypothesis.gate(&many, 1.0, &context), passes, "{noise}");
        }
    }
    let mut flat = EvaluatedPose { stats: EvaluatedPose::NONE.stats, ..pair };
    flat.stats.usable = pair.stats.usable;
    assert!(!flat.has_peak());
    assert!(!hypothesis.gate(&flat, 1.0, &context));
}

#[test]
fn the_change_detector_restarts_when_a_vibration_begins_and_when_it_ceases() {
    let rigid = context::<f64>();
    let turning = rigid.vibrating(BlockVariances { rotation: 4e-6, baseline: 4e-6 });
    let hypothesis = fused(&pairs(0.0, 0..20), 1, &rigid);
    let mut champion = Champion { hypothesis, detector: ChangeDetector::NEW };
    let seen = (20..29).zip(pairs(0.0, 20..29)).map(|(seed, evaluated)| {
        let turns = (23..26).contains(&seed);
        let context = if turns { &turning } else { &rigid };
        champion.add(&evaluated.measurement, context).unwrap();
        champion.detector.pairs()
    });
    assert_eq!(seen.collect::<Vec<_>>(), [1, 2, 3, 1, 2, 3, 1, 2, 3]);
}

#[test]
fn ten_pairs_after_a_renewal_the_sums_hold_no_pair_from_before_the_change() {
    let (context, mut reference) = (context(), LensReference::GIVEN);
    let turned = 1e-4;
    let hypothesis = fused(&pairs(0.0, 0..80), 1, &context);
    let mut champion = Champion { hypothesis, detector: ChangeDetector::NEW };
    let changed = truth().stepped_by(&Vector5::ith(0, turned)).unwrap();
    let fused = pairs(0.0, 80..100).into_iter().chain(pairs(turned, 100..130)).map(|pair| {
        let fused = champion.fuse(&pair.measurement, &mut reference, &context).unwrap();
        let off = champion.hypothesis.pose().unknowns_to(&changed).x;
        (fused, champion.hypothesis.pairs(), off)
    });
    let fused: Vec<_> = fused.collect();
    let renewed = fused.iter().rposition(|(fused, ..)| *fused == Fused::Renewed).unwrap();
    let ten_later = renewed + usize::try_from(WINDOW_PAIRS).unwrap();
    let [before, after] = [fused[ten_later - 1], fused[ten_later]];
    assert_eq!((before.1, after.1), (2 * WINDOW_PAIRS - 1, WINDOW_PAIRS));
    assert!(before.2 > 0.2 * turned && after.2.abs() < 0.1 * turned, "{before:?} {after:?}");
}
