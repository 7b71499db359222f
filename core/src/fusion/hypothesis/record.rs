//! Record of a hypothesis: moments, pose and running means, in the order of `write`.

use super::super::marginal_sums::MarginalSums;
use super::super::optimum::MAX_INCONSISTENCY;
use super::{Hypothesis, limited};
use crate::algebra::information::{Information, StandardDeviations};
use crate::algebra::normal_equations::NormalEquations;
use crate::algebra::symmetric5::Symmetric5;
use crate::codec::{Reader, Writer, believe};
use crate::config::Context;
use crate::error::RestoreError;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{MAX_NOISE_PX, MAX_REDUCED_CHI_SQUARE};

/// Largest rounding of a running mean over its largest term.
const MEAN_ROUNDING: f64 = 1.001;

/// Damping of informations that are compared, in diagonals: what a sum of 1e10 leaves of a direction of 1e3 is rounding
/// in `f32`. Where no diagonal differs by more than a factor of two, the ratio is at most `5 * 2 / 1e-3` = 1e4.
const COMPARED_DAMPING: f64 = 1e-3;

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
        let apart = self.distance_of_frame();
        self.settled.read(from, apart)?;
        self.last.read(from, apart)?;
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
        self.drift = limited(&self.drift);
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

    /// Squared distance of the frame of the sums from the pose, rad^2.
    pub(in crate::fusion) fn distance_of_frame(&self) -> T {
        self.frame.unknowns_to(&self.pose).norm_squared()
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
        let mut stored = self.information.0;
        stored.add_diagonal(context.prior);
        are_consistent(&normal, &stored)
    }
}

/// Whether equations have their optimum near zero, and nearly the information that is stored for them.
fn are_consistent<T: Scalar>(normal: &NormalEquations<T>, stored: &Symmetric5<T>) -> Option<bool> {
    let NormalEquations { information: Information(summed), gradient } = normal;
    let damping = T::lit(COMPARED_DAMPING);
    let [by_summed, by_stored] = [summed.factor(damping)?, stored.factor(damping)?];
    let squared = by_summed.solve(gradient).dot(gradient);
    let ratios = [by_stored.inverse().dot(summed), by_summed.inverse().dot(stored)];
    let most = T::lit(MAX_INCONSISTENCY);
    Some(squared <= most && ratios.into_iter().all(|ratio| ratio <= most))
}

#[cfg(test)]
pub(super) mod tests {
    extern crate std;

    use super::super::tests::{at, context, evaluated, fused, truth};
    use super::*;
    use crate::algebra::block_variances::BlockVariances;
    use crate::codec;
    use nalgebra::Vector5;
    use std::vec::Vec;

    /// Information of a few matches far from the axis: 1e13 on pitch, 1e3 on others, which follow pitch.
    fn information(turn: f32) -> Symmetric5<f32> {
        let mut information = Symmetric5::of_diagonal([1e3; 5]);
        information.add_outer(1e13, &[1.0, turn, 0.02 * turn, 1e-5, -turn]);
        information
    }

    #[test]
    fn informations_of_next_to_nothing_in_one_direction_agree_where_their_diagonals_do() {
        let [one, other] = [2e-3, 2.8e-3].map(information);
        // After a step of pitch, in deviations.
        let normal = |information: Symmetric5<f32>, step: f32| NormalEquations {
            information: Information(information),
            gradient: information.times(&(Vector5::x() * (step / 1e13_f32.sqrt()))),
        };
        assert_eq!(are_consistent(&normal(one, 0.0), &other), Some(true));
        // Undamped their ratio is far beyond the limit.
        let ratio = one.inverse().map_or(f32::INFINITY, |inverse| inverse.dot(&other));
        assert!(!(0.0..=1e4).contains(&ratio), "{ratio}");
        for k in 0..5 {
            let mut wrong = one;
            let place = [0, 2, 5, 9, 14][k];
            wrong.0[place] *= 1e6;
            assert_eq!(are_consistent(&normal(one, 0.0), &wrong), Some(false), "{k}");
            assert_eq!(are_consistent(&normal(wrong, 0.0), &one), Some(false), "{k}");
        }
        assert_eq!(are_consistent(&normal(one, 90.0), &one), Some(true));
        assert_eq!(are_consistent(&normal(one, 110.0), &one), Some(false));
    }

    /// What is read from a record of a hypothesis.
    pub(in super::super) fn restored(
        from: &Hypothesis<f64>,
        context: &Context<'_, f64>,
    ) -> Option<Hypothesis<f64>> {
        let (mut buffer, header) = ([0; 8192], codec::RecordHeader::FACTORY);
        let record = codec::write::<f64>(header, &mut buffer, |to| from.write(to)).ok()?;
        let mut read = Hypothesis::EMPTY;
        read.read(&mut codec::open::<f64>(header, record).ok()?, context).ok().map(|()| read)
    }

    #[test]
    fn a_record_is_read_after_the_pairs_of_a_rig_that_vibrates_were_replaced() {
        let both = 4e-6;
        let turning = context::<f64>().vibrating(BlockVariances { rotation: both, baseline: both });
        let pairs: Vec<_> =
            (0..30_u32).map(|seed| at(2e-3 * f64::from(seed % 3) - 2e-3, seed.into())).collect();
        let mut hypothesis = fused(&pairs, 1, &turning);
        let newest = fused(&pairs[20..], 1, &context()).sums();
        let mut settled = newest;
        settled.change_frame(&pairs[20].measurement.pose, &hypothesis.frame);
        assert!(!hypothesis.is_rigid() && hypothesis.replace(&settled, 10, &turning));
        assert_eq!(restored(&hypothesis, &turning), Some(hypothesis));
    }

    #[test]
    fn a_record_is_read_where_the_sums_are_in_a_frame_far_from_the_pose() {
        let mut hypothesis = fused(&[evaluated::<f64>(1), evaluated(2)], 1, &context());
        let far = truth().stepped_by(&Vector5::new(0.3, -0.2, 0.1, 0.2, -0.3)).unwrap();
        hypothesis.settled.change_frame(&hypothesis.frame, &far);
        hypothesis.last.change_frame(&hypothesis.frame, &far);
        hypothesis.frame = far;
        assert_eq!(restored(&hypothesis, &context()), Some(hypothesis));
    }
}
