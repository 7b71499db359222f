//! One hypothesis about the rig: the sums of the pairs that agree with it, and its optimum over them.

use nalgebra::Vector5;

use super::Lineage;
use super::halves::Halves;
use crate::error::Refusal;
use crate::extrinsics::Extrinsics;
use crate::information::{Information, StandardDeviations};
use crate::moments::Moments;
use crate::quadratic::Quadratic;
use crate::rectification::RectifyingRotations;
use crate::robust::{Evidence, Judged, Known};
use crate::scalar::Scalar;
use crate::symmetric::Symmetric;

/// Gauss-Newton steps to the optimum of all sums: each squares the error of the linearisation.
const STEPS: usize = 3;

/// A step is the last one if what it leaves is below rounding: its square, rad^2.
const LAST_STEP: f64 = 1e-8;

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

/// Expected error above which nothing is locked, rad.
const MAX_LOCKED_SD: f64 = 0.12;

/// What is left of a drift after each further pair.
const DRIFT_FADES: f64 = 0.9;

/// Sums over the pairs that agree, and their optimum.
#[derive(Debug, Clone, Copy, PartialEq)]
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

/// One more pair, and where it leads.
#[derive(Debug)]
pub(super) struct Advance<T: Scalar> {
    /// Its sums, in the filter's frame.
    last: Moments<T>,
    found: Optimum<T>,
}

/// The optimum of sums and the prior, and the information of the sums there.
#[derive(Debug)]
struct Optimum<T: Scalar> {
    pose: RectifyingRotations<T>,
    information: Information<T>,
}

impl<T: Scalar> Advance<T> {
    pub(super) const NONE: Self = Self {
        last: Moments::ZERO,
        found: Optimum { pose: RectifyingRotations::SIDE_BY_SIDE, information: Information::ZERO },
    };
}

impl<T: Scalar> Filter<T> {
    /// No pairs yet: to be founded.
    pub(super) const EMPTY: Self = Self {
        pose: RectifyingRotations::SIDE_BY_SIDE,
        frame: RectifyingRotations::SIDE_BY_SIDE,
        settled: Moments::ZERO,
        last: Moments::ZERO,
        halves: Halves::NONE,
        information: Information::ZERO,
        noise: T::ZERO,
        share: T::ZERO,
        scatter: T::ONE,
        drift: Vector5::new(T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO),
        pairs: 0,
    };

    /// Where a first pair leads: into `advance`.
    ///
    /// * `allowed`: whether an estimate may be at a pose.
    ///
    /// # Errors
    /// [`Refusal`]: to no rig, or where it may not be.
    #[inline(never)]
    pub(super) fn first(
        evidence: &Evidence<T>,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
        advance: &mut Advance<T>,
    ) -> Result<(), Refusal> {
        advance.last = evidence.moments;
        advance.found.pose = evidence.pose;
        advance.found.descend(&advance.last, &evidence.pose, lineage)?;
        allowed(&advance.found.pose)
    }

    /// Takes in a first pair.
    #[inline(never)]
    pub(super) fn found(
        &mut self,
        evidence: &Evidence<T>,
        advance: &Advance<T>,
        lineage: &Lineage<T>,
    ) {
        let Advance { last, found } = advance;
        (self.pose, self.information) = (found.pose, found.information);
        self.frame = evidence.pose;
        self.last = *last;
        (self.noise, self.share) = (evidence.noise, evidence.share);
        self.pairs = 1;
        let to_pose = self.frame.unknowns_to(&self.pose);
        self.halves.add(evidence, &to_pose, false, lineage);
    }

    /// Where one more pair leads: into `advance`.
    ///
    /// * `repeated`: the scene is that of the last pair, which it replaces.
    /// * `allowed`: whether the estimate may be at a pose.
    ///
    /// # Errors
    /// [`Refusal`]: to no rig, or where it may not be.
    #[inline(never)]
    pub(super) fn next(
        &self,
        evidence: &Evidence<T>,
        repeated: bool,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
        advance: &mut Advance<T>,
    ) -> Result<(), Refusal> {
        let Advance { last, found } = advance;
        *last = evidence.moments;
        last.turn(&evidence.pose, &self.frame);
        let mut sums = self.settled;
        if !repeated {
            sums.add(&self.last);
            sums.scale(self.fading(lineage));
        }
        sums.add(last);
        found.pose = self.pose;
        found.descend(&sums, &self.frame, lineage)?;
        allowed(&found.pose)
    }

