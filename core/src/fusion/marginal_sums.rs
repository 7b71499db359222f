//! Sums over the pairs of a vibrating rig: each pair is weighed by its information on the mean rig (`ESTIMATOR.md`,
//! section 14).

use nalgebra::Vector5;

use crate::algebra::block_variances::BlockVariances;
use crate::algebra::normal_equations::NormalEquations;
use crate::scalar::Scalar;
use crate::thresholds::FORGOTTEN_PAIRS;

/// Normal equations of all pairs about the pose of the hypothesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MarginalSums<T> {
    pub(super) sum: NormalEquations<T>,
    /// Variances of the sums; zero if the rig does not vibrate, and then nothing is summed.
    pub(super) variances: BlockVariances<T>,
}

impl<T: Scalar> MarginalSums<T> {
    pub(super) const NONE: Self =
        Self { sum: NormalEquations::ZERO, variances: BlockVariances::ZERO };

    pub(super) fn is_used(&self) -> bool {
        !self.variances.is_zero()
    }

    /// Starts with the pairs so far, as if each had the mean share of their sum. A few pairs with the weights of a
    /// rigid rig give a wrong mean, because the vibration of strong directions leaks into weak ones: all but the last
    /// are dropped.
    ///
    /// * `sum`, `last`: equations of a rigid rig, of all pairs and of the last, about the pose.
    pub(super) fn start(
        &mut self,
        sum: &NormalEquations<T>,
        last: &NormalEquations<T>,
        pairs: u32,
        variances: &BlockVariances<T>,
    ) -> Option<()> {
        self.sum = if pairs <= FORGOTTEN_PAIRS {
            variances.marginal(last)?
        } else {
            mean_of(pairs, variances).marginal(sum)?
        };
        self.variances = *variances;
        Some(())
    }

    /// Follows a vibration that has grown or ceased. Older pairs lose weight if it has doubled; they never gain weight.
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
    /// * `pair`: its equations for a rigid rig, about the pose; `fading`: factor of older pairs.
    pub(super) fn add(
        &mut self,
        pair: &NormalEquations<T>,
        variances: &BlockVariances<T>,
        fading: T,
    ) -> Option<()> {
        self.sum = self.sum.scaled(fading).plus(&variances.marginal(pair)?);
        Some(())
    }

    /// Shifts the sums after a step of the pose.
    pub(super) fn shift(&mut self, moved: &Vector5<T>) {
        self.sum = self.sum.about(moved);
    }
}

/// Variances of the mean of the pairs.
fn mean_of<T: Scalar>(pairs: u32, variances: &BlockVariances<T>) -> BlockVariances<T> {
    variances.scaled(T::ONE / T::count(pairs.max(1)))
}
