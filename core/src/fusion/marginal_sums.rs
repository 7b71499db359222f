//! Sums over the pairs of a vibrating rig. Each pair is weighted by its information on the mean rig (`ESTIMATOR.md`,
//! section 14).

use nalgebra::Vector5;

use crate::algebra::block_variances::BlockVariances;
use crate::algebra::normal_equations::NormalEquations;
use crate::scalar::Scalar;

/// Normal equations of all pairs about the pose of the hypothesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MarginalSums<T> {
    pub(super) sum: NormalEquations<T>,
    /// Variances of the vibration that the sums assume, rad^2.
    pub(super) variances: BlockVariances<T>,
}

impl<T: Scalar> MarginalSums<T> {
    /// Returns sums of the pairs so far, as if each had an equal share of their sum. `None` if numbers overflow.
    ///
    /// * `sum`: equations of all pairs for a rigid rig, about the pose; `pairs`: number of pairs.
    pub(super) fn start(
        sum: &NormalEquations<T>,
        pairs: u32,
        variances: &BlockVariances<T>,
    ) -> Option<Self> {
        let sum = mean_of(pairs, variances).marginal(sum)?;
        Some(Self { sum, variances: *variances })
    }

    /// Follows a variance of the vibration that has doubled or halved. If it has doubled, older pairs lose weight; if
    /// it has halved, they keep their weight.
    pub(super) fn follow(&mut self, pairs: u32, now: &BlockVariances<T>) -> Option<()> {
        let then = self.variances;
        if now.doubles(&then) {
            let more = now.minus(&then);
            self.sum = mean_of(pairs, &more).marginal(&self.sum)?;
        }
        if now.doubles(&then) || then.doubles(now) {
            self.variances = *now;
        }
        Some(())
    }

    /// Adds a pair.
    ///
    /// * `pair`: equations of the pair for a rigid rig, about the pose; `fading`: factor of the older pairs.
    pub(super) fn add(
        &mut self,
        pair: &NormalEquations<T>,
        variances: &BlockVariances<T>,
        fading: T,
    ) -> Option<()> {
        self.sum = self.sum.scaled(fading).plus(&variances.marginal(pair)?);
        Some(())
    }

    /// Shifts the sums after a step of the pose, rad.
    pub(super) fn shift(&mut self, moved: &Vector5<T>) {
        self.sum = self.sum.about(moved);
    }
}

/// Returns the variances that a vibration leaves in the mean over the pairs.
fn mean_of<T: Scalar>(pairs: u32, variances: &BlockVariances<T>) -> BlockVariances<T> {
    variances.scaled(T::ONE / T::count(pairs.max(1)))
}
