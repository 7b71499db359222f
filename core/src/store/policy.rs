//! Policy: when to save the state.

use core::time::Duration;

use crate::calibrator::Calibrator;
use crate::fusion::prior::Place;
use crate::scalar::Scalar;
use crate::state::State;

/// Why a save is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveReason {
    /// The calibrator is locked, and nothing has been saved yet, or the last save was of an unlocked state. A restart
    /// counts as a save of a locked state if an estimate was restored, and of an unlocked state otherwise.
    Locked,
    /// The calibration in use has changed since the last save or restart.
    InUse,
    /// The locked estimate has moved in `R` or in `t` by more than its standard deviation and by more than 8.7e-4 rad
    /// (0.05 degrees), or the known yaw of the mount has moved by more than 8.7e-4 rad. The saved estimate would fit
    /// the next pair worse.
    Moved,
    /// The locked estimate has another number of pairs than at the last save, and that save is [`SavePolicy::OVERDUE`]
    /// intervals old.
    Overdue,
}

/// State of the calibrator at the last save or restart.
#[derive(Debug, Clone, Copy)]
struct Saved<T: Scalar> {
    was_locked: bool,
    generation: u32,
    place: Option<Place<T>>,
}

/// Longest time that counts between two pairs, ms.
const LONGEST_STEP: u64 = 1000;

/// Decides when to save: at most once per interval, whether the save succeeds or not. Time is a [`Duration`] since any
/// fixed origin.
///
/// Between two saves there is at least the interval, and at least one pair for each second of the interval, whatever
/// the clock does. Each pair counts for at most 1 s, and a backward step of the clock is subtracted. A clock that
/// stands still, or alternates between two origins, permits only the first save.
///
/// The first save of a device does not wait. The first save after a restart waits, and a pair that only confirms the
/// restored state does not cause a save. A controller that always resets within the interval saves only once.
///
/// ```
/// # use core::time::Duration;
/// use stereo_selfcal::store::SavePolicy;
/// # fn after_pair(calibrator: stereo_selfcal::Calibrator<f32, 16>, now: Duration, saved_well: bool) {
/// let mut policy = SavePolicy::<f32>::new(Duration::from_secs(600)); // `Store` has one of its own
/// if let Some(reason) = policy.due(&calibrator, now) {
///     // Save: `calibrator.snapshot()`.
///     # let _ = reason;
///     if saved_well {
///         policy.saved(&calibrator, now);
///     }
/// }
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct SavePolicy<T: Scalar> {
    interval: Duration,
    /// Time of the last pair, ms.
    last: Option<u64>,
    /// Time counted since the last due or completed save or since the restart, ms. At first the largest value, so that
    /// the first save does not wait.
    elapsed: u64,
    saved: Option<Saved<T>>,
}

impl<T: Scalar> SavePolicy<T> {
    /// Number of intervals after which any further fused pair of a locked estimate causes a save.
    pub const OVERDUE: u32 = 36;

    /// Returns the policy of a device that has never saved.
    ///
    /// * `interval`: least time between two saves. A larger interval spares the flash; a smaller one loses less when
    ///   power fails.
    #[must_use]
    pub const fn new(interval: Duration) -> Self {
        Self { interval, last: None, elapsed: u64::MAX, saved: None }
    }

    /// Returns the reason to save now, or `None` if no save is due. After a reason it returns `None` for one interval.
    /// Call it once after each pair.
    ///
    /// A change of an estimate that is not locked does not cause a save, so the flash keeps the last confirmed
    /// estimate.
    ///
    /// * `now`: time since a fixed origin.
    #[inline(never)]
    pub fn due<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
    ) -> Option<SaveReason> {
        let now = milliseconds(now);
        // The clock may have been set back.
        let last = self.last.replace(now).unwrap_or(now);
        let step = now.abs_diff(last).min(LONGEST_STEP);
        let elapsed = self.elapsed;
        self.elapsed =
            if now < last { elapsed.saturating_sub(step) } else { elapsed.saturating_add(step) };
        let interval = milliseconds(self.interval);
        if self.elapsed < interval {
            return None;
        }
        let is_overdue = self.elapsed >= interval.saturating_mul(Self::OVERDUE.into());
        let reason = self.reason(calibrator, is_overdue)?;
        self.elapsed = 0;
        Some(reason)
    }

    /// Records that the present state of the calibrator has been saved.
    #[inline(never)]
    pub fn saved<const N: usize>(&mut self, calibrator: &Calibrator<T, N>, now: Duration) {
        let was_locked = calibrator.state() == State::Locked;
        let place = calibrator.place();
        self.saved = Some(Saved { was_locked, generation: calibrator.generation, place });
        (self.last, self.elapsed) = (Some(milliseconds(now)), 0);
    }

    /// Records a restart of a device that has saved before, whether its state was restored or lost. The next save waits
    /// for the interval.
    pub fn restarted<const N: usize>(&mut self, calibrator: &Calibrator<T, N>) {
        self.saved(calibrator, Duration::ZERO);
        self.last = None;
        // If an estimate was restored, its confirmation does not cause a save.
        self.saved.iter_mut().for_each(|saved| saved.was_locked = saved.place.is_some());
    }

    fn reason<const N: usize>(
        &self,
        calibrator: &Calibrator<T, N>,
        is_overdue: bool,
    ) -> Option<SaveReason> {
        let is_locked = calibrator.state() == State::Locked;
        if is_locked && self.saved.is_none_or(|saved| !saved.was_locked) {
            return Some(SaveReason::Locked);
        }
        let saved = self.saved.as_ref()?;
        if calibrator.generation != saved.generation {
            return Some(SaveReason::InUse);
        }
        let new = calibrator.place().filter(|_| is_locked)?;
        let old = saved.place.as_ref();
        if old.is_none_or(|old| new.has_moved_from(old)) {
            return Some(SaveReason::Moved);
        }
        (is_overdue && old.is_some_and(|old| new.pairs != old.pairs)).then_some(SaveReason::Overdue)
    }
}

/// Converts a time to milliseconds. The operators of [`Duration`] would compile to a reachable panic.
fn milliseconds(time: Duration) -> u64 {
    time.as_secs().wrapping_mul(1000).wrapping_add(time.subsec_millis().into())
}

impl<T: Scalar> Default for SavePolicy<T> {
    /// Returns a policy with an interval of ten minutes.
    fn default() -> Self {
        Self::new(Duration::from_secs(600))
    }
}
