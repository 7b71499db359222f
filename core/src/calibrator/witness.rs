//! Witnesses of the mount yaw: measurements that separate it from the apparent yaw of the lens.

use core::fmt::Debug;

use super::Calibrator;
use crate::batch::correspondence::RayPair;
use crate::batch::row_offset::is_within_rows;
use crate::depth::motion::TurnByMotion;
use crate::depth::mount::Witnessed;
use crate::depth::range::RangeReading;
use crate::depth::tracks::Tracks;
use crate::error::{MotionError, RangeError};
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{MAX_CONFIRMED_YAW_RAD, RANGE_REACH_PX, SIGNIFICANT, TRACK_NOISE};

/// A measurement that separates the mount yaw from the apparent yaw of the lens. [`Calibrator::push_witness`] adds it.
/// The trait is sealed.
pub trait Witness<T: Scalar>: sealed::Witness<T> {}

impl<T: Scalar, W: sealed::Witness<T>> Witness<T> for W {}

mod sealed {
    use super::{Calibrator, Debug, Scalar, Witnessed};

    pub trait Witness<T: Scalar> {
        /// Why the measurement is refused.
        type Error: Debug;

        fn add_to<const N: usize>(
            self,
            calibrator: &mut Calibrator<T, N>,
        ) -> Result<Witnessed, Self::Error>;
    }
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Adds a witness of the mount yaw. Call it after the end of the pair that shows the measurement, and before the
    /// next pair.
    ///
    /// * `&RangeReading`: a point of known distance. Its own match ([`RangeReading::right`]) gives the yaw. Without a
    ///   match of its own, the nearest match of the last pair within 3 px in the left image gives it. The match must
    ///   fit the estimate. Five readings with an error of 1 %, or ten with an error of 3 %, are enough to confirm the
    ///   yaw ([`crate::Reason::Yaw`]). Takes at most one pass over the batch.
    /// * `&[[RayPair; 2]]`: matches that were tracked from an earlier pair to the last pair while the rig moved. Each
    ///   has the rays of both pairs, by [`crate::Cameras::rays`], with the factory cameras. The rig must have moved by
    ///   several baseline lengths (2 to 6 m for a vehicle). Up to 256 matches are read, 17 times each.
    /// * `&mut Tracks`: the tracked matches that an earlier frame and the frame of the last pair share
    ///   ([`Tracks::quads`]). Each frame is joined to the same earlier frame until the rig has moved far enough for a
    ///   measurement. Then, and after [`MotionError::Contradicts`], the last frame becomes the earlier frame.
    ///
    /// A witness that contradicts the present yaw waits ([`Witnessed::Waiting`]). The present yaw is replaced once
    /// enough contradicting witnesses in a row agree with each other: more than support the present yaw, which takes
    /// two to four. [`crate::outcome::Details`] counts the
    /// witnesses that wait, and the witnesses that are refused because they contradict mount and lens.
    ///
    /// # Errors
    /// [`RangeError`] or [`MotionError`]; the estimate is unchanged. With [`Tracks`], [`MotionError::NoMotion`] and
    /// [`MotionError::TooFew`] are ordinary. The paper preset refuses every witness.
    pub fn push_witness<W: Witness<T>>(&mut self, witness: W) -> Result<Witnessed, W::Error> {
        let witnessed = witness.add_to(self)?;
        self.next = None;
        Ok(witnessed)
    }
}

impl<T: Scalar> sealed::Witness<T> for &[[RayPair<T>; 2]] {
    type Error = MotionError;

    #[inline(never)]
    fn add_to<const N: usize>(self, to: &mut Calibrator<T, N>) -> Result<Witnessed, MotionError> {
        if to.frozen || to.estimator.state() != State::Locked {
            return Err(MotionError::NotLocked);
        }
        if self.len() < to.config.min_correspondences.into() {
            return Err(MotionError::TooFew);
        }
        let context = &to.estimator.context(&to.config, &to.factory);
        let (pose, rows) = to.estimator.rows(context).ok_or(MotionError::NotLocked)?;
        let noise = to.estimator.noise() * T::lit(TRACK_NOISE) / context.focal;
        let correction = &to.estimator.correction();
        let found = TurnByMotion::of(&pose, correction, self, noise);
        let found = found.ok_or(MotionError::NoMotion)?;
        let most = T::lit(MAX_CONFIRMED_YAW_RAD);
        if !(found.variance <= most * most) {
            return Err(MotionError::NoMotion);
        }
        let mount = to.estimator.mount_mut().ok_or(MotionError::NotLocked)?;
        let witnessed = mount.witness(rows.turn + found.turn, found.variance, &rows, context);
        let [_, count] = &mut to.contradicting;
        count_contradiction(count, witnessed);
        witnessed.ok_or(MotionError::Contradicts)
    }
}

impl<T: Scalar, const M: usize> sealed::Witness<T> for &mut Tracks<T, M> {
    type Error = MotionError;

    fn add_to<const N: usize>(self, to: &mut Calibrator<T, N>) -> Result<Witnessed, MotionError> {
        let witnessed = self.quads().add_to(to);
        if matches!(witnessed, Ok(_) | Err(MotionError::Contradicts)) {
            self.restart();
        }
        witnessed
    }
}

impl<T: Scalar> sealed::Witness<T> for &RangeReading<T> {
    type Error = RangeError;

    fn add_to<const N: usize>(self, to: &mut Calibrator<T, N>) -> Result<Witnessed, RangeError> {
        let baseline_m = to.factory.baseline_m.map(T::single).ok_or(RangeError::NoBaseline)?;
        if !self.is_valid() {
            return Err(RangeError::Reading);
        }
        // The rays of the batch belong to the corrected cameras, and so does the pose that was solved from them.
        let cameras = &to.corrected;
        let ray = cameras.left.ray(self.pixel).map_err(RangeError::Pixel)?;
        let right = self.right.map(|pixel| cameras.right.ray(pixel));
        let right = right.transpose().map_err(RangeError::Pixel)?;
        if to.frozen || to.estimator.state() != State::Locked {
            return Err(RangeError::NotLocked);
        }
        let context = &to.estimator.context(&to.config, &to.factory);
        let (pose, rows) = to.estimator.rows(context).ok_or(RangeError::NotLocked)?;
        let noise = to.estimator.noise() / context.focal;
        let reach = T::lit(RANGE_REACH_PX) / context.focal;
        let most = T::lit(SIGNIFICANT) * (noise + noise);
        let pair = match right {
            Some(right) => RayPair::try_new(ray.into(), right.into())
                .filter(|own| is_within_rows(own, &pose, most)),
            None => to.batch.nearest(&ray, reach, &pose, most).copied(),
        };
        let pair = &pair.ok_or(RangeError::NoMatch)?;
        let known = self.inverse_depth(&ray, baseline_m);
        let [turn, variance] = known.turn(&pose, pair, noise * noise).ok_or(RangeError::NoMatch)?;
        let mount = to.estimator.mount_mut().ok_or(RangeError::NotLocked)?;
        let witnessed = mount.witness(rows.turn + turn, variance, &rows, context);
        let [count, _] = &mut to.contradicting;
        count_contradiction(count, witnessed);
        witnessed.ok_or(RangeError::Contradicts)
    }
}

/// Counts a measurement that contradicts the yaw: it is refused, or it waits.
fn count_contradiction(count: &mut u16, witnessed: Option<Witnessed>) {
    let contradicts = witnessed != Some(Witnessed::Taken);
    *count = count.saturating_add(contradicts.into());
}
