//! One hypothesis about the rig: the sums of the pairs that agree with it, and its optimum over them.

use nalgebra::{Matrix5, Vector5};

use super::Lineage;
use super::halves::Halves;
use crate::extrinsics::Extrinsics;
use crate::information::{Information, StandardDeviations};
use crate::moments::Moments;
use crate::quadratic::squared_over;
use crate::rectification::RectifyingRotations;
use crate::robust::{Judged, Known};
use crate::scalar::Scalar;

/// Gauss-Newton steps to the optimum of all sums: each squares the error of the linearisation.
const STEPS: usize = 3;

/// A pair agrees if its distance from the estimate, squared, is below this in units of the scatter:
/// chance is 4e-5 for one that tells the truth.
const MAX_SURPRISE: f64 = 28.0;

/// Part of the usual share of inliers that a pair must have.
const MIN_SHARE: f64 = 0.5;

/// What a rig may move from one pair to the next without being another one, rad (0.005 degrees).
const VIBRATION: f64 = 8.7e-5;

/// What a pair may differ from the estimate it is tracked from, rad (0.05 degrees).
const FREEDOM: f64 = 8.7e-4;

/// Scatter of the pairs beyond which more is not believed: real lenses leave 3 to 10.
const MAX_SCATTER: f64 = 16.0;

/// What is left of a drift after each further pair.
const DRIFT_FADES: f64 = 0.9;

/// Sums over the pairs that agree, and their optimum.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Filter<T: Scalar> {
    pose: RectifyingRotations<T>,
    /// Where the sums were begun: their frame.
    frame: RectifyingRotations<T>,
    /// Over all pairs but the last, which a repeated scene replaces.
    settled: Moments<T>,
    last: Moments<T>,
    halves: Halves<T>,
    /// Of all sums at the pose, without the prior.
    information: Information<T>,
    /// Running means: noise of a coordinate, px; share of inliers; distance of one pair from the next,
    /// squared, per degree of freedom.
    noise: T,
    share: T,
    scatter: T,
    /// How far the older pairs were from those that replaced them, fading: a rig that has begun to drift
    /// goes on.
    drift: Vector5<T>,
    pairs: u32,
}

impl<T: Scalar> Filter<T> {
    /// Of one pair; `None` if it leads to no rig.
    pub(super) fn born(judged: &Judged<T>, lineage: &Lineage<T>) -> Option<Self> {
        let evidence = &judged.evidence;
        let born = Self {
            pose: evidence.pose,
            frame: evidence.pose,
            settled: Moments::ZERO,
            last: evidence.moments,
            halves: Halves::NONE,
            information: Information::ZERO,
            noise: evidence.noise,
            share: evidence.share,
            scatter: T::ONE,
            drift: Vector5::zeros(),
            pairs: 1,
        };
        let mut born = born.solved(lineage)?;
        let to_pose = evidence.pose.unknowns_to(&born.pose);
        born.halves = Halves::NONE.with(&evidence.parts, &to_pose, false, lineage);
        Some(born)
    }

    /// With one more pair; `None` if it leads to no rig.
    ///
    /// * `repeated`: the scene is that of the last pair, which it replaces.
    pub(super) fn with(
        &self,
        judged: &Judged<T>,
        repeated: bool,
        lineage: &Lineage<T>,
    ) -> Option<Self> {
        let evidence = &judged.evidence;
        let moments = evidence.moments.turned(&evidence.pose, &self.frame);
        let mut next = self.clone();
        if !repeated {
            next.note_scatter(judged, lineage);
            next.settled.add(&self.last);
            if self.pairs >= lineage.memory {
                next.settled = next.settled.scaled(lineage.fading());
            }
            next.pairs = self.pairs.saturating_add(1);
            next.drift *= T::lit(DRIFT_FADES);
        }
        next.last = moments;
        let gain = T::ONE / T::count(next.pairs.min(50));
        next.noise += (evidence.noise - self.noise) * gain;
        next.share += (evidence.share - self.share) * gain;
        let mut next = next.solved(lineage)?;
        let moved = self.pose.unknowns_to(&next.pose);
        let to_pose = evidence.pose.unknowns_to(&next.pose);
        let sd = next.deviations(lineage)?;
        let halves = next.halves.moved(&moved, &sd, lineage);
        next.halves = halves.with(&evidence.parts, &to_pose, repeated, lineage);
        Some(next)
    }

