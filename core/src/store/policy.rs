//! Policy: when to save the state.

use core::time::Duration;

use crate::algebra::information::StandardDeviations;
use crate::calibrator::Calibrator;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::metrics::{baseline_angle, rotation_angle};
use crate::outcome::proposal::Proposal;
use crate::scalar::Scalar;
use crate::state::State;

/// Why a save is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveReason {
    /// The calibrator is locked, and the last save, if any, was of an unlocked state.
    Locked,
    /// The calibration in use has changed.
    InUse,
    /// The locked estimate has moved by more than its standard deviation with the lens uncertain, in `R` or in `t`.
    Moved,
    /// The locked estimate has more pairs, and the last save is [`SavePolicy::OVERDUE`] intervals old.
    Overdue,
}

/// Calibrator at the last save.
#[derive(Debug, Clone, Copy)]
struct Saved<T: Scalar> {
    was_locked: bool,
    generation: u32,
    estimate: Option<Estimate<T>>,
}

/// Part of a proposal that the policy compares.
#[derive(Debug, Clone, Copy)]
struct Estimate<T: Scalar> {
    extrinsics: Extrinsics<T>,
    pairs: u32,
    sd: StandardDeviations<T>,
}

impl<T: Scalar> Estimate<T> {
    /// Out of line: a whole proposal stays off the caller's stack.
    #[inline(never)]
    fn of<const N: usize>(calibrator: &Calibrator<T, N>) -> Option<Self> {
        let proposal = calibrator.proposal();
        let Proposal { extrinsics, pairs, sd_lens, .. } = proposal.as_ref()?;
        Some(Self { extrinsics: *extrinsics, pairs: *pairs, sd: *sd_lens })
    }

    fn has_moved_from(&self, Self { extrinsics: old, .. }: &Self) -> bool {
        let Self { extrinsics: new, sd, .. } = self;
        rotation_angle(new.rotation(), old.rotation()) > sd.rotation
            || baseline_angle(new.translation(), old.translation()) > sd.translation
    }
}

/// Longest time that counts between two pairs, ns.
const LONGEST_STEP: u64 = 1_000_000_000;

/// Decides when to save: at most once an interval, whether the save succeeds or not. Time is a [`Duration`] since any
/// fixed origin.
///
/// Two saves are apart by the interval, and by as many pairs as the interval has seconds, whatever the clock does: a
/// pair counts for at most 1 s, and a step back is subtracted. A clock that stands still, or alternates between two
/// origins, permits only the first save.
///
/// The first save of a device does not wait. The first save after a restart waits, and a pair that only confirms the
/// restored state does not cause a save. A controller that resets within each interval saves once in all.
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
    /// Time of the last pair.
    last: Option<Duration>,
    /// Time counted since the last due or completed save or the restart, ns; `None` before the first.
    elapsed: Option<u64>,
    saved: Option<Saved<T>>,
}

impl<T: Scalar> SavePolicy<T> {
    /// Intervals after which any further pair causes a save.
    pub const OVERDUE: u32 = 36;

    /// A policy of a device that has never saved.
    ///
    /// * `interval`: least time between two saves. Ten minutes spare the flash for decades; smaller loses less when power
    ///   fails.
    #[must_use]
    pub const fn new(interval: Duration) -> Self {
        Self { interval, last: None, elapsed: None, saved: None }
    }

    /// Reason to save now, if any; then `None` for the interval. Call it once after each pair.
    ///
    /// A change of an estimate that is not locked does not cause a save: the confirmed one saved before is kept.
    ///
    /// * `now`: time since a fixed origin.
    #[inline(never)]
    pub fn due<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
    ) -> Option<SaveReason> {
        self.count(now);
        let interval = self.interval.as_nanos();
        let has_passed = |intervals: u32| {
            let least = interval.saturating_mul(intervals.into());
            self.elapsed.is_none_or(|elapsed| u128::from(elapsed) >= least)
        };
        if !has_passed(1) {
            return None;
        }
        let reason = self.reason(calibrator, has_passed(Self::OVERDUE))?;
        self.elapsed = Some(0);
        Some(reason)
    }

    /// Counts the time since the last pair.
    fn count(&mut self, now: Duration) {
        // In nanoseconds: subtraction of `Duration` compiles to a reachable panic.
        let [now_ns, last] = [now, self.last.unwrap_or(now)].map(|time| time.as_nanos());
        let step =
            u64::try_from(now_ns.abs_diff(last)).map_or(LONGEST_STEP, |ns| ns.min(LONGEST_STEP));
        self.last = Some(now);
        self.elapsed = self.elapsed.map(|elapsed| {
            if now_ns < last { elapsed.saturating_sub(step) } else { elapsed.saturating_add(step) }
        });
    }

    /// Records that the present state of the calibrator has been saved.
    #[inline(never)]
    pub fn saved<const N: usize>(&mut self, calibrator: &Calibrator<T, N>, now: Duration) {
        let estimate = Estimate::of(calibrator);
        let was_locked = calibrator.state() == State::Locked;
        self.saved = Some(Saved { was_locked, generation: calibrator.generation, estimate });
        self.last = Some(now);
        self.elapsed = Some(0);
    }

    /// Records a restart with a state that was saved before, restored or lost: the next save waits for the interval.
    pub fn restarted<const N: usize>(&mut self, calibrator: &Calibrator<T, N>) {
        self.saved(calibrator, Duration::ZERO);
        self.last = None;
        // Re-locking after a restore triggers no save.
        if let Some(saved) = &mut self.saved {
            saved.was_locked = saved.estimate.is_some();
        }
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
        let new = Estimate::of(calibrator).filter(|_| is_locked)?;
        let old = saved.estimate.as_ref();
        if old.is_none_or(|old| new.has_moved_from(old)) {
            return Some(SaveReason::Moved);
        }
        (is_overdue && old.is_some_and(|old| new.pairs != old.pairs)).then_some(SaveReason::Overdue)
    }
}

impl<T: Scalar> Default for SavePolicy<T> {
    /// Ten minutes.
    fn default() -> Self {
        Self::new(Duration::from_secs(600))
    }
}
