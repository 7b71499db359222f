//! What the halves of the image say, each for itself: matches that are biased alike in one region pull
//! the estimate, and no residual tells.

use nalgebra::Vector5;

use super::Lineage;
use crate::codec::{Reader, Writer};
use crate::error::RestoreError;
use crate::information::StandardDeviations;
use crate::quadratic::Quadratic;
use crate::robust::Evidence;
use crate::scalar::Scalar;

/// Disagreement that healthy scenes stay below: chance is 1e-3 an axis.
const HEALTHY: f64 = 2.0;

/// What models of the first order may be wrong by, in deviations of the estimate.
const NEAR: f64 = 0.1;

/// More disagreement than this is not told apart: its square must not overflow.
const LARGEST: f64 = 1e4;

/// Sums over the image halves, about the pose of the estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Halves<T> {
    /// Of the whole image, its left and its upper half.
    parts: [Quadratic<T>; 3],
    /// Pairs in the sums, and those of them that did not repeat a scene: repetition cannot average out
    /// what it repeats, but it shows it.
    heard: [u32; 2],
    /// `sqrt(chi^2 / 5)` between the estimates of the halves, the worse axis.
    disagreement: T,
}

impl<T: Scalar> Halves<T> {
    pub(super) const NONE: Self =
        Self { parts: [Quadratic::ZERO; 3], heard: [0; 2], disagreement: T::ZERO };

    /// After the pose has moved; `sd`: of the estimate. First-order models from before a long way are
    /// dropped.
    pub(super) fn follow(
        &mut self,
        moved: &Vector5<T>,
        sd: &StandardDeviations<T>,
        lineage: &Lineage<T>,
    ) {
        let turn = moved.fixed_rows::<3>(0).norm();
        let shift = moved.fixed_rows::<2>(3).norm();
        let near = T::lit(NEAR);
        if turn * (turn + shift) > near * sd.rotation || shift * shift > near * sd.translation {
            *self = Self::NONE;
            return;
        }
        let [heard, _] = self.heard;
        let fading = if heard >= lineage.memory { lineage.fading() } else { T::ONE };
        self.parts.iter_mut().for_each(|part| *part = part.about(moved).scaled(fading));
    }

    /// Takes in one more pair.
    ///
    /// * `to_pose`: from where the pair was judged to the pose.
    pub(super) fn add(
        &mut self,
        evidence: &Evidence<T>,
        to_pose: &Vector5<T>,
        repeated: bool,
        lineage: &Lineage<T>,
    ) {
        let [all, left, upper] = &mut self.parts;
        all.add(&evidence.moments.at_frame().about(to_pose));
        for (sum, half) in [left, upper].into_iter().zip(&evidence.halves) {
            sum.add(&half.about(to_pose));
        }
        let [heard, distinct] = self.heard;
        self.heard = [heard.saturating_add(1), distinct.saturating_add(u32::from(!repeated))];
        self.disagreement = self.between(lineage);
    }

    pub(super) fn write(&self, to: &mut Writer<'_>) {
        self.parts.iter().for_each(|part| part.write(to));
        self.heard.iter().for_each(|heard| to.word(*heard));
        to.number(self.disagreement);
    }

    pub(super) fn read(&mut self, from: &mut Reader<'_>) -> Result<(), RestoreError> {
        self.parts.iter_mut().try_for_each(|part| part.read(from))?;
        self.heard = [from.word()?, from.word()?];
        self.disagreement = from.size()?;
        Ok(())
    }

    /// Disagreement, in standard deviations per degree of freedom.
    pub(super) fn disagreement(&self) -> T {
        self.disagreement
    }

    /// What it does to the variances. It is that of all pairs heard, the variance that of distinct ones.
    pub(super) fn widened(&self) -> T {
        let [heard, distinct] = self.heard.map(|n| T::count(n.max(1)));
        if self.disagreement > T::lit(HEALTHY) {
            (self.disagreement * self.disagreement * (distinct / heard)).max(T::ONE)
        } else {
            T::ONE
        }
    }

    /// Distance between what the halves of the image say.
    #[inline(never)]
    fn between(&self, lineage: &Lineage<T>) -> T {
        let [all, left, top] = &self.parts;
        let Some(x) = all.pulled(lineage.prior).step() else {
            return T::ZERO;
        };
        // About the optimum of both, where the prior belongs.
        let distance = |half: &Quadratic<T>| {
            let one = half.about(&x).pulled(lineage.prior);
            let other = all.less(half).about(&x).pulled(lineage.prior);
            one.distance(&other).unwrap_or(T::ZERO)
        };
        let worse = (distance(left).max(distance(top)).max(T::ZERO) / T::lit(5.0)).sqrt();
        worse.min(T::lit(LARGEST))
    }

    /// Information about the turn of `R` about x in each sum.
    #[cfg(test)]
    pub(super) fn pitch(&self) -> [T; 3] {
        self.parts.map(|part| part.information.matrix().m11)
    }
}
