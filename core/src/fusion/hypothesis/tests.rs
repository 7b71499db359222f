//! Compares estimates over many pairs with their definitions and with the expected statistics.

extern crate std;

use super::*;
use crate::Extrinsics;
use crate::algebra::block_variances::BlockVariances;
use crate::batch::Batch;
use crate::batch::correspondence::RayPair;
use crate::config::Config;
use crate::geometry::rectification::tests::pose;
use crate::pair::evaluate::EvaluatedPose;
use crate::pair::solver::PairSolver;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::boxed::Box;
use std::vec::Vec;

const FOCAL: f64 = 1400.0;

pub(in crate::fusion) fn context<T: Scalar>() -> Context<'static, T> {
    const CONFIG: Config = Config::robust();
    let factory = Box::leak(Box::new(Extrinsics::SIDE_BY_SIDE));
    Context::new(&CONFIG, factory, T::lit(FOCAL))
}

pub(in crate::fusion) fn truth() -> RectifyingRotations<f64> {
    pose([0.02, -0.01, 0.03], [0.04, -0.02])
}

pub(in crate::fusion) fn evaluated<T: Scalar>(seed: u64) -> EvaluatedPose<T> {
    evaluated_at(&truth(), seed)
}

/// Returns a pair with 128 points, 3 to 80 baselines away, and uniform noise of +-0.5 px, evaluated at its optimum.
pub(in crate::fusion) fn evaluated_at<T: Scalar>(
    truth: &RectifyingRotations<f64>,
    seed: u64,
) -> EvaluatedPose<T> {
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
    let start = context().factory_pose;
    let mut solver = PairSolver::search(&Config::robust(), T::lit(FOCAL), start, 24);
    while !solver.is_done() {
        solver.advance(batch.matches()).unwrap();
    }
    let mut evaluated = EvaluatedPose::NONE;
    solver.iterate().evaluate(batch.matches(), &mut evaluated).unwrap();
    evaluated
}

pub(in crate::fusion) fn fused<T: Scalar>(
    pairs: &[EvaluatedPose<T>],
    rounds: u32,
    context: &Context<'_, T>,
) -> Hypothesis<T> {
    let mut all = (0..rounds).flat_map(|_| pairs);
    let first = &all.next().unwrap().measurement;
    let mut hypothesis = Hypothesis::EMPTY;
    let mut update = Update::NONE;
    Hypothesis::first_update(first, context, &mut update).unwrap();
    hypothesis.begin(first, &update, context);
    for pair in all {
        add(&mut hypothesis, pair, context);
    }
    hypothesis
}

fn add<T: Scalar>(
    hypothesis: &mut Hypothesis<T>,
    pair: &EvaluatedPose<T>,
    context: &Context<'_, T>,
) {
    let mut update = Update::NONE;
    hypothesis.next_update(&pair.measurement, context, &mut update).unwrap();
    hypothesis.apply(&pair.measurement, &mut update, context);
}

/// Returns the largest difference between the estimate and a pose over the unknowns, in reported standard deviations.
fn gap<T: Scalar>(hypothesis: &Hypothesis<T>, to: &RectifyingRotations<f64>) -> f64 {
    let covariance = hypothesis.reported_covariance(&context()).unwrap().matrix().map(T::to_f64);
    let e = hypothesis.pose().extrinsics().unwrap();
    let t = e.translation().map(T::to_f64);
    let e = Extrinsics::try_new(&e.rotation().matrix().map(T::to_f64), &t).unwrap();
    let off = RectifyingRotations::from(&e).unknowns_to(to);
    off.component_div(&covariance.diagonal().map(f64::sqrt)).amax()
}

impl<T: Scalar> Hypothesis<T> {
    /// Returns the hypothesis just after it has followed a drift, rad.
    pub(in crate::fusion) fn drifting(self, drift: Vector5<T>) -> Self {
        Self { drift, ..self }
    }

    /// Returns the hypothesis with the reduced chi-square of pairs that scatter by more than they report.
    pub(in crate::fusion) fn scattered(self, reduced_chi_square: T) -> Self {
        Self { reduced_chi_square, ..self }
    }
}

