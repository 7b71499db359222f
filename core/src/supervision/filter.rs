//! One hypothesis about the rig: the sums of the pairs that agree with it, and its optimum over them.

mod memory;

use nalgebra::Vector5;

use super::Lineage;
use super::halves::Halves;
use super::optimum::{Optimum, STEPS};
use crate::error::Refusal;
use crate::extrinsics::Extrinsics;
use crate::information::{Information, StandardDeviations};
use crate::moments::Moments;
use crate::quadratic::Quadratic;
use crate::rectification::RectifyingRotations;
use crate::robust::{Evidence, Judged, Known};
use crate::scalar::Scalar;
use crate::symmetric::Symmetric;

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

impl<T: Scalar> Advance<T> {
    pub(super) const NONE: Self = Self { last: Moments::ZERO, found: Optimum::NONE };
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
        let mut found = Optimum { pose: self.pose, ..Optimum::NONE };
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

#[cfg(test)]
mod tests;
