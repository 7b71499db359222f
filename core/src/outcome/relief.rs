//! Evidence of depth in scenes whose matches all have the same motion between the images. A far scene shows depth
//! before it shows a baseline direction; the same image on both sides never does (`ESTIMATOR.md`, section 16).

use crate::scalar::Scalar;
use crate::thresholds::{RELIEF_DECAY, RELIEF_KEPT, RELIEF_SHARE, RELIEF_SHOWN};

/// A test over the last pairs: whether the motions of their matches differ more along rows than across them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Relief<T> {
    /// Faded sum of the scores of the matches, each from -1 (across rows) to 1 (along rows).
    excess: T,
    /// Faded number of the matches.
    matches: T,
}

impl<T: Scalar> Relief<T> {
    pub(crate) const NONE: Self = Self { excess: T::ZERO, matches: T::ZERO };

    /// Adds a pair, given as the sum of the scores of its matches and their number.
    pub(crate) fn add(&mut self, [excess, matches]: [T; 2]) {
        let decay = T::lit(RELIEF_DECAY);
        self.excess = self.excess * decay + excess;
        self.matches = self.matches * decay + matches;
    }

    /// Returns whether depth is shown: neither chance nor a small share of mismatches along rows explains the excess.
    pub(crate) fn is_shown(&self) -> bool {
        let by_chance = T::lit(RELIEF_SHOWN) * (self.matches * T::HALF).sqrt();
        self.excess > by_chance.max(T::lit(RELIEF_SHARE) * self.matches)
    }

    /// Returns the test after a restart. If depth was shown before, the test starts with [`RELIEF_KEPT`] matches that
    /// show it. Some 2,000 matches without depth outweigh this number.
    pub(crate) fn kept(is_shown: bool) -> Self {
        if !is_shown {
            return Self::NONE;
        }
        let matches = T::lit(RELIEF_KEPT);
        Self { excess: matches, matches }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_excess_beyond_chance_shows_depth_and_fades_without_further_excess() {
        let mut relief = Relief::<f32>::NONE;
        assert!(!relief.is_shown());
        relief.add([55.0, 250.0]);
        assert!(!relief.is_shown());
        relief.add([42.0, 250.0]);
        assert!(relief.is_shown());
        // From here on, the pairs have noise alone.
        let pairs = (1..100).find(|_| {
            relief.add([0.0, 250.0]);
            !relief.is_shown()
        });
        assert!(pairs.is_some_and(|pairs| pairs < 10), "{pairs:?}");
    }

    #[test]
    fn mismatches_along_rows_are_not_depth_however_many_pairs_have_them() {
        let mut relief = Relief::<f64>::NONE;
        (0..1000).for_each(|_| relief.add([0.04 * 250.0, 250.0]));
        assert!(!relief.is_shown());
    }

    #[test]
    fn a_restart_keeps_shown_depth_until_pairs_without_depth_revoke_it() {
        let mut kept = Relief::<f32>::kept(true);
        assert!(kept.is_shown() && !Relief::<f32>::kept(false).is_shown());
        (0..12).for_each(|_| kept.add([0.0, 250.0]));
        assert!(!kept.is_shown());
    }
}
