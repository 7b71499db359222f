//! Record of a hypothesis: moments, pose and running means, in the order of `write`.

use nalgebra::Vector5;

use super::super::marginal_sums::MarginalSums;
use super::Hypothesis;
use crate::algebra::information::StandardDeviations;
use crate::codec::{Reader, Writer, believe};
use crate::config::Context;
use crate::error::RestoreError;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{MAX_LOCKED_SD_RAD, MAX_NOISE_PX, MAX_REDUCED_CHI_SQUARE};

/// Largest rounding of a running mean over its largest term.
const MEAN_ROUNDING: f64 = 1.001;

/// Largest squared distance of the pose from the optimum of the sums, in deviations, and ratio of their informations.
/// A first pair that says next to nothing of a direction comes to 400; a number wrong by 1e6 exceeds it.
const MAX_INCONSISTENCY: f64 = 1e4;

/// Matches in the short window of pairs of a million matches.
const MAX_MATCHES: f64 = 1e7;

impl<T: Scalar> Hypothesis<T> {
    /// Numbers and words in a record.
    pub(in crate::fusion) const NUMBERS: usize = 306 + MarginalSums::<T>::NUMBERS;
    pub(in crate::fusion) const WORDS: usize = 3;

    pub(in crate::fusion) fn write(&self, to: &mut Writer<'_>) {
        self.pose.write(to);
        self.frame.write(to);
        self.settled.write(to);
        self.last.write(to);
        self.halves.write(to);
        self.information.0.write(to);
        to.numbers(&[self.noise, self.inlier_share, self.reduced_chi_square]);
        to.numbers(self.drift.iter());
        to.word(self.pairs);
        self.marginal.write(to);
        to.number(self.crowd);
        to.numbers(&self.high_leverage);
    }

    /// Reads a record into [`Hypothesis::EMPTY`].
    ///
    /// # Errors
    /// [`RestoreError::Absurd`] for a number out of its range, sums that do not lead to the pose and its information,
    /// or a covariance that is not finite.
    #[inline(never)]
    pub(in crate::fusion) fn read(
        &mut self,
        from: &mut Reader<'_>,
        context: &Context<'_, T>,
    ) -> Result<(), RestoreError> {
        self.pose = RectifyingRotations::read(from)?;
        self.frame = RectifyingRotations::read(from)?;
        self.settled.read(from)?;
        self.last.read(from)?;
        self.halves.read(from)?;
        self.information.0.read(from)?;
        let over = T::lit(MEAN_ROUNDING);
        let floor = T::single(context.config.noise_floor_px);
        // An update may have changed the floor.
        let noisiest = floor.max(T::lit(MAX_NOISE_PX)) * T::lit(2.0);
        self.noise = from.within(floor.min(T::lit(MAX_NOISE_PX)) * T::HALF, noisiest)?;
        self.inlier_share = from.within(T::ZERO, over)?;
        self.reduced_chi_square = from.within(T::ZERO, over * T::lit(MAX_REDUCED_CHI_SQUARE))?;
        let limit = T::single(context.config.max_correction_rad);
        from.numbers_within(limit * T::lit(2.0), self.drift.iter_mut())?;
        // With a wider covariance pairs are lost among outliers; the drift is that of a locked estimate.
        if self.drift.amax() > T::lit(MAX_LOCKED_SD_RAD) {
            self.drift = Vector5::zeros();
        }
        self.pairs = from.word()?;
        if from.version() >= 4 {
            self.marginal.read(from)?;
        }
        if from.version() >= 5 {
            self.crowd = from.within(-over, over)?;
            for sum in &mut self.high_leverage {
                *sum = from.within(T::ZERO, T::lit(MAX_MATCHES))?;
            }
        }
        if from.version() < 3 {
            let deviation = self.noise / context.focal;
            self.settled.set_noise(&self.frame, deviation * deviation);
            self.last.set_noise(&self.frame, deviation * deviation);
        } else {
            believe(self.is_consistent(context) == Some(true))?;
        }
        self.halves.check(context);
        // Finite numbers may still have no finite covariance.
        let is_finite =
            |sd: StandardDeviations<T>| sd.rotation.is_finite() && sd.translation.is_finite();
        believe(self.pairs > 0 && self.deviations(context).is_some_and(is_finite))
    }

    /// Whether the sums lead to the pose and to its information. Wide: pairs that contradict each other leave a step.
    #[inline(never)]
    fn is_consistent(&self, context: &Context<'_, T>) -> Option<bool> {
        let mut normal = if self.marginal.is_used() {
            self.marginal.total()
        } else {
            self.sums().debiased_at_pose(&self.frame, &self.pose)
        };
        context.add_prior(&self.pose, &mut normal);
        let (step, covariance) = normal.optimum()?;
        let mut stored = self.information.0;
        stored.add_diagonal(context.prior);
        let most = T::lit(MAX_INCONSISTENCY);
        let ratios = [stored.inverse()?.dot(&normal.information.0), covariance.dot(&stored)];
        let squared = -step.dot(&normal.gradient);
        Some(squared <= most && ratios.into_iter().all(|ratio| ratio <= most))
    }
}
