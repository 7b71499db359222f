//! Witnesses of the mount yaw: measurements that separate it from the apparent yaw of the lens.

use super::{Calibrator, context};
use crate::batch::correspondence::RayPair;
use crate::batch::row_offset::is_within_rows;
use crate::depth::motion::{MotionFit, Views};
use crate::depth::mount::Witnessed;
use crate::depth::range::RangeReading;
use crate::depth::tracks::Tracks;
use crate::error::{MotionError, RangeError};
use crate::geometry::lens_correction::LensCorrection;
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{
    MAX_CONFIRMED_YAW_RAD, MOTION_STEPS, RANGE_REACH_PX, SIGNIFICANT, TRACK_NOISE,
};

/// Progress of a fit of the motion: `None` if further steps are needed.
type Progress = Result<Option<Witnessed>, MotionError>;

/// Witnesses of the mount yaw. Each belongs to the last pair: add it after the end of the pair that shows the
/// measurement, and before the next pair.
///
/// A witness that contradicts the present yaw waits ([`Witnessed::Waiting`]). The present yaw is replaced once enough
/// contradicting witnesses in a row agree with each other: more than support the present yaw, which takes two to four.
/// [`crate::outcome::Details`] counts the witnesses that wait, and the witnesses that are refused because they
/// contradict mount and lens.
impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Adds a point of known distance. Its own match ([`RangeReading::right`]) gives the yaw. Without a match of its
    /// own, the nearest match of the last pair within 3 px in the left image gives it. The match must fit the estimate.
    /// Five readings with an error of 1 %, or ten with an error of 3 %, are enough to confirm the yaw
    /// ([`crate::Reason::Yaw`]). Takes at most one pass over the batch.
    ///
    /// # Errors
    /// [`RangeError`]; the estimate is unchanged.
    pub fn push_range(&mut self, reading: &RangeReading<T>) -> Result<Witnessed, RangeError> {
        let baseline_m = self.factory.baseline_m.map(T::single).ok_or(RangeError::NoBaseline)?;
        if !reading.is_valid() {
            return Err(RangeError::Reading);
        }
        // The rays of the batch belong to the corrected cameras, and so does the pose that was solved from them.
        let cameras = &self.corrected;
        let ray = cameras.left.ray(reading.pixel).map_err(RangeError::Pixel)?;
        let own = reading.right.map(|right| cameras.pair(reading.pixel, right));
        let own = own.transpose().map_err(RangeError::Pixel)?;
        if self.frozen || self.fusion.state() != State::Locked {
            return Err(RangeError::NotLocked);
        }
        let context = &context(&self.config, &self.factory, &self.fusion);
        let (pose, rows) = self.fusion.rows(context).ok_or(RangeError::NotLocked)?;
        let pose = pose.rotations();
        let noise = self.fusion.noise() / context.focal;
        let reach = T::lit(RANGE_REACH_PX) / context.focal;
        let most = T::lit(SIGNIFICANT) * (noise + noise);
        let pair = match own {
            Some(own) => Some(own).filter(|own| is_within_rows(own, pose, most)),
            None => self.batch.nearest(&ray, reach, pose, most).copied(),
        };
        let pair = &pair.ok_or(RangeError::NoMatch)?;
        let noise = noise * pair.scale();
        let known = reading.inverse_depth(&ray, baseline_m);
        let [turn, variance] = known.turn(pose, pair, noise * noise).ok_or(RangeError::NoMatch)?;
        let witnessed = self.fusion.mount_mut().witness(rows.turn + turn, variance, &rows, context);
        let [count, _] = &mut self.contradicting;
        count_contradiction(count, witnessed);
        let witnessed = witnessed.ok_or(RangeError::Contradicts)?;
        self.next = None;
        Ok(witnessed)
    }

    /// Adds matches that were tracked from an earlier pair to the last pair while the rig moved. Each has the rays of
    /// both pairs, by [`crate::Cameras::rays`], with the factory cameras. The rig must have moved by several baseline
    /// lengths (2 to 6 m for a vehicle). Up to 256 matches are read, at most 16 times each; on a controller,
    /// [`Calibrator::advance_tracks`] divides this into calls.
    ///
    /// # Errors
    /// [`MotionError`]; the estimate is unchanged.
    pub fn push_motion(&mut self, tracked: &[[RayPair<T>; 2]]) -> Result<Witnessed, MotionError> {
        let mut fit = MotionFit::START;
        for _ in 0..MOTION_STEPS {
            if let Some(witnessed) = self.advance_motion(&mut fit, tracked)? {
                return Ok(witnessed);
            }
        }
        Err(MotionError::NoMotion)
    }

    /// Adds the tracked matches that an earlier frame and the frame of the last pair share ([`Tracks::quads`]). Calls
    /// [`Calibrator::advance_tracks`] until the motion is known.
    ///
    /// # Errors
    /// [`MotionError`]; the estimate is unchanged. [`MotionError::NoMotion`] and [`MotionError::TooFew`] are ordinary.
    pub fn push_tracks<const M: usize>(
        &mut self,
        tracks: &mut Tracks<T, M>,
    ) -> Result<Witnessed, MotionError> {
        for _ in 0..MOTION_STEPS {
            if let Some(witnessed) = self.advance_tracks(tracks) {
                return witnessed;
            }
        }
        Err(MotionError::NoMotion)
    }

    /// Takes one step of [`Calibrator::push_tracks`]: one pass over at most 256 matches. Returns `None` while further
    /// steps are needed, at most 16 in all. The next frame abandons the steps taken.
    ///
    /// Each frame is joined to the same earlier frame until the rig has moved far enough for a measurement. Then, and
    /// after [`MotionError::Contradicts`], the last frame becomes the earlier frame.
    pub fn advance_tracks<const M: usize>(
        &mut self,
        tracks: &mut Tracks<T, M>,
    ) -> Option<Result<Witnessed, MotionError>> {
        let (fit, tracked) = tracks.fit();
        let witnessed = self.advance_motion(fit, tracked).transpose()?;
        match witnessed {
            Ok(_) | Err(MotionError::Contradicts) => tracks.restart(),
            Err(_) => *fit = MotionFit::START,
        }
        Some(witnessed)
    }

    /// Takes one step of a fit, and adds its result once there is one.
    #[inline(never)]
    fn advance_motion(&mut self, fit: &mut MotionFit<T>, tracked: &[[RayPair<T>; 2]]) -> Progress {
        if self.frozen || self.fusion.state() != State::Locked {
            return Err(MotionError::NotLocked);
        }
        if tracked.len() < self.config.min_correspondences.into() {
            return Err(MotionError::TooFew);
        }
        let context = &context(&self.config, &self.factory, &self.fusion);
        let (pose, rows) = self.fusion.rows(context).ok_or(MotionError::NotLocked)?;
        let noise = self.fusion.noise() * T::lit(TRACK_NOISE) / context.focal;
        let change = LensCorrection::NONE.change_to(self.fusion.reference().correction());
        let Some(found) = fit.advance(&Views { pose: pose.rotations(), change, noise }, tracked)?
        else {
            return Ok(None);
        };
        let most = T::lit(MAX_CONFIRMED_YAW_RAD);
        if !(found.variance <= most * most) {
            return Err(MotionError::NoMotion);
        }
        let witnessed =
            self.fusion.mount_mut().witness(rows.turn + found.turn, found.variance, &rows, context);
        let [_, count] = &mut self.contradicting;
        count_contradiction(count, witnessed);
        let witnessed = witnessed.ok_or(MotionError::Contradicts)?;
        self.next = None;
        Ok(Some(witnessed))
    }
}

/// Counts a measurement that contradicts the yaw: it is refused, or it waits.
fn count_contradiction(count: &mut u16, witnessed: Option<Witnessed>) {
    let contradicts = witnessed != Some(Witnessed::Taken);
    *count = count.saturating_add(contradicts.into());
}