    /// With its sums in the frame of its pose: what is far from its frame loses digits.
    pub(super) fn reframed(mut self) -> Self {
        self.settled = self.settled.turned(&self.frame, &self.pose);
        self.last = self.last.turned(&self.frame, &self.pose);
        self.frame = self.pose;
        self
    }

    /// With the sums over all pairs but the last replaced, as if there had been no others.
    pub(super) fn replaced(
        &self,
        settled: &Moments<T>,
        pairs: u32,
        lineage: &Lineage<T>,
    ) -> Option<Self> {
        let mut next = self.clone();
        next.settled = *settled;
        next.pairs = pairs;
        next.halves = Halves::NONE;
        let mut next = next.solved(lineage)?;
        next.drift = self.pose.unknowns_to(&next.pose);
        Some(next.reframed())
    }

    fn solved(mut self, lineage: &Lineage<T>) -> Option<Self> {
        let sums = self.sums();
        for _ in 0..STEPS {
            let seen = sums.seen_at(&self.frame, &self.pose);
            let pull = lineage.prior.times(&self.pose.unknowns_to(&lineage.factory));
            let mut joint = seen.with(&lineage.prior);
            joint.gradient -= pull;
            self.pose = self.pose.stepped_by(&joint.step()?)?;
        }
        self.information = sums.seen_at(&self.frame, &self.pose).information;
        self.pose.extrinsics().ok()?;
        Some(self)
    }

    fn sums(&self) -> Moments<T> {
        let mut sums = self.settled;
        sums.add(&self.last);
        sums
    }

    pub(crate) fn pose(&self) -> &RectifyingRotations<T> {
        &self.pose
    }

    pub(super) fn last(&self) -> &Moments<T> {
        &self.last
    }

    pub(crate) fn pairs(&self) -> u32 {
        self.pairs
    }

    /// Scatter of the pairs over what they claim, at least 1.
    pub(super) fn scatter(&self) -> T {
        self.scatter.max(T::ONE)
    }

    /// Disagreement of image halves, in standard deviations per degree of freedom.
    pub(crate) fn halves(&self) -> T {
        self.halves.disagreement()
    }

    /// Covariance of the estimate, rad^2, widened by what the halves of the image disagree and along
    /// the drift.
    fn covariance(&self, lineage: &Lineage<T>) -> Option<Matrix5<T>> {
        let mut joint = self.information;
        joint.add(&lineage.prior);
        Some(joint.covariance()? * self.halves.widened() + self.drift * self.drift.transpose())
    }

    /// Covariance as it is reported: widened by what the pairs scatter as well.
    pub(crate) fn reported(&self, lineage: &Lineage<T>) -> Option<Matrix5<T>> {
        Some(self.covariance(lineage)? * self.scatter())
    }

    /// Expected size of the error.
    pub(super) fn deviations(&self, lineage: &Lineage<T>) -> Option<StandardDeviations<T>> {
        Some(StandardDeviations::of(&self.reported(lineage)?))
    }

    /// The optimum among the rigs with a given baseline: what is left of an estimate whose own baseline
    /// is not believed.
    pub(crate) fn with_baseline_of(&self, given: &Extrinsics<T>) -> Option<Extrinsics<T>> {
        let sums = self.sums();
        let target = RectifyingRotations::from(given);
        let mut pose = self.pose;
        for _ in 0..STEPS {
            let seen = sums.seen_at(&self.frame, &pose);
            let mut d = pose.unknowns_to(&target);
            let across = Vector5::new(T::ZERO, T::ZERO, T::ZERO, d.w, d.a);
            let pull = seen.about(&across).gradient;
            let rotation = seen.information.matrix().fixed_view::<3, 3>(0, 0).into_owned();
            let turn = rotation.cholesky()?.solve(&-pull.fixed_rows::<3>(0));
            d.fixed_rows_mut::<3>(0).copy_from(&turn);
            pose = pose.stepped_by(&d)?;
        }
        Extrinsics::try_new(pose.extrinsics().ok()?.rotation().matrix(), given.translation()).ok()
    }

    /// What a pair is tracked from: the estimate, and some freedom.
    pub(super) fn known(&self, lineage: &Lineage<T>) -> Option<Known<T>> {
        let freedom = Matrix5::from_diagonal_element(T::lit(FREEDOM * FREEDOM));
        Some(Known {
            pose: self.pose,
            covariance: self.covariance(lineage)? + freedom,
            noise: self.noise,
        })
    }

