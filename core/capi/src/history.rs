//! Events: the changes of a calibrator, in structs that the caller keeps.

use stereo_selfcal::Verdict;
use stereo_selfcal::outcome::Event;
use zerocopy::FromBytes;

use crate::error::{selfcal_error_t, status};
use crate::estimate::selfcal_state_t;
use crate::instance::{selfcal_t, shared};
use crate::pointer::{Out, read};
use crate::verdict::{bits, selfcal_cause_t};

/// Part of a calibrator's answers that an event reports as changed: a bit of `changes`.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_change_t {
    /// The state of the estimate.
    SELFCAL_CHANGE_STATE = 1,
    /// The answer to an arming check.
    SELFCAL_CHANGE_ARMING = 2,
    /// Whether `selfcal_apply` is worthwhile.
    SELFCAL_CHANGE_APPLYING = 4,
    /// The reasons not to rely on the calibration in use.
    SELFCAL_CHANGE_REASONS = 8,
    /// The likeliest mistake in rig file or matcher.
    SELFCAL_CHANGE_CAUSE = 16,
    /// The calibration in use.
    SELFCAL_CHANGE_GENERATION = 32,
}

/// A change of a calibrator, with the verdict and the generation after it. All members are plain numbers, so an event
/// can be kept in any memory and sent over any wire. A struct of zeros stands for a new calibrator.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, FromBytes)]
pub struct selfcal_event_t {
    /// Time on the caller's clock, in the caller's unit.
    pub time: u64,
    /// Number of the pair, as the caller counts.
    pub pair: u32,
    /// Parts that differ from the event before: sum of `selfcal_change_t`.
    pub changes: u32,
    /// Generation of the calibration in use.
    pub generation: u32,
    /// State of the estimate, a `selfcal_state_t`.
    pub state: u32,
    /// Sum of `selfcal_reason_t`.
    pub reasons: u32,
    /// A `selfcal_cause_t`.
    pub cause: u32,
    /// Answer to an arming check, 0 or 1.
    pub may_arm: u32,
    /// Whether `selfcal_apply` is worthwhile, 0 or 1.
    pub should_apply: u32,
    /// Numbers of the verdict, as in `selfcal_verdict_t`.
    pub rows_px: f32,
    /// As in `selfcal_verdict_t`.
    pub depth_px: f32,
    /// As in `selfcal_verdict_t`.
    pub coverage: f32,
    /// As in `selfcal_verdict_t`.
    pub image_coverage: f32,
}

impl selfcal_event_t {
    fn of(time: u64, pair: u32, verdict: &Verdict<f32>, generation: u32) -> Self {
        Self {
            time,
            pair,
            changes: 0,
            generation,
            state: selfcal_state_t::from(verdict.state) as u32,
            reasons: bits(verdict.reasons),
            cause: selfcal_cause_t::from(verdict.cause) as u32,
            may_arm: verdict.may_arm.into(),
            should_apply: verdict.should_apply.into(),
            rows_px: verdict.rows_px,
            depth_px: verdict.depth_px,
            coverage: verdict.coverage,
            image_coverage: verdict.image_coverage,
        }
    }

    /// Returns the sum of the changes since an earlier event.
    fn changes_since(&self, before: &Self) -> u32 {
        use selfcal_change_t::*;
        let all = [
            (SELFCAL_CHANGE_STATE, self.state != before.state),
            (SELFCAL_CHANGE_ARMING, self.may_arm != before.may_arm),
            (SELFCAL_CHANGE_APPLYING, self.should_apply != before.should_apply),
            (SELFCAL_CHANGE_REASONS, self.reasons != before.reasons),
            (SELFCAL_CHANGE_CAUSE, self.cause != before.cause),
            (SELFCAL_CHANGE_GENERATION, self.generation != before.generation),
        ];
        let changed = all.into_iter().filter(|(_, changed)| *changed);
        changed.fold(0, |sum, (change, _)| sum | change as u32)
    }
}

/// Compares a calibrator with its last event, and replaces the event if anything has changed. Call it after each pair,
/// after `selfcal_apply` if that is called. The caller keeps the events, for instance the last 32 in a ring:
///
/// ```c
/// static selfcal_event_t event, ring[32];
/// static uint32_t count;
///
/// if (selfcal_event(&cal, time_us, pair, &event, &is_new) == SELFCAL_OK && is_new)
///     ring[count++ % 32] = event;
/// ```
///
/// * `time`: time on the caller's clock, in any unit.
/// * `pair`: number of the pair.
/// * `event`: the last event; zeros before the first one.
/// * `is_new`: whether `event` is a new event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_event(
    cal: *const selfcal_t,
    time: u64,
    pair: u32,
    event: *mut selfcal_event_t,
    is_new: *mut bool,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, last, place, is_new) =
            unsafe { (shared(cal)?, read(event)?, Out::checked(event)?, Out::checked(is_new)?) };
        let of = |verdict, generation| selfcal_event_t::of(time, pair, verdict, generation);
        let last = if last.state == 0 { of(&Event::START.verdict, 0) } else { last };
        let calibrator = &instance.calibrator;
        let now = of(calibrator.verdict(), calibrator.in_use().generation);
        let changes = now.changes_since(&last);
        is_new.set(changes != 0);
        if changes != 0 {
            place.set(selfcal_event_t { changes, ..now });
        }
        Ok(())
    })
}
