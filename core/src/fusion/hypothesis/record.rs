//! Record of a hypothesis: moments, pose and running means, as `FORMAT.md` lists them.

use super::Hypothesis;
use crate::algebra::information::StandardDeviations;
use crate::codec::{Reader, Writer};
use crate::config::Context;
use crate::error::RestoreError;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;

impl<T: Scalar> Hypothesis<T> {
    /// Numbers and words in a record.
    pub(in crate::fusion) const NUMBERS: usize = 303;
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
    }

    /// Reads a record into [`Hypothesis::EMPTY`].
    ///
    /// # Errors
    /// [`RestoreError::Absurd`] where the covariance is not finite.
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
        (self.noise, self.inlier_share, self.reduced_chi_square) =
            (from.size()?, from.size()?, from.size()?);
        from.numbers(self.drift.iter_mut())?;
        self.pairs = from.word()?;
        if from.version() < 3 {
            let deviation = self.noise / context.focal;
            self.settled.set_noise(&self.frame, deviation * deviation);
            self.last.set_noise(&self.frame, deviation * deviation);
        }
        // Finite numbers may still have no finite covariance.
        let is_finite =
            |sd: StandardDeviations<T>| sd.rotation.is_finite() && sd.translation.is_finite();
        if self.pairs > 0 && self.deviations(context).is_some_and(is_finite) {
            Ok(())
        } else {
            Err(RestoreError::Absurd)
        }
    }
}
