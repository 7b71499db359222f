//! History of a calibrator: one event for each change of its verdict or of the calibration in use, in a ring that the
//! caller owns. The calibrator knows nothing of it, and no record contains it.

use core::fmt;

use crate::outcome::verdict::Verdict;
use crate::scalar::Scalar;

/// Part of a calibrator's answers that an event reports as changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Change {
    /// The state of the estimate: [`Verdict::state`].
    State,
    /// The answer to an arming check: [`Verdict::may_arm`].
    Arming,
    /// Whether applying is worthwhile: [`Verdict::should_apply`].
    Applying,
    /// The reasons not to rely on the calibration in use: [`Verdict::reasons`].
    Reasons,
    /// The likeliest mistake in rig file or matcher: [`Verdict::cause`].
    Cause,
    /// The calibration in use: [`crate::Calibration::generation`].
    Generation,
}

// Each code is one bit, so that a set is a sum of codes.
codes! {
    Change { State = 1, Arming = 2, Applying = 4, Reasons = 8, Cause = 16, Generation = 32 }
}
texts! {
    Change {
        State = "state", Arming = "arming", Applying = "applying", Reasons = "reasons", Cause = "cause",
        Generation = "generation",
    }
}

impl Change {
    /// All changes, in the order of their codes.
    pub const ALL: [Self; 6] =
        [Self::State, Self::Arming, Self::Applying, Self::Reasons, Self::Cause, Self::Generation];
}

sets! {
    /// Set of [`Change`]s.
    Changes of Change;
}

/// A change of a calibrator, with the verdict and the generation after it. All events have the same size.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Event<T> {
    /// Time on the caller's clock, in the caller's unit.
    pub time: u64,
    /// Number of the pair, as the caller counts.
    pub pair: u32,
    /// The parts that differ from the event before.
    pub changes: Changes,
    /// Generation of the calibration in use.
    pub generation: u32,
    /// The verdict after the pair.
    pub verdict: Verdict<T>,
}

impl<T: Scalar> Event<T> {
    /// The state of a new calibrator, which the first event is compared with.
    pub const START: Self =
        Self { time: 0, pair: 0, changes: Changes::NONE, generation: 0, verdict: Verdict::NONE };

    /// Returns the event that follows this one; `None` if nothing has changed. The numbers of a verdict change with
    /// each pair, and are no change by themselves.
    ///
    /// * `time`: time on the caller's clock, in any unit.
    /// * `pair`: number of the pair.
    /// * `verdict`, `generation`: of the calibrator after the pair, or after a call that changes the calibration in use.
    #[must_use]
    pub fn next(
        &self,
        time: u64,
        pair: u32,
        verdict: &Verdict<T>,
        generation: u32,
    ) -> Option<Self> {
        let before = &self.verdict;
        let changes = Changes::NONE
            .with(Change::State, verdict.state != before.state)
            .with(Change::Arming, verdict.may_arm != before.may_arm)
            .with(Change::Applying, verdict.should_apply != before.should_apply)
            .with(Change::Reasons, verdict.reasons != before.reasons)
            .with(Change::Cause, verdict.cause != before.cause)
            .with(Change::Generation, generation != self.generation);
        let event = Self { time, pair, changes, generation, verdict: *verdict };
        (!changes.is_empty()).then_some(event)
    }
}

impl<T: Scalar> fmt::Display for Event<T> {
    /// Writes one line: `pair 3, arming, generation: locked, generation 1, rows 0.4 px, ..`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pair, changes, generation, verdict, .. } = self;
        write!(f, "pair {pair}, {changes}: {}, generation {generation}, {verdict}", verdict.state)
    }
}

/// The last `N` events of a calibrator.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::outcome::History;
/// use stereo_selfcal::{Calibrator, Correspondence};
///
/// /// Takes a pair, and logs what has changed.
/// fn take<const N: usize>(
///     rig: &mut Calibrator<f32, N>,
///     history: &mut History<f32, 32>,
///     matches: &[Correspondence<f32>],
///     (time_us, pair): (u64, u32),
/// ) {
///     let _ = rig.take_pair(matches.iter().copied());
///     if rig.verdict().should_apply {
///         let _ = rig.apply();
///     }
///     if let Some(event) = history.note(time_us, pair, rig.verdict(), rig.in_use().generation) {
///         log(&event);
///     }
/// }
/// # fn log(_: &dyn core::fmt::Display) {}
/// ```
#[derive(Debug, Clone)]
pub struct History<T, const N: usize> {
    events: [Event<T>; N],
    /// Place of the next event.
    place: usize,
    total: u32,
    last: Event<T>,
}

