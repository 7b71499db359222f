//! Stable names of the reasons why a match, a pair, a range reading or a motion was not taken.

use std::collections::BTreeMap;

use serde::Serialize;
use stereo_selfcal::depth::{MotionError, RangeError, Witnessed};
use stereo_selfcal::geometry::{Side, UndistortError};
use stereo_selfcal::{PushError, Rejection};

/// Number of occurrences of each reason.
pub type CountByReason = BTreeMap<&'static str, usize>;

/// Number of each result of the measurements that determine the yaw of the mount, by name: taken, waiting, or the
/// reason of the refusal.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct WitnessCounts {
    /// Range readings.
    pub ranges: CountByReason,
    /// Sets of tracked matches.
    pub motion: CountByReason,
}

impl WitnessCounts {
    pub(super) fn add(&mut self, other: &Self) {
        let all = [(&mut self.ranges, &other.ranges), (&mut self.motion, &other.motion)];
        for (to, from) in all {
            for (name, count) in from {
                *to.entry(name).or_default() += count;
            }
        }
    }

    pub(super) fn note_range(&mut self, outcome: Result<Witnessed, RangeError>) {
        *self.ranges.entry(outcome.map_or_else(of_range, of_witnessed)).or_default() += 1;
    }

    pub(super) fn note_motion(&mut self, outcome: Result<Witnessed, MotionError>) {
        *self.motion.entry(outcome.map_or_else(of_motion, of_witnessed)).or_default() += 1;
    }
}

fn of_witnessed(witnessed: Witnessed) -> &'static str {
    match witnessed {
        Witnessed::Taken => "taken",
        Witnessed::Waiting => "waiting",
    }
}

fn of_range(why: RangeError) -> &'static str {
    match why {
        RangeError::NoBaseline => "no_baseline",
        RangeError::NotLocked => "not_locked",
        RangeError::Reading => "reading",
        RangeError::Pixel(_) => "pixel",
        RangeError::NoMatch => "no_match",
        RangeError::Contradicts => "contradicts",
        _ => "other",
    }
}

fn of_motion(why: MotionError) -> &'static str {
    match why {
        MotionError::NotLocked => "not_locked",
        MotionError::TooFew => "too_few",
        MotionError::NoMotion => "no_motion",
        MotionError::Contradicts => "contradicts",
        _ => "other",
    }
}

/// Name of the reason why a match was refused.
#[must_use]
pub fn of_match(why: PushError) -> &'static str {
    match why {
        PushError::Busy => "busy",
        PushError::Pixel(Side::Left, UndistortError::NotFinite) => "left_pixel_not_finite",
        PushError::Pixel(Side::Left, UndistortError::OutsideImage) => "left_pixel_outside_image",
        PushError::Pixel(Side::Left, UndistortError::NotInvertible) => "left_pixel_not_invertible",
        PushError::Pixel(Side::Right, UndistortError::NotFinite) => "right_pixel_not_finite",
        PushError::Pixel(Side::Right, UndistortError::OutsideImage) => "right_pixel_outside_image",
        PushError::Pixel(Side::Right, UndistortError::NotInvertible) => {
            "right_pixel_not_invertible"
        }
        PushError::Score => "score",
        PushError::GridStep => "grid_step",
        _ => "other",
    }
}

/// Name of the reason why a pair was not solved.
#[must_use]
pub fn of_unsolved(why: Rejection) -> &'static str {
    match why {
        Rejection::NotBegun => "not_begun",
        Rejection::TooFew { .. } => "too_few",
        Rejection::NoConsensus => "no_consensus",
        Rejection::Unobservable => "unobservable",
        Rejection::Behind => "behind",
        Rejection::Columns => "columns",
        Rejection::NoDepth => "no_depth",
        _ => "other",
    }
}

/// Name of the reason why a solved pair was not fused.
#[must_use]
pub fn of_refusal(why: Rejection) -> &'static str {
    match why {
        Rejection::TooUncertain => "too_uncertain",
        Rejection::CorrectionLimit => "correction_limit",
        Rejection::NoRig => "no_rig",
        Rejection::Disagrees => "disagrees",
        Rejection::NotBegun => "nothing_solved",
        Rejection::Frozen => "frozen",
        _ => "other",
    }
}

/// The reasons in words, the most frequent first.
#[must_use]
pub fn in_words(reasons: &CountByReason) -> String {
    let mut counts: Vec<_> = reasons.iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    let words = counts.iter().map(|(name, count)| format!("{} {count}", name.replace('_', " ")));
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_frequent_reason_comes_first_and_ties_by_name() {
        let reasons = CountByReason::from([("score", 2), ("grid_step", 2), ("no_cameras", 30)]);
        assert_eq!(in_words(&reasons), "no cameras 30, grid step 2, score 2");
    }

    #[test]
    fn every_reason_has_a_name_of_its_own() {
        let pixels = [Side::Left, Side::Right].into_iter().flat_map(|side| {
            [UndistortError::NotFinite, UndistortError::OutsideImage, UndistortError::NotInvertible]
                .map(|why| PushError::Pixel(side, why))
        });
        let rest = [PushError::Busy, PushError::Score, PushError::GridStep];
        let names: CountByReason = pixels.chain(rest).map(|why| (of_match(why), 1)).collect();
        assert_eq!(names.len(), 9);
        assert!(!names.contains_key("other"));

        let (usable, needed) = (1, 12);
        let unsolved = [
            Rejection::NotBegun,
            Rejection::TooFew { usable, needed },
            Rejection::NoConsensus,
            Rejection::Unobservable,
            Rejection::Behind,
            Rejection::Columns,
            Rejection::NoDepth,
        ];
        let refusals = [
            Rejection::TooUncertain,
            Rejection::CorrectionLimit,
            Rejection::NoRig,
            Rejection::Disagrees,
            Rejection::NotBegun,
            Rejection::Frozen,
        ];
        let unsolved = unsolved.map(of_unsolved).into_iter();
        let names: CountByReason =
            unsolved.chain(refusals.map(of_refusal)).map(|name| (name, 1)).collect();
        assert_eq!(names.len(), 13);
        assert!(!names.contains_key("other"));
    }
}