#[test]
fn a_drift_that_was_followed_widens_the_deviation_and_fades() {
    let context = context();
    let pairs: Vec<EvaluatedPose<f64>> = (0..30).map(evaluated).collect();
    let mut hypothesis = fused(&pairs[..10], 1, &context);
    let still = hypothesis.deviations(&context).unwrap().rotation;
    hypothesis = hypothesis.drifting(Vector5::ith(0, 10.0 * still));
    let before = hypothesis.deviations(&context).unwrap().rotation;
    assert!(before > 8.0 * still, "{before} {still}");
    for pair in &pairs[10..] {
        add(&mut hypothesis, pair, &context);
    }
    // 0.9^20 of the drift remains.
    let after = hypothesis.deviations(&context).unwrap().rotation;
    assert!((0.9..2.0).contains(&(after / still)), "{after} {still}");
}

#[test]
fn the_reported_deviation_is_that_of_the_error_over_many_pairs() {
    let [mut sum, mut worst] = [0.0, 0.0_f64];
    for run in 0..40 {
        let pairs: Vec<EvaluatedPose<f64>> = (0..25).map(|k| evaluated(run * 25 + k)).collect();
        let context = context();
        let hypothesis = fused(&pairs, 1, &context);
        let off = hypothesis.pose().unknowns_to(&truth());
        let squared = hypothesis.reported_covariance(&context).unwrap().inverse_form(&off).unwrap();
        sum += squared / 5.0 / 40.0;
        worst = worst.max(squared);
    }
    assert!((0.7..1.3).contains(&sum) && worst < 25.0, "{sum} {worst}");
}

#[test]
fn a_rig_turned_by_a_tenth_of_a_degree_departs_and_the_same_rig_does_not() {
    let context = context::<f32>();
    let of = |truth: &RectifyingRotations<f64>, seeds: core::ops::Range<u64>| {
        let pairs: Vec<EvaluatedPose<f32>> = seeds.map(|seed| evaluated_at(truth, seed)).collect();
        fused(&pairs, 1, &context)
    };
    let estimate = of(&truth(), 0..10);
    let turned = truth().stepped_by(&Vector5::ith(0, 0.1_f64.to_radians())).unwrap();
    for k in 1..20 {
        let same = of(&truth(), 10 * k..10 * k + 3);
        assert!(!same.departs_from(&estimate, &context), "{k}");
        let other = of(&turned, 10 * k..10 * k + 3);
        assert!(other.departs_from(&estimate, &context), "{k}");
    }
}

#[test]
fn another_rig_departs_further_off_where_pairs_scatter_by_more_than_they_report() {
    let context = context::<f64>();
    let pairs: Vec<EvaluatedPose<f64>> = (0..10).map(evaluated).collect();
    let estimate = fused(&pairs, 1, &context);
    // Smallest rotation, rad, in steps of 5 %, at which a rig departs.
    let first = |reduced_chi_square| {
        let estimate = estimate.scattered(reduced_chi_square);
        let departs = |angle: f64| {
            let mut other = estimate;
            other.pose = other.pose.stepped_by(&(Vector5::x() * angle)).unwrap();
            other.departs_from(&estimate, &context)
        };
        (0..200).map(|k| 1e-6 * 1.05_f64.powi(k)).find(|angle| departs(*angle)).unwrap()
    };
    let ratio = first(9.0) / first(1.0);
    assert!((2.8..3.2).contains(&ratio), "{ratio}");
}

#[test]
fn the_order_of_pairs_hardly_matters() {
    let context = context();
    let mut pairs: Vec<EvaluatedPose<f64>> = (0..40).map(evaluated).collect();
    let forwards = fused(&pairs, 1, &context);
    pairs.reverse();
    let apart = gap(&forwards, fused(&pairs, 1, &context).pose());
    assert!(apart < 0.01, "{apart}");
}

#[test]
fn a_hundred_thousand_pairs_in_f32_are_those_in_f64_and_report_the_deviation_of_the_memory() {
    let single: Vec<EvaluatedPose<f32>> = (0..100).map(evaluated).collect();
    let double: Vec<EvaluatedPose<f64>> = (0..100).map(evaluated).collect();
    let long = fused(&single, 1000, &context());
    assert_eq!(long.pairs(), 100_000);
    let apart = gap(&long, fused(&double, 1000, &context()).pose());
    assert!(apart < 0.1, "{apart}");
    let sd = |hypothesis: &Hypothesis<f32>| {
        hypothesis.information.standard_deviations().unwrap().translation
    };
    // The sums of the halves fade like the sums of the whole image.
    let [all, left, top] = long.halves.pitch();
    let whole = long.information.matrix().m11;
    assert!((all / whole - 1.0).abs() < 0.05, "{all} {whole}");
    assert!((0.3..0.7).contains(&(left / all)) && (0.3..0.7).contains(&(top / all)));
    // The memory holds a thousand pairs, ten times the pairs of one round, so the deviation shrinks by `sqrt 10`.
    let shrunk = sd(&fused(&single, 1, &context())) / sd(&long);
    assert!((3.0..3.4).contains(&shrunk), "{shrunk}");
}

