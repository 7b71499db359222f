//! Estimates over many pairs against what they are made of.

extern crate std;

use super::*;
use crate::batch::Batch;
use crate::config::Config;
use crate::correspondence::RayPair;
use crate::residual::tests::pose;
use crate::robust::Descent;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::vec::Vec;

const FOCAL: f64 = 1400.0;

fn lineage<T: Scalar>() -> Lineage<T> {
    Lineage::new(&Config::robust(), &Extrinsics::SIDE_BY_SIDE)
}

fn truth() -> RectifyingRotations<f64> {
    pose([0.02, -0.01, 0.03], [0.04, -0.02])
}

fn judged<T: Scalar>(seed: u64) -> Judged<T> {
    judged_of(&truth(), seed)
}

/// 128 points 3 to 80 baselines away, uniform noise of +-0.5 px, judged at their optimum.
fn judged_of<T: Scalar>(truth: &RectifyingRotations<f64>, seed: u64) -> Judged<T> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut one = || {
        let [x, y] = [rng.random_range(-0.6..0.6), rng.random_range(-0.4..0.4)];
        let p = Vector3::new(x, y, 1.0) * 3.0 * (80.0_f64 / 3.0).powf(rng.random());
        let [l, r] = [truth.left().inverse() * p, truth.right().inverse() * (p - Vector3::x())];
        let mut seen = |x: f64| T::lit(x + rng.random_range(-0.5..0.5) / FOCAL);
        let left = [seen(l.x / l.z), seen(l.y / l.z)];
        RayPair::try_new(left, [seen(r.x / r.z), seen(r.y / r.z)]).unwrap()
    };
    let pairs: Vec<RayPair<T>> = (0..128).map(|_| one()).collect();
    let batch = Batch::<T, 128>::of(&pairs);
    let start = lineage().factory;
    let mut descent = Descent::search(&Config::robust(), T::lit(FOCAL), start, 12);
    while !descent.is_done() {
        descent.advance(batch.matches()).unwrap();
    }
    let mut judged = Judged::NOTHING;
    descent.outlook().judge(batch.matches(), &mut judged).unwrap();
    judged
}

fn fused<T: Scalar>(pairs: &[Judged<T>], rounds: u32, lineage: &Lineage<T>) -> Filter<T> {
    let mut all = (0..rounds).flat_map(|_| pairs);
    let first = &all.next().unwrap().evidence;
    let mut filter = Filter::EMPTY;
    let mut advance = Advance::NONE;
    Filter::first(first, lineage, |_| Ok(()), &mut advance).unwrap();
    filter.found(first, &advance, lineage);
    for pair in all {
        add(&mut filter, pair, false, lineage);
    }
    filter
}

fn add<T: Scalar>(filter: &mut Filter<T>, pair: &Judged<T>, repeated: bool, lineage: &Lineage<T>) {
    let mut advance = Advance::NONE;
    filter.next(&pair.evidence, repeated, lineage, |_| Ok(()), &mut advance).unwrap();
    filter.take(&pair.evidence, &advance, repeated, lineage);
}

/// Difference of two poses, in what the first claims to be off.
fn gap<T: Scalar>(filter: &Filter<T>, to: &RectifyingRotations<f64>) -> f64 {
    let covariance = filter.reported(&lineage()).unwrap().matrix().map(T::to_f64);
    let e = filter.pose().extrinsics().unwrap();
    let t = e.translation().map(T::to_f64);
    let e = Extrinsics::try_new(&e.rotation().matrix().map(T::to_f64), &t).unwrap();
    let off = RectifyingRotations::from(&e).unknowns_to(to);
    off.component_div(&covariance.diagonal().map(f64::sqrt)).amax()
}

#[test]
fn the_claim_covers_the_error_of_many_pairs_and_is_not_timid() {
    let [mut sum, mut worst] = [0.0, 0.0_f64];
    for run in 0..40 {
        let pairs: Vec<Judged<f64>> = (0..25).map(|k| judged(run * 25 + k)).collect();
        let lineage = lineage();
        let filter = fused(&pairs, 1, &lineage);
        let off = filter.pose().unknowns_to(&truth());
        let squared = filter.reported(&lineage).unwrap().inverse_form(&off).unwrap();
        sum += squared / 5.0 / 40.0;
        worst = worst.max(squared);
    }
    assert!((0.7..1.3).contains(&sum) && worst < 25.0, "{sum} {worst}");
}

#[test]
fn the_same_rig_is_no_other_and_one_turned_by_a_tenth_of_a_degree_is() {
    let lineage = lineage::<f32>();
    let of = |truth: &RectifyingRotations<f64>, seeds: core::ops::Range<u64>| {
        let pairs: Vec<Judged<f32>> = seeds.map(|seed| judged_of(truth, seed)).collect();
        fused(&pairs, 1, &lineage)
    };
    let estimate = of(&truth(), 0..10);
    let turned = truth().stepped_by(&Vector5::ith(0, 0.1_f64.to_radians())).unwrap();
    for k in 1..20 {
        let same = of(&truth(), 10 * k..10 * k + 3);
        assert!(!same.departs_from(&estimate, &lineage), "{k}");
        let other = of(&turned, 10 * k..10 * k + 3);
        assert!(other.departs_from(&estimate, &lineage), "{k}");
    }
}

#[test]
fn the_order_of_pairs_hardly_matters() {
    let lineage = lineage();
    let mut pairs: Vec<Judged<f64>> = (0..40).map(judged).collect();
    let forwards = fused(&pairs, 1, &lineage);
    pairs.reverse();
    let apart = gap(&forwards, fused(&pairs, 1, &lineage).pose());
    assert!(apart < 0.01, "{apart}");
}

#[test]
fn a_repeated_pair_takes_the_place_of_the_last() {
    let lineage = lineage::<f64>();
    let [a, b, c] = [1, 2, 3].map(judged);
    let before = fused(&[a, b], 1, &lineage);
    let mut replaced = before;
    add(&mut replaced, &c, true, &lineage);
    let without = fused(&[a, c], 1, &lineage);
    assert_eq!(replaced.pairs(), 2);
    let apart = gap(&without, replaced.pose());
    assert!(apart < 1e-3, "{apart}");
    assert_eq!(replaced.scatter, before.scatter);
}

#[test]
fn a_hundred_thousand_pairs_in_f32_are_those_in_f64_and_claim_what_the_memory_holds() {
    let single: Vec<Judged<f32>> = (0..100).map(judged).collect();
    let double: Vec<Judged<f64>> = (0..100).map(judged).collect();
    let long = fused(&single, 1000, &lineage());
    assert_eq!(long.pairs(), 100_000);
    let apart = gap(&long, fused(&double, 1000, &lineage()).pose());
    assert!(apart < 0.1, "{apart}");
    let sd = |filter: &Filter<f32>| filter.information.standard_deviations().unwrap().translation;
    // What halves are compared by is as old as the rest.
    let [all, left, top] = long.halves.pitch();
    let whole = long.information.matrix().m11;
    assert!((all / whole - 1.0).abs() < 0.05, "{all} {whole}");
    assert!((0.3..0.7).contains(&(left / all)) && (0.3..0.7).contains(&(top / all)));
    // The memory holds a thousand pairs: ten times those of one round.
    let shrunk = sd(&fused(&single, 1, &lineage())) / sd(&long);
    assert!((3.0..3.4).contains(&shrunk), "{shrunk}");
}
