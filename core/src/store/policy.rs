//! Policy: when to save the calibrator state.

use core::time::Duration;

use super::error::PolicyError;
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
    /// The calibrator is locked, and the last save was not of a locked state, or there was none.
    Locked,
    /// The extrinsics in use have changed.
    InUse,
    /// The locked estimate has moved by more than its reported standard deviation, in `R` or in `t`.
    Moved,
    /// The locked estimate has changed, and the longest interval has passed.
    Overdue,
}

/// Calibrator at the last save.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Saved<T: Scalar> {
    state: State,
    generation: u32,
    estimate: Option<Estimate<T>>,
}

/// Part of a proposal that the policy compares.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Estimate<T: Scalar> {
    extrinsics: Extrinsics<T>,
    pairs: u32,
    sd: StandardDeviations<T>,
}

impl<T: Scalar> Estimate<T> {
    /// Out of line: keeps a whole proposal off the caller's stack.
    #[inline(never)]
    fn of<const N: usize>(calibrator: &Calibrator<T, N>) -> Option<Self> {
        let proposal = calibrator.proposal();
        let Proposal { extrinsics, pairs, sd, .. } = proposal.as_ref()?;
        Some(Self { extrinsics: *extrinsics, pairs: *pairs, sd: *sd })
    }

    /// Whether it differs by more than its reported standard deviation, in `R` or in `t`.
    #[inline(never)]
    fn has_moved_from(&self, old: &Extrinsics<T>) -> bool {
        let Self { extrinsics: new, sd, .. } = self;
        rotation_angle(new.rotation(), old.rotation()) > sd.rotation
            || baseline_angle(new.translation(), old.translation()) > sd.translation
    }
}

/// Longest time that counts between two pairs, ns.
const LONGEST_STEP: u64 = 1_000_000_000;

/// Decides when to save, at most once per shortest interval. Time is an argument: a [`Duration`] since any
/// fixed origin.
///
/// Two saves are apart by the shortest interval, and by as many pairs as the interval has seconds, whatever
/// the clock does: a pair counts for at most 1 s, and a step back takes as much away. With 600 s: at most one save
/// in 600 pairs. A clock that stands still, or alternates between two origins, permits only the first save.
///
/// The first save does not wait; after a restore it does, and what a pair only confirms is no news. A controller
/// that is reset sooner than that saves once in all. Below one pair a second the intervals are longer.
///
/// ```
/// use core::time::Duration;
/// use stereo_selfcal::store::SavePolicy;
/// # fn main() -> Result<(), stereo_selfcal::store::PolicyError> {
/// let mut policy = SavePolicy::<f32>::new().with_shortest_interval(Duration::from_secs(60))?;
/// # let calibrator = stereo_selfcal::Calibrator::<f32, 16>::new(Default::default());
/// # let (now, saved_well) = (Duration::ZERO, true);
/// // After each pair. At start, after a restore: `policy.restored(&calibrator)`.
/// if let Some(reason) = policy.due(&calibrator, now) {
///     // Save. After a failure it is due again after the shortest interval.
///     # let _ = reason;
///     if saved_well {
///         policy.saved(&calibrator, now);
///     }
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct SavePolicy<T: Scalar> {
    shortest: Duration,
    longest: Duration,
    /// Time of the last pair.
    last: Option<Duration>,
    /// Time counted since the last due or completed save or the restore, ns; none before the first.
    elapsed: Option<u64>,
    saved: Option<Saved<T>>,
}

impl<T: Scalar> SavePolicy<T> {
    /// Default policy: shortest interval 10 minutes, longest 6 hours.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            shortest: Duration::from_secs(600),
            longest: Duration::from_secs(6 * 3600),
            last: None,
            elapsed: None,
            saved: None,
        }
    }

    /// Sets the shortest interval: least time between two saves, and before a failed save is repeated.
    /// Default 10 minutes.
    ///
    /// Larger spares the flash; smaller loses less when power fails.
    ///
    /// # Errors
    /// [`PolicyError::ShortestInterval`] unless above 0 and at most the longest.
    pub const fn with_shortest_interval(mut self, time: Duration) -> Result<Self, PolicyError> {
        if !time.is_zero() && time.as_nanos() <= self.longest.as_nanos() {
            self.shortest = time;
            Ok(self)
        } else {
            Err(PolicyError::ShortestInterval)
        }
    }

    /// Sets the longest interval: time after which any change is saved. Default 6 hours.
    ///
    /// Larger spares the flash; smaller keeps the saved sums of the estimate more recent.
    ///
    /// # Errors
    /// [`PolicyError::LongestInterval`] below the shortest.
    pub const fn with_longest_interval(mut self, time: Duration) -> Result<Self, PolicyError> {
        if time.as_nanos() >= self.shortest.as_nanos() {
            self.longest = time;
            Ok(self)
        } else {
            Err(PolicyError::LongestInterval)
        }
    }

    /// Reason to save now, if any; then none for the shortest interval. Call it once after each pair.
    ///
    /// A change of an estimate that is not locked is no reason: the confirmed one saved before is kept.
    ///
    /// * `now`: time since a fixed origin.
    #[inline(never)]
    pub fn due<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
    ) -> Option<SaveReason> {
        self.count(now);
        let has_passed = |interval: Duration| {
            self.elapsed.is_none_or(|elapsed| u128::from(elapsed) >= interval.as_nanos())
        };
        if !has_passed(self.shortest) {
            return None;
        }
        let overdue = has_passed(self.longest);
        let reason = self.reason(calibrator, overdue)?;
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

    /// Records that the store holds the present state of the calibrator.
    #[inline(never)]
    pub fn saved<const N: usize>(&mut self, calibrator: &Calibrator<T, N>, now: Duration) {
        let estimate = Estimate::of(calibrator);
        let (state, generation) = (calibrator.state(), calibrator.generation());
        self.saved = Some(Saved { state, generation, estimate });
        self.last = Some(now);
        self.elapsed = Some(0);
    }

    /// Records that the calibrator was restored from the store. The next save waits for the shortest interval.
    pub fn restored<const N: usize>(&mut self, calibrator: &Calibrator<T, N>) {
        self.saved(calibrator, Duration::ZERO);
        self.last = None;
        // Suspect by the restore alone: its confirmation is no news.
        if let Some(saved) = self.saved.as_mut().filter(|saved| saved.state == State::Suspect) {
            saved.state = State::Locked;
        }
    }

    /// The store holds a state that may not be restored: the first save waits as after a restore.
    pub(super) const fn wait(&mut self) {
        self.elapsed = Some(0);
    }

    fn reason<const N: usize>(
        &self,
        calibrator: &Calibrator<T, N>,
        overdue: bool,
    ) -> Option<SaveReason> {
        let locked = calibrator.state() == State::Locked;
        let Some(saved) = &self.saved else { return locked.then_some(SaveReason::Locked) };
        if locked && saved.state != State::Locked {
            return Some(SaveReason::Locked);
        }
        if calibrator.generation() != saved.generation {
            return Some(SaveReason::InUse);
        }
        let new = Estimate::of(calibrator).filter(|_| locked)?;
        let Some(old) = &saved.estimate else { return Some(SaveReason::Moved) };
        if new.has_moved_from(&old.extrinsics) {
            return Some(SaveReason::Moved);
        }
        let has_news = new.pairs != old.pairs || new.extrinsics != old.extrinsics;
        (overdue && has_news).then_some(SaveReason::Overdue)
    }
}

impl<T: Scalar> Default for SavePolicy<T> {
    fn default() -> Self {
        Self::new()
    }
}