#[test]
fn the_optimum_is_where_the_slope_of_sums_and_prior_vanishes() {
    let context = context::<f64>();
    let pairs: Vec<EvaluatedPose<f64>> = (0..10).map(evaluated).collect();
    let hypothesis = fused(&pairs, 1, &context);
    let seen = hypothesis.normal_equations(&hypothesis.sums);
    let slope =
        seen.gradient - hypothesis.pose().unknowns_to(&context.factory_pose) * context.prior;
    let off = slope.component_div(&hypothesis.information.matrix().diagonal().map(f64::sqrt));
    // The last step leaves an error of the order of its squared length.
    assert!(off.amax() < 1e-3, "{off}");
}

#[test]
fn nis_and_reduced_chi_square_of_consistent_pairs_match_chance() {
    let context = context::<f64>();
    let pairs: Vec<EvaluatedPose<f64>> = (0..400).map(evaluated).collect();
    let (known, fresh) = pairs.split_at(100);
    let hypothesis = fused(known, 1, &context);
    let [mut plain, mut nis, mut beyond] = [0.0; 3];
    for pair in fresh {
        let measurement = &pair.measurement;
        let seen = measurement.biased_at(hypothesis.pose()).normal.with_prior(context.prior);
        let (step, covariance) = seen.optimum().unwrap();
        let both = covariance.plus(&hypothesis.covariance(&context).unwrap());
        plain += both.inverse_form(&step).unwrap() / 300.0;
        let squared = hypothesis.innovation(measurement, &context).unwrap();
        nis += squared / 300.0;
        // The 95th percentile of chi-square with five degrees of freedom.
        beyond += f64::from(squared > 11.07) / 300.0;
    }
    // The expected value is about 5 for five degrees of freedom, although the noise is uniform. The allowance for
    // vibration lowers the NIS.
    assert!((3.5..5.5).contains(&plain), "{plain}");
    assert!((1.5..plain).contains(&nis) && beyond < 0.05, "{nis} {beyond}");
    let reduced = hypothesis.reduced_chi_square;
    assert!((0.7..1.3).contains(&reduced), "{reduced}");
}

/// Returns a pair of random correspondences, evaluated at the factory extrinsics, and extrinsics in use that are far
/// off.
fn badly_determined(seed: u64) -> Option<(EvaluatedPose<f64>, Extrinsics<f64>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (size, count) = (0.5_f64 * 0.003_f64.powf(rng.random()), rng.random_range(12..40));
    let mut any = |most: f64| rng.random_range(-most..most);
    let (at, depth, noise) = ([any(0.5), any(0.3), any(0.3)], any(0.2).abs(), any(0.01).abs());
    let one = |_| {
        let [x, y] = [at[0] + any(size), at[1] + any(size)];
        let right = [x - depth + any(depth + 0.001), y + at[2] + any(noise + 1e-6)];
        RayPair::try_new([x, y], right).unwrap()
    };
    let pairs: Vec<RayPair<f64>> = (0..count).map(one).collect();
    let batch = Batch::<f64, 40>::of(&pairs);
    let solver = PairSolver::search(&Config::robust(), FOCAL, context().factory_pose, 12);
    let mut evaluated = EvaluatedPose::NONE;
    solver.iterate().evaluate(batch.matches(), &mut evaluated).ok()?;
    let in_use = pose([any(0.3), any(0.3), any(0.3)], [any(0.4), any(0.4)]).extrinsics().unwrap();
    Some((evaluated, in_use))
}