    /// Distance of a pair from the estimate, squared, over its expected size.
    pub(super) fn surprise(&self, judged: &Judged<T>, lineage: &Lineage<T>) -> Option<T> {
        let pair = judged.evidence.seen_at(&self.pose).with(&lineage.prior);
        let shaken = Matrix5::from_diagonal_element(T::lit(VIBRATION * VIBRATION));
        let covariance = pair.information.covariance()? + self.covariance(lineage)? + shaken;
        squared_over(&pair.step()?, covariance)
    }

    /// Whether a pair tracked from here agrees.
    pub(super) fn agrees(&self, judged: &Judged<T>, slack: T, lineage: &Lineage<T>) -> bool {
        let limit = T::lit(MAX_SURPRISE) * self.scatter() * slack;
        judged.has_peak()
            && judged.evidence.share >= T::lit(MIN_SHARE) * self.share
            && self.surprise(judged, lineage).is_some_and(|surprise| surprise < limit)
    }

    /// Whether this is the optimum of another rig, and not one that weak pairs have missed.
    pub(super) fn departs_from(&self, other: &Self, lineage: &Lineage<T>) -> bool {
        let covariances = self.covariance(lineage).zip(other.covariance(lineage));
        let apart = self.pose.unknowns_to(&other.pose);
        covariances
            .and_then(|(a, b)| squared_over(&apart, a + b))
            .is_some_and(|distance| distance > T::lit(MAX_SURPRISE) * other.scatter())
    }

    /// Distance of this pair from the last: neither knows the estimate, which may be wrong.
    fn note_scatter(&mut self, judged: &Judged<T>, lineage: &Lineage<T>) {
        let pair = judged.evidence.seen_at(&self.pose).with(&lineage.prior);
        let last = self.last.seen_at(&self.frame, &self.pose).with(&lineage.prior);
        if let Some(distance) = pair.distance(&last) {
            let per_freedom = (distance / T::lit(5.0)).min(T::lit(MAX_SCATTER));
            // As if four pairs had scattered as they should.
            let gain = T::ONE / (T::count(self.pairs.min(50)) + T::lit(4.0));
            self.scatter += (per_freedom - self.scatter) * gain;
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
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

    /// 128 points 3 to 80 baselines away, uniform noise of +-0.5 px, judged at their optimum.
    fn judged<T: Scalar>(seed: u64) -> Judged<T> {
        let truth = truth();
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
        let start = lineage().factory;
        let mut descent = Descent::search(&Config::robust(), T::lit(FOCAL), start, 12);
        while !descent.is_done() {
            descent.advance(&pairs).unwrap();
        }
        descent.judge(&pairs).unwrap()
    }

    fn fused<T: Scalar>(pairs: &[Judged<T>], rounds: u32, lineage: &Lineage<T>) -> Filter<T> {
        let mut all = (0..rounds).flat_map(|_| pairs);
        let first = Filter::born(all.next().unwrap(), lineage).unwrap();
        all.fold(first, |filter, pair| filter.with(pair, false, lineage).unwrap())
    }

    /// Difference of two poses, in what the first claims to be off.
    fn gap<T: Scalar>(filter: &Filter<T>, to: &RectifyingRotations<f64>) -> f64 {
        let covariance = filter.reported(&lineage()).unwrap().map(T::to_f64);
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
            let squared = squared_over(&off, filter.reported(&lineage).unwrap()).unwrap();
            sum += squared / 5.0 / 40.0;
            worst = worst.max(squared);
        }
        assert!((0.7..1.3).contains(&sum) && worst < 25.0, "{sum} {worst}");
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
        let before = Filter::born(&a, &lineage).unwrap().with(&b, false, &lineage).unwrap();
        let replaced = before.with(&c, true, &lineage).unwrap();
        let without = Filter::born(&a, &lineage).unwrap().with(&c, false, &lineage).unwrap();
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
        let sd =
            |filter: &Filter<f32>| filter.information.standard_deviations().unwrap().translation;
        // What halves are compared by is as old as the rest.
        let [all, left, top] = long.halves.pitch();
        let whole = long.information.matrix().m11;
        assert!((all / whole - 1.0).abs() < 0.05, "{all} {whole}");
        assert!((0.3..0.7).contains(&(left / all)) && (0.3..0.7).contains(&(top / all)));
        // The memory holds a thousand pairs: ten times those of one round.
        let shrunk = sd(&fused(&single, 1, &lineage())) / sd(&long);
        assert!((3.0..3.4).contains(&shrunk), "{shrunk}");
    }
}