    /// Takes in one more pair; how the pose has moved.
    #[inline(never)]
    pub(super) fn take(
        &mut self,
        evidence: &Evidence<T>,
        advance: &Advance<T>,
        repeated: bool,
        lineage: &Lineage<T>,
    ) -> Vector5<T> {
        if !repeated {
            self.note_scatter(evidence, lineage);
            self.settled.add(&self.last);
            self.settled.scale(self.fading(lineage));
            self.pairs = self.pairs.saturating_add(1);
            self.drift *= T::lit(DRIFT_FADES);
        }
        let Advance { last, found } = advance;
        self.last = *last;
        let gain = T::ONE / T::count(self.pairs.min(50));
        self.noise += (evidence.noise - self.noise) * gain;
        self.share += (evidence.share - self.share) * gain;
        let moved = self.pose.unknowns_to(&found.pose);
        (self.pose, self.information) = (found.pose, found.information);
        match self.deviations(lineage) {
            Some(sd) => self.halves.follow(&moved, &sd, lineage),
            None => self.halves = Halves::NONE,
        }
        let to_pose = evidence.pose.unknowns_to(&self.pose);
        self.halves.add(evidence, &to_pose, repeated, lineage);
        moved
    }

    /// What one more pair leaves of the older ones.
    fn fading(&self, lineage: &Lineage<T>) -> T {
        if self.pairs >= lineage.memory { lineage.fading() } else { T::ONE }
    }

    /// Takes its sums into the frame of its pose: what is far from its frame loses digits.
    #[inline(never)]
    pub(super) fn reframe(&mut self) {
        self.settled.turn(&self.frame, &self.pose);
        self.last.turn(&self.frame, &self.pose);
        self.frame = self.pose;
    }

    /// Replaces the sums over all pairs but the last, as if there had been no others; whether they lead
    /// to a rig that may be, or else nothing has changed.
    #[inline(never)]
    pub(super) fn replace(
        &mut self,
        settled: &Moments<T>,
        pairs: u32,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
    ) -> bool {
        let mut sums = *settled;
        sums.add(&self.last);
        let mut found = Optimum { pose: self.pose, information: Information::ZERO };
        let descended = found.descend(&sums, &self.frame, lineage);
        if descended.and_then(|()| allowed(&found.pose)).is_err() {
            return false;
        }
        self.drift = self.pose.unknowns_to(&found.pose);
        (self.pose, self.information) = (found.pose, found.information);
        self.settled = *settled;
        self.pairs = pairs;
        self.halves = Halves::NONE;
        self.reframe();
        true
    }

    fn sums(&self) -> Moments<T> {
        let mut sums = self.settled;
        sums.add(&self.last);
        sums
    }

    pub(crate) fn pose(&self) -> &RectifyingRotations<T> {
        &self.pose
    }