/// Fits `R` to the baseline in use. Returns whether the fit is better than the extrinsics in use over sums and prior,
/// whether it is not clearly worse over the sums alone, and whether it may be in use. `None` without a fit.
fn fit_to_baseline_in_use(seed: u64) -> Option<[bool; 3]> {
    let (evaluated, in_use) = badly_determined(seed)?;
    let context = context::<f64>();
    let mut update = Update::NONE;
    Hypothesis::first_update(&evaluated.measurement, &context, &mut update).ok()?;
    let mut hypothesis = Hypothesis::EMPTY;
    hypothesis.begin(&evaluated.measurement, &update, &context);
    let rows = RectifyingRotations::from(&in_use).into();
    let fit = hypothesis.with_baseline_of(&rows, in_use.translation(), &context)?;
    let [found, in_use] = [&fit, &in_use].map(RectifyingRotations::from);
    let cost = |pose: &_| hypothesis.sums.in_frame_of(&hypothesis.frame).cost_at(pose);
    let prior = |pose: &RectifyingRotations<f64>| {
        context.prior * pose.unknowns_to(&context.factory_pose).norm_squared()
    };
    let joint = |pose: &_| cost(pose) + prior(pose);
    let most = IMPROVEMENT * IMPROVEMENT;
    let is_better = joint(&found) <= joint(&in_use);
    Some([is_better, cost(&in_use) >= cost(&found) * most, context.allows_in_use(&fit)])
}

#[test]
fn rotation_with_the_baseline_in_use_has_the_prior_and_is_left_where_the_descent_fails() {
    // With the seeds 4641 and 8013 the fit is clearly worse than the extrinsics in use; with 929 and 931 it is beyond
    // the limit.
    let found: Vec<_> = (4400..4800).chain([929, 931, 8013]).map(fit_to_baseline_in_use).collect();
    let fits: Vec<_> = found.into_iter().flatten().collect();
    let better = fits.iter().filter(|[better, ..]| *better).count();
    assert!(fits.len() > 390 && better + 2 > fits.len(), "{better} of {}", fits.len());
    assert!(fits.iter().all(|[_, not_worse, allowed]| *not_worse && *allowed));
}

#[test]
fn sums_have_their_optimum_at_the_estimate_while_cameras_turn_and_after() {
    let rigid = context::<f64>();
    let both = 4e-6;
    let turning = rigid.vibrating(BlockVariances { rotation: both, baseline: both });
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    // The hypothesis starts 0.2 degrees off the mean, and the estimate moves to the mean later.
    let mut hypothesis = fused(&[at(4e-3, 0)], 1, &turning);
    let (mut farthest, mut last_turning) = ([0.0_f64; 2], 0.0);
    for seed in 1..80 {
        let turns = seed < 40;
        let shake = if turns { rng.random_range(-3e-3..3e-3) } else { 0.0 };
        let context = if turns { &turning } else { &rigid };
        add(&mut hypothesis, &at(shake, seed), context);
        assert_eq!(hypothesis.mode.is_turning(), turns, "{seed}");
        if turns {
            last_turning = hypothesis.deviations(context).unwrap().rotation;
        }
        if seed > 20 {
            let far = &mut farthest[usize::from(!turns)];
            *far = far.max(optimum_of_sums_off_estimate(&hypothesis));
        }
    }
    // The estimate improves once the rotations cease, but the moments of the earlier pairs are not transformed again.
    let [turning, after] = farthest;
    assert!(turning < 1e-6 && after < 2.0 * last_turning, "{farthest:?} {last_turning}");
}

/// Returns a pair of a rig turned by `turned` rad about `x`.
pub(super) fn at(turned: f64, seed: u64) -> EvaluatedPose<f64> {
    evaluated_at(&truth().stepped_by(&Vector5::ith(0, turned)).unwrap(), seed)
}

/// Returns the rotation about `x`, rad, between the optimum of the sums and the pose of the rig at rest that
/// corresponds to the estimate.
fn optimum_of_sums_off_estimate(hypothesis: &Hypothesis<f64>) -> f64 {
    let pose = hypothesis.pose_at_rest(hypothesis.pose()).unwrap();
    let step = hypothesis.sums.in_frame_of(&hypothesis.frame).debiased_at(&pose).step().unwrap();
    step[0].abs()
}

#[test]
fn a_drift_is_limited_once_and_keeps_its_direction() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..1000 {
        let drift = Vector5::from_fn(|_, _| rng.random_range(-0.3_f32..0.3));
        let once = limited(&drift);
        assert_eq!(once, limited(&once));
        assert!(once.amax() <= 0.12001 && once.normalize().dot(&drift.normalize()) > 0.9999);
        assert!(drift.amax() > 0.12 || once == drift);
    }
}