impl<T: Scalar, const N: usize> Default for History<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Scalar, const N: usize> History<T, N> {
    /// Returns the history of a new calibrator.
    #[must_use]
    pub const fn new() -> Self {
        Self { events: [Event::START; N], place: 0, total: 0, last: Event::START }
    }

    /// Compares a calibrator with the last event. A change is a new event, which replaces the oldest one of a full
    /// ring. Arguments and result as in [`Event::next`].
    pub fn note(
        &mut self,
        time: u64,
        pair: u32,
        verdict: &Verdict<T>,
        generation: u32,
    ) -> Option<Event<T>> {
        let event = self.last.next(time, pair, verdict, generation)?;
        self.last = event;
        if let Some(place) = self.events.get_mut(self.place) {
            *place = event;
        }
        self.place = self.place.wrapping_add(1);
        if self.place >= N {
            self.place = 0;
        }
        self.total = self.total.saturating_add(1);
        Some(event)
    }

    /// Returns the events of the ring, the oldest first.
    pub fn events(&self) -> impl Iterator<Item = &Event<T>> {
        let newer = self.events.get(..self.place).unwrap_or_default();
        let older = self.events.get(self.place..).unwrap_or_default();
        let held = usize::try_from(self.total).unwrap_or(usize::MAX);
        older.iter().chain(newer).skip(N.saturating_sub(held))
    }

    /// Returns the number of events so far, with those that newer ones have replaced; saturates.
    #[must_use]
    pub const fn total(&self) -> u32 {
        self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A verdict that may arm if `arms`.
    fn verdict(arms: bool) -> Verdict<f32> {
        Verdict { may_arm: arms, rows_px: 0.5, ..Verdict::NONE }
    }

    #[test]
    fn numbers_alone_are_no_event() {
        let mut history = History::<f32, 4>::new();
        assert_eq!(history.note(1, 0, &verdict(false), 0), None);
        assert_eq!((history.events().count(), history.total()), (0, 0));
    }

    #[test]
    fn an_event_has_the_time_the_pair_and_what_has_changed() {
        let mut history = History::<f32, 4>::new();
        let event = history.note(70, 7, &verdict(true), 1).unwrap();
        assert_eq!((event.time, event.pair, event.generation), (70, 7, 1));
        assert_eq!(event.changes.bits(), Change::Arming.code() | Change::Generation.code());
        assert!(event.changes.iter().eq([Change::Arming, Change::Generation]));
        assert_eq!(event.verdict, verdict(true));
        assert_eq!(history.note(80, 8, &verdict(true), 1), None);
    }

    #[test]
    fn a_full_ring_drops_the_oldest_events_and_counts_all() {
        let mut history = History::<f32, 3>::new();
        for pair in 0..8 {
            assert!(history.note(0, pair, &verdict(pair % 2 == 0), 0).is_some());
            let first = pair.saturating_sub(2);
            let held: heapless::Vec<u32, 8> = history.events().map(|event| event.pair).collect();
            let expected: heapless::Vec<u32, 8> = (first..=pair).collect();
            assert_eq!((held, history.total()), (expected, pair + 1));
        }
    }

    #[test]
    fn a_ring_of_no_events_still_tells_each_change() {
        let mut history = History::<f32, 0>::new();
        assert!(history.note(0, 0, &verdict(true), 0).is_some());
        assert_eq!(history.note(0, 1, &verdict(true), 0), None);
        assert_eq!((history.events().count(), history.total()), (0, 1));
    }

    #[test]
    fn an_event_of_a_vehicle_has_48_bytes() {
        assert_eq!(size_of::<Event<f32>>(), 48);
    }

    #[test]
    fn all_changes_are_in_the_order_of_their_codes_and_each_is_a_bit() {
        let bits = Change::ALL.iter().map(Change::code);
        assert!(bits.eq((0..6).map(|bit| 1 << bit)));
    }
}