    /// Information and slope, at the pose, of sums in the filter's frame.
    pub(super) fn see(&self, sums: &Moments<T>) -> Quadratic<T> {
        sums.seen_at(&self.frame, &self.pose)
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
    #[inline(never)]
    fn covariance(&self, lineage: &Lineage<T>) -> Option<Symmetric<T>> {
        let mut joint = self.information.0;
        joint.add_diagonal(lineage.prior);
        let mut covariance = joint.inverse()?.scaled(self.halves.widened());
        covariance.add_outer(T::ONE, &self.drift.into());
        Some(covariance)
    }

    /// Covariance as it is reported: widened by what the pairs scatter as well.
    pub(crate) fn reported(&self, lineage: &Lineage<T>) -> Option<Symmetric<T>> {
        Some(self.covariance(lineage)?.scaled(self.scatter()))
    }

    /// Expected size of the error.
    pub(super) fn deviations(&self, lineage: &Lineage<T>) -> Option<StandardDeviations<T>> {
        Some(StandardDeviations::of(&self.reported(lineage)?))
    }

    /// Whether it is certain enough to be relied on.
    pub(super) fn is_certain(&self, lineage: &Lineage<T>) -> bool {
        let most = T::lit(MAX_LOCKED_SD);
        let certain = |sd: StandardDeviations<T>| sd.rotation <= most && sd.translation <= most;
        self.deviations(lineage).is_some_and(certain)
    }

    /// The optimum among the rigs with a given baseline: what is left of an estimate whose own baseline
    /// is not believed.
    #[inline(never)]
    pub(crate) fn with_baseline_of(&self, given: &Extrinsics<T>) -> Option<Extrinsics<T>> {
        let sums = self.sums();
        let target = RectifyingRotations::from(given);
        let mut pose = self.pose;
        for _ in 0..STEPS {
            let mut seen = sums.seen_at(&self.frame, &pose);
            let to_target = pose.unknowns_to(&target);
            let across = Vector5::new(T::ZERO, T::ZERO, T::ZERO, to_target.w, to_target.a);
            seen = seen.about(&across);
            let d = seen.rotation_alone().step()? + across;
            pose = pose.stepped_by(&d)?;
        }
        Extrinsics::try_new(pose.extrinsics().ok()?.rotation().matrix(), given.translation()).ok()
    }

    /// What a pair is tracked from: the estimate, and some freedom.
    pub(super) fn known(&self, lineage: &Lineage<T>) -> Option<Known<T>> {
        let mut covariance = self.covariance(lineage)?;
        covariance.add_diagonal(T::lit(FREEDOM * FREEDOM));
        Some(Known { pose: self.pose, covariance, noise: self.noise })
    }

    /// Distance of a pair from the estimate, squared, over its expected size.
    #[inline(never)]
    fn surprise(&self, evidence: &Evidence<T>, lineage: &Lineage<T>) -> Option<T> {
        let (step, covariance) = evidence.seen_at(&self.pose).pulled(lineage.prior).optimum()?;
        let mut both = covariance.plus(&self.covariance(lineage)?);
        both.add_diagonal(T::lit(VIBRATION * VIBRATION));
        both.inverse_form(&step)
    }

    /// Distance of a pair that was tracked from here, over the scatter of pairs; `None` if it disagrees.
    pub(super) fn agreement(
        &self,
        judged: &Judged<T>,
        slack: T,
        lineage: &Lineage<T>,
    ) -> Option<T> {
        let alike = judged.has_peak() && judged.evidence.share >= T::lit(MIN_SHARE) * self.share;
        if !alike {
            return None;
        }
        let surprise = self.surprise(&judged.evidence, lineage)? / self.scatter();
        (surprise < T::lit(MAX_SURPRISE) * slack).then_some(surprise)
    }

    /// Whether this is the optimum of another rig, and not one that weak pairs have missed.
    pub(super) fn departs_from(&self, other: &Self, lineage: &Lineage<T>) -> bool {
        let covariances = self.covariance(lineage).zip(other.covariance(lineage));
        let apart = self.pose.unknowns_to(&other.pose);
        covariances
            .and_then(|(a, b)| a.plus(&b).inverse_form(&apart))
            .is_some_and(|distance| distance > T::lit(MAX_SURPRISE) * other.scatter())
    }

    /// Distance of this pair from the last: neither knows the estimate, which may be wrong.
    #[inline(never)]
    fn note_scatter(&mut self, evidence: &Evidence<T>, lineage: &Lineage<T>) {
        let pair = evidence.seen_at(&self.pose).pulled(lineage.prior);
        let last = self.see(&self.last).pulled(lineage.prior);
        if let Some(distance) = pair.distance(&last) {
            let per_freedom = (distance / T::lit(5.0)).min(T::lit(MAX_SCATTER));
            // As if four pairs had scattered as they should.
            let gain = T::ONE / (T::count(self.pairs.min(50)) + T::lit(4.0));
            self.scatter += (per_freedom - self.scatter) * gain;
        }
    }
}

impl<T: Scalar> Optimum<T> {
    /// Goes there from the pose it is at.
    ///
    /// # Errors
    /// [`Refusal::NoRig`].
    #[inline(never)]
    fn descend(
        &mut self,
        sums: &Moments<T>,
        frame: &RectifyingRotations<T>,
        lineage: &Lineage<T>,
    ) -> Result<(), Refusal> {
        for _ in 0..STEPS {
            let step = self.step(sums, frame, lineage).ok_or(Refusal::NoRig)?;
            if step.norm_squared() <= T::lit(LAST_STEP) {
                break;
            }
        }
        self.pose.extrinsics().map(|_| ()).map_err(|_| Refusal::NoRig)
    }

    /// Takes one Gauss-Newton step; the information is that from where it starts.
    #[inline(never)]
    fn step(
        &mut self,
        sums: &Moments<T>,
        frame: &RectifyingRotations<T>,
        lineage: &Lineage<T>,
    ) -> Option<Vector5<T>> {
        let mut seen = sums.seen_at(frame, &self.pose);
        self.information = seen.information;
        seen.information.0.add_diagonal(lineage.prior);
        seen.gradient -= self.pose.unknowns_to(&lineage.factory) * lineage.prior;
        let step = seen.step()?;
        self.pose = self.pose.stepped_by(&step)?;
        Some(step)
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
        let start = lineage().factory;
        let mut descent = Descent::search(&Config::robust(), T::lit(FOCAL), start, 12);
        while !descent.is_done() {
            descent.advance(&pairs).unwrap();
        }
        let mut judged = Judged::NOTHING;
        descent.outlook().judge(&pairs, &mut judged).unwrap();
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

    fn add<T: Scalar>(
        filter: &mut Filter<T>,
        pair: &Judged<T>,
        repeated: bool,
        lineage: &Lineage<T>,
    ) {
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
