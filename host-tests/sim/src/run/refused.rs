//! Names of the reasons why a match, a pair, a range reading or a motion was not taken: those of the core's variants in
//! snake case.

use std::collections::BTreeMap;
use std::fmt::Debug;

use serde::Serialize;
use stereo_selfcal::depth::Witnessed;
use stereo_selfcal::{PushError, Rejection};

/// Number of occurrences of each reason.
pub type CountByReason = BTreeMap<String, usize>;

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
        add(&mut self.ranges, &other.ranges);
        add(&mut self.motion, &other.motion);
    }
}

/// Adds counts to others.
pub(super) fn add(to: &mut CountByReason, from: &CountByReason) {
    for (name, count) in from {
        *to.entry(name.clone()).or_default() += count;
    }
}

/// Counts the result of a measurement.
pub(super) fn note<E: Debug>(counts: &mut CountByReason, outcome: &Result<Witnessed, E>) {
    let name = outcome.as_ref().map_or_else(snake_case, snake_case);
    *counts.entry(name).or_default() += 1;
}

/// Name of a variant in snake case: `too_few` of `TooFew { usable: 3, needed: 12 }`.
pub fn snake_case(of: &impl Debug) -> String {
    let text = format!("{of:?}");
    let name = text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    let split =
        |c: char| c.is_uppercase().then_some('_').into_iter().chain([c.to_ascii_lowercase()]);
    name.chars().flat_map(split).skip(1).collect()
}

/// Name of the reason why a match was refused.
pub fn of_match(why: PushError) -> String {
    match why {
        PushError::Pixel(side, why) => format!("{}_pixel_{}", snake_case(&side), snake_case(&why)),
        other => snake_case(&other),
    }
}

/// Name of the reason why a solved pair was not fused.
pub fn of_refusal(why: Rejection) -> String {
    if why == Rejection::NotBegun { "nothing_solved".into() } else { snake_case(&why) }
}

/// The reasons in words, the most frequent first.
pub fn in_words(reasons: &CountByReason) -> String {
    let mut counts: Vec<_> = reasons.iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    let words = counts.iter().map(|(name, count)| format!("{} {count}", name.replace('_', " ")));
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use stereo_selfcal::geometry::{Side, UndistortError};

    #[test]
    fn the_most_frequent_reason_comes_first_and_ties_by_name() {
        let reasons = [("score", 2), ("grid_step", 2), ("no_cameras", 30)];
        let reasons = reasons.map(|(name, count)| (name.to_owned(), count)).into();
        assert_eq!(in_words(&reasons), "no cameras 30, grid step 2, score 2");
    }

    #[test]
    fn names_of_reasons_are_stable() {
        let pixel = PushError::Pixel(Side::Left, UndistortError::OutsideImage);
        assert_eq!(of_match(pixel), "left_pixel_outside_image");
        assert_eq!(of_match(PushError::GridStep), "grid_step");
        assert_eq!(snake_case(&Rejection::TooFew { usable: 1, needed: 12 }), "too_few");
        assert_eq!(of_refusal(Rejection::CorrectionLimit), "correction_limit");
        assert_eq!(of_refusal(Rejection::NotBegun), "nothing_solved");
    }
}
