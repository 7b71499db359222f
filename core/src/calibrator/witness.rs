//! Witnesses of the mount yaw: measurements that tell it from the apparent yaw of the lens.

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
use crate::thresholds::{LENS_FOUND, MAX_CONFIRMED_YAW_RAD, RANGE_REACH_PX, TRACK_NOISE};

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Adds matches that were tracked from one pair to a later one while the rig moved, once the later one has ended: rays of
    /// both pairs, by [`crate::Cameras::rays`], in the cameras as given. The rig must have moved by several lengths of
    /// its baseline (2 to 6 m of a vehicle); up to 256 matches are read, 17 times.
    ///
    /// # Errors
    /// [`MotionError`]; the estimate is unchanged. [`crate::Health::contradicting_motions`] counts those that contradict the yaw.
    #[inline(never)]
    pub fn push_motion(&mut self, tracked: &[[RayPair<T>; 2]]) -> Result<Witnessed, MotionError> {
        if self.frozen || self.estimator.state() != State::Locked {
            return Err(MotionError::NotLocked);
        }
        if tracked.len() < self.config.min_correspondences.into() {
            return Err(MotionError::TooFew);
        }
        let context = &self.estimator.context(&self.config, &self.factory);
        let (pose, rows) = self.estimator.rows(context).ok_or(MotionError::NotLocked)?;
        let noise = self.estimator.noise() * T::lit(TRACK_NOISE) / context.focal;
        let correction = &self.estimator.correction();
        let found = TurnByMotion::of(&pose, correction, tracked, noise);
        let found = found.ok_or(MotionError::NoMotion)?;
        let most = T::lit(MAX_CONFIRMED_YAW_RAD);
        if !(found.variance <= most * most) {
            return Err(MotionError::NoMotion);
        }
        let mount = self.estimator.mount_mut().ok_or(MotionError::NotLocked)?;
        let witnessed = mount.witness(rows.turn + found.turn, found.variance, &rows, context);
        let [_, count] = &mut self.contradicting;
        count_contradiction(count, witnessed);
        witnessed.ok_or(MotionError::Contradicts)
    }

    /// Adds the matches that an earlier frame and that of the last pair share ([`Tracks::quads`]), once the pair has ended.
    /// After a measurement the last frame is the earlier one; until the rig has moved far enough, later frames are joined to
    /// the same one. Work: that of [`Calibrator::push_motion`].
    ///
    /// # Errors
    /// As [`Calibrator::push_motion`]; [`MotionError::NoMotion`] and [`MotionError::TooFew`] are ordinary.
    pub fn push_tracks<const M: usize>(
        &mut self,
        tracks: &mut Tracks<T, M>,
    ) -> Result<Witnessed, MotionError> {
        let pushed = self.push_motion(tracks.quads());
        if matches!(pushed, Ok(_) | Err(MotionError::Contradicts)) {
            tracks.restart();
        }
        pushed
    }

    /// Adds a point of known distance. Call it after the pair that shows the point has ended, and before the next pair: its
    /// own match ([`RangeReading::right`]), or else the nearest match within 3 px in the left image, gives the yaw. The match
    /// must fit the estimate. Five readings of 1 %, or ten of 3 %, are enough. At most one pass over the batch.
    ///
    /// A reading that contradicts the yaw so far waits ([`Witnessed::Waiting`]) until more readings in a row agree with it
    /// than support that yaw, of which three count. [`crate::Health::contradicting_ranges`] counts both kinds of readings
    /// that contradict it: those that wait, and those that are refused.
    ///
    /// # Errors
    /// [`RangeError`]; the estimate is unchanged.
    pub fn push_range(&mut self, reading: &RangeReading<T>) -> Result<Witnessed, RangeError> {
        let baseline_m = self.factory.baseline_m.map(T::single).ok_or(RangeError::NoBaseline)?;
        if !reading.is_valid() {
            return Err(RangeError::Reading);
        }
        // The rays of the batch, and so the pose, belong to the corrected cameras.
        let cameras = &self.corrected;
        let ray = cameras.left.ray(reading.pixel).map_err(RangeError::Pixel)?;
        let right = reading.right.map(|pixel| cameras.right.ray(pixel));
        let right = right.transpose().map_err(RangeError::Pixel)?;
        if self.frozen || self.estimator.state() != State::Locked {
            return Err(RangeError::NotLocked);
        }
        let context = &self.estimator.context(&self.config, &self.factory);
        let (pose, rows) = self.estimator.rows(context).ok_or(RangeError::NotLocked)?;
        let noise = self.estimator.noise() / context.focal;
        let reach = T::lit(RANGE_REACH_PX) / context.focal;
        let most = T::lit(LENS_FOUND) * (noise + noise);
        let pair = match right {
            Some(right) => RayPair::try_new(ray.into(), right.into())
                .filter(|own| is_within_rows(own, &pose, most)),
            None => self.batch.nearest(&ray, reach, &pose, most).copied(),
        };
        let pair = &pair.ok_or(RangeError::NoMatch)?;
        let known = reading.inverse_depth(&ray, baseline_m);
        let [turn, variance] = known.turn(&pose, pair, noise * noise).ok_or(RangeError::NoMatch)?;
        let mount = self.estimator.mount_mut().ok_or(RangeError::NotLocked)?;
        let witnessed = mount.witness(rows.turn + turn, variance, &rows, context);
        let [count, _] = &mut self.contradicting;
        count_contradiction(count, witnessed);
        witnessed.ok_or(RangeError::Contradicts)
    }
}

/// Counts a measurement that is refused or waits, because it contradicts the yaw.
fn count_contradiction(count: &mut u16, witnessed: Option<Witnessed>) {
    let contradicts = witnessed != Some(Witnessed::Taken);
    *count = count.saturating_add(contradicts.into());
}
