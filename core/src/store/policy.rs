//! When what was learnt is worth a save.

use core::time::Duration;

use super::error::PolicyError;
use crate::algebra::information::StandardDeviations;
use crate::calibrator::Calibrator;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::metrics::{baseline_angle, rotation_angle};
use crate::outcome::proposal::Proposal;
use crate::scalar::Scalar;
use crate::state::State;

/// Why it is time to save.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveReason {
    /// The calibrator is locked, and what was saved last was not, or nothing was.
    Locked,
    /// Other extrinsics are in use.
    InUse,
    /// The locked estimate has moved by more than its own claimed deviation, in `R` or in `t`.
    Moved,
    /// Something was fused into the locked estimate, and the longest interval is over.
    Overdue,
}

/// What was saved last.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Saved<T: Scalar> {
    state: State,
    generation: u32,
    estimate: Option<Estimate<T>>,
}

/// What of a proposal counts here.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Estimate<T: Scalar> {
    extrinsics: Extrinsics<T>,
    pairs: u32,
    sd: StandardDeviations<T>,
}

impl<T: Scalar> Estimate<T> {
    /// Out of line: a whole proposal is not to stay on the stack. Borrowed: nor is a second one.
    #[inline(never)]
    fn of<const N: usize>(calibrator: &Calibrator<T, N>) -> Option<Self> {
        let proposal = calibrator.proposal();
        let Proposal { extrinsics, pairs, sd, .. } = proposal.as_ref()?;
        Some(Self { extrinsics: *extrinsics, pairs: *pairs, sd: *sd })
    }

    /// By more than its own claimed deviation, in `R` or in `t`.
    #[inline(never)]
    fn has_moved_from(&self, old: &Extrinsics<T>) -> bool {
        let Self { extrinsics: new, sd, .. } = self;
        rotation_angle(new.rotation(), old.rotation()) > sd.rotation
            || baseline_angle(new.translation(), old.translation()) > sd.translation
    }
}

/// Says when to save, at most once in the shortest interval. It has no clock: time is a [`Duration`]
/// since any origin, the same for all calls.
///
/// A clock that stands still permits no save but the first; one that goes back begins the intervals anew.
///
/// ```
/// use core::time::Duration;
/// use stereo_selfcal::store::SavePolicy;
/// # fn main() -> Result<(), stereo_selfcal::store::PolicyError> {
/// let mut policy = SavePolicy::<f32>::new().with_shortest_interval(Duration::from_secs(60))?;
/// # let calibrator = stereo_selfcal::Calibrator::<f32, 16>::new(Default::default());
/// # let (now, saved_well) = (Duration::ZERO, true);
/// // After each pair. At start, if a record was restored: `policy.restored(&calibrator)`.
/// if let Some(reason) = policy.due(&calibrator, now) {
///     // Save. Where that fails, nothing more to do: it is due again after the shortest interval.
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
    /// When it was last due, or saved.
    last: Option<Duration>,
    saved: Option<Saved<T>>,
}

impl<T: Scalar> SavePolicy<T> {
    /// Shortest interval 10 minutes, longest 6 hours; nothing saved yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            shortest: Duration::from_secs(600),
            longest: Duration::from_secs(6 * 3600),
            last: None,
            saved: None,
        }
    }

    /// Least time between two saves, and between a save that failed and the next attempt. Default
    /// 10 minutes.
    ///
    /// Larger spares the flash; smaller loses less with the power.
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

    /// Time after which anything new is saved. Default 6 hours.
    ///
    /// Larger spares the flash; smaller keeps the sums behind the estimate fresher.
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

    /// Whether to save now, and why. Having said so, it says nothing for the shortest interval. The first
    /// time does not wait.
    ///
    /// An estimate that is not locked is no reason: what was confirmed before is worth more.
    #[inline(never)]
    pub fn due<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
    ) -> Option<SaveReason> {
        self.last = self.last.map(|last| last.min(now));
        // In nanoseconds: to subtract a `Duration` can panic for all that the compiler knows.
        let since = self.last.map(|last| now.as_nanos().saturating_sub(last.as_nanos()));
        if since.is_some_and(|since| since < self.shortest.as_nanos()) {
            return None;
        }
        let overdue = since.is_none_or(|since| since >= self.longest.as_nanos());
        let reason = self.reason(calibrator, overdue)?;
        self.last = Some(now);
        Some(reason)
    }

    /// Notes that the store holds what the calibrator is now.
    pub fn saved<const N: usize>(&mut self, calibrator: &Calibrator<T, N>, now: Duration) {
        self.restored(calibrator);
        self.last = Some(now);
    }

    /// Notes that the calibrator is now what the store holds. The next save does not wait.
    #[inline(never)]
    pub fn restored<const N: usize>(&mut self, calibrator: &Calibrator<T, N>) {
        let estimate = Estimate::of(calibrator);
        let (state, generation) = (calibrator.state(), calibrator.generation());
        self.saved = Some(Saved { state, generation, estimate });
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
