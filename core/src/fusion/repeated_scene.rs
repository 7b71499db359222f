//! Detection of repeated scenes (`ESTIMATOR.md`, section 14). A standing vehicle may send the same matches for minutes,
//! outliers included. All these pairs together count as one measurement.

use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;
use crate::thresholds::{
    COPIED_SHARE, REMEMBERED, REMEMBERED_STEPS_PER_PX, SAME_SHARE, SAME_STEPS,
};

/// Relation of a pair to the scene of the last fused pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Seen {
    /// Another scene.
    New,
    /// The same scene, measured again.
    Repeated,
    /// The same scene, with nearly all matches at the same coordinates in steps of a quarter of a pixel: a copy of the
    /// last fused pair.
    Copied,
}

impl Seen {
    /// Returns whether the pair adds no information, as a repeated scene or a copy.
    pub(super) fn is_repeated(self) -> bool {
        self != Self::New
    }
}

/// Sampled correspondences of the last fused pair. RAM: 6 bytes per sample.
#[derive(Debug, Clone)]
pub(super) struct RepeatedScene {
    remembered: Sampled,
}

/// Samples. The length has 8 bits, so that the slice has a valid size even if a fault has overwritten the length.
type Sampled = heapless::Vec<[u16; 3], REMEMBERED, u8>;

impl RepeatedScene {
    pub(super) const NEW: Self = Self { remembered: heapless::Vec::new() };

    /// Returns whether the length is within the capacity.
    pub(super) fn is_within(&self) -> bool {
        self.remembered.len() <= REMEMBERED
    }

    /// Compares a batch with the scene of the last fused pair.
    #[inline(never)]
    pub(super) fn compare<T: Scalar>(&self, pairs: &[RayPair<T>], focal: T) -> Seen {
        let scale = focal * T::lit(REMEMBERED_STEPS_PER_PX);
        let [again, copied] = self.seen_again(pairs, scale);
        let is_most =
            |seen, share| seen > 0 && T::count(seen) > T::lit(share) * count(self.remembered.len());
        if is_most(copied, COPIED_SHARE) {
            Seen::Copied
        } else if is_most(again, SAME_SHARE) {
            Seen::Repeated
        } else {
            Seen::New
        }
    }

    /// Remembers the batch of a fused pair.
    #[inline(never)]
    pub(super) fn remember<T: Scalar>(&mut self, pairs: &[RayPair<T>], focal: T) {
        let scale = focal * T::lit(REMEMBERED_STEPS_PER_PX);
        self.remembered.clear();
        let stride = pairs.len().div_ceil(REMEMBERED).max(1);
        for pair in pairs.iter().step_by(stride) {
            // With this stride the samples fit the capacity.
            let _ = self.remembered.push(coordinates(pair, scale));
        }
    }

    /// Returns the number of remembered correspondences that a batch contains, and the number whose coordinates are the
    /// same in whole steps.
    ///
    /// * `scale`: coordinate steps per unit at unit depth.
    fn seen_again<T: Scalar>(&self, pairs: &[RayPair<T>], scale: T) -> [u32; 2] {
        if self.remembered.is_empty() {
            return [0; 2];
        }
        let columns = Buckets::of(self.remembered.iter().map(|[column, ..]| *column));
        let rows = Buckets::of(self.remembered.iter().map(|[_, row, _]| *row));
        let [mut seen, mut copied] = [0_u32; 2];
        for pair in pairs {
            let mut left = columns.near(steps(pair.left.x, scale)) & !copied;
            if left == 0 {
                continue;
            }
            left &= rows.near(steps(pair.left.y, scale));
            if left == 0 {
                continue;
            }
            let new = coordinates(pair, scale);
            while left != 0 {
                let place = left.trailing_zeros();
                left &= left - 1;
                let old = usize::try_from(place).ok().and_then(|place| self.remembered.get(place));
                let same = |old: &&[u16; 3]| {
                    new.iter().zip(*old).all(|(a, b)| a.abs_diff(*b) <= SAME_STEPS)
                };
                let Some(old) = old.filter(same) else { continue };
                let bit = 1_u32.checked_shl(place).unwrap_or(0);
                seen |= bit;
                if new == *old {
                    copied |= bit;
                }
            }
        }
        [seen.count_ones(), copied.count_ones()]
    }

    pub(super) fn clear(&mut self) {
        self.remembered.clear();
    }
}

/// Remembered correspondences by one coordinate, in 16 buckets of 8 px that repeat every 128 px. Each bucket is a set
/// with one bit per correspondence.
struct Buckets([u32; 16]);

impl Buckets {
    #[inline(never)]
    fn of(remembered: impl Iterator<Item = u16>) -> Self {
        let mut buckets = Self([0; 16]);
        for (steps, place) in remembered.zip(0_u32..) {
            // Enters both ends of the tolerance interval, which is narrower than a bucket.
            for end in [steps.saturating_sub(SAME_STEPS), steps.saturating_add(SAME_STEPS)] {
                if let Some(bucket) = buckets.0.get_mut(Self::of_coordinate(end)) {
                    *bucket |= 1_u32.checked_shl(place).unwrap_or(0);
                }
            }
        }
        buckets
    }

    /// Returns the remembered correspondences that may be within the tolerance of a coordinate.
    fn near(&self, steps: u16) -> u32 {
        self.0.get(Self::of_coordinate(steps)).copied().unwrap_or(0)
    }

    fn of_coordinate(steps: u16) -> usize {
        usize::from((steps >> 5) & 15)
    }
}

/// Returns left column, left row and right column in quantisation steps ([`steps`]). The right row is omitted, because
/// it nearly equals the left row.
fn coordinates<T: Scalar>(pair: &RayPair<T>, scale: T) -> [u16; 3] {
    let ([a, b], [c, _]) = (pair.left(), pair.right());
    [steps(a, scale), steps(b, scale), steps(c, scale)]
}

/// Returns a coordinate of a ray at unit depth, in quantisation steps plus 32,768, so that no image has a negative
/// number.
///
/// * `scale`: steps per unit at unit depth.
fn steps<T: Scalar>(x: T, scale: T) -> u16 {
    (x * scale + T::lit(32_768.0)).to_u16()
}

fn count<T: Scalar>(n: usize) -> T {
    T::count(u32::try_from(n).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::vec::Vec;

    const FOCAL: f32 = 1400.0;

    impl RepeatedScene {
        /// Compares a pair and remembers it. Returns whether the pair repeats the previous one.
        fn takes(&mut self, pairs: &[RayPair<f32>], focal: f32) -> bool {
            let seen = self.compare(pairs, focal);
            self.remember(pairs, focal);
            seen.is_repeated()
        }
    }

    fn scene(n: usize, seed: u64) -> Vec<[f32; 4]> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut one = || {
            let [x, y] = [rng.random_range(-0.7..0.7), rng.random_range(-0.4..0.4)];
            [x, y, x - rng.random_range(0.0..0.2), y]
        };
        (0..n).map(|_| one()).collect()
    }

    /// Returns the rays of a scene, with all coordinates shifted by `shift_px` and with uniform noise of up to
    /// `noise_px` on each.
    fn rays(scene: &[[f32; 4]], shift_px: f32, noise_px: f32, seed: u64) -> Vec<RayPair<f32>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let ray = |at: &[f32; 4]| {
            let noisy = |x: f32| x + (shift_px + rng.random_range(-noise_px..=noise_px)) / FOCAL;
            let [a, b, c, d] = at.map(noisy);
            RayPair::try_new([a, b], [c, d]).unwrap()
        };
        scene.iter().map(ray).collect()
    }

    #[test]
    fn the_first_pair_repeats_nothing_and_the_same_scene_with_noise_does() {
        for n in [1, 20, 32, 33, 200, 256] {
            let scene = scene(n, 1);
            let mut repeated_scene = RepeatedScene::NEW;
            assert!(!repeated_scene.takes(&rays(&scene, 0.0, 0.5, 0), FOCAL));
            for seed in 1..20 {
                // Uniform noise of +-0.5 px has a standard deviation of 0.3 px.
                assert!(repeated_scene.takes(&rays(&scene, 0.0, 0.5, seed), FOCAL), "{n} {seed}");
            }
        }
    }

    #[test]
    fn a_scene_that_has_moved_or_changed_is_another() {
        let seen = scene(256, 2);
        let mut repeated_scene = RepeatedScene::NEW;
        for k in 0..20_u8 {
            // 4 px per pair is more than the tolerance of a coordinate.
            let moved = rays(&seen, 4.0 * f32::from(k), 0.5, k.into());
            assert!(!repeated_scene.takes(&moved, FOCAL), "{k}");
        }
        for seed in 3..50 {
            assert!(!repeated_scene.takes(&rays(&scene(256, seed), 0.0, 0.5, seed), FOCAL));
        }
    }

    /// Returns whether the second batch counts as the same scene as the first.
    fn repeats(first: &[[f32; 4]], second: &[RayPair<f32>]) -> bool {
        let mut repeated_scene = RepeatedScene::NEW;
        repeated_scene.takes(&rays(first, 0.0, 0.0, 0), FOCAL);
        repeated_scene.takes(second, FOCAL)
    }

    #[test]
    fn half_of_the_matches_seen_again_is_the_same_scene_and_a_fifth_is_another() {
        let (old, new) = (scene(200, 4), scene(200, 5));
        let again_with = |kept: usize| {
            let matches = old.iter().zip(&new).enumerate();
            let mixed: Vec<_> =
                matches.map(|(i, (old, new))| if i % 10 < kept { *old } else { *new }).collect();
            repeats(&old, &rays(&mixed, 0.0, 0.5, 1))
        };
        assert!(again_with(5));
        assert!(!again_with(2));
    }

    #[test]
    fn more_than_three_in_ten_seen_again_are_the_same_scene() {
        let (old, new) = (scene(10, 9), scene(10, 10));
        let again_with = |kept: usize| {
            let mixed: Vec<_> =
                old.iter().take(kept).chain(new.iter().skip(kept)).copied().collect();
            repeats(&old, &rays(&mixed, 0.0, 0.0, 0))
        };
        assert_eq!([3, 4].map(again_with), [false, true]);
    }

    #[test]
    fn the_order_of_matches_does_not_matter_and_only_the_last_pair_does() {
        let [old, new] = [6, 7].map(|seed| rays(&scene(256, seed), 0.0, 0.0, 0));
        let mut repeated_scene = RepeatedScene::NEW;
        repeated_scene.takes(&old, FOCAL);
        let backwards: Vec<_> = old.iter().rev().copied().collect();
        assert!(repeated_scene.takes(&backwards, FOCAL));
        assert!(!repeated_scene.takes(&new, FOCAL));
        assert!(!repeated_scene.takes(&old, FOCAL));
    }

    #[test]
    fn a_match_across_the_edge_of_a_bucket_is_seen_again() {
        for (side, shift) in [(0.1, -0.5), (-0.1, 0.5)] {
            let at_edges = |k: u8| (8.0 * f32::from(k) + side) / FOCAL;
            let seen = |k| [at_edges(k), 0.1, at_edges(k) - 0.05, 0.1];
            let seen: Vec<_> = (0..40).map(seen).collect();
            assert!(repeats(&seen, &rays(&seen, shift, 0.0, 0)), "{shift}");
        }
    }

    #[test]
    fn after_forgetting_nothing_is_repeated() {
        let pairs = rays(&scene(100, 8), 0.0, 0.0, 0);
        let mut repeated_scene = RepeatedScene::NEW;
        repeated_scene.takes(&pairs, FOCAL);
        repeated_scene.clear();
        assert!(!repeated_scene.takes(&pairs, FOCAL));
        assert!(repeated_scene.takes(&pairs, FOCAL));
        assert!(!repeated_scene.takes(&[], FOCAL));
        assert!(!repeated_scene.takes(&pairs, FOCAL));
    }

    #[test]
    fn a_pair_is_remembered_once_it_is_fused_however_often_it_is_compared() {
        let [old, new] = [11, 12].map(|seed| rays(&scene(256, seed), 0.0, 0.0, 0));
        let mut repeated_scene = RepeatedScene::NEW;
        repeated_scene.takes(&old, FOCAL);
        for _ in 0..3 {
            assert_eq!(repeated_scene.compare(&new, FOCAL), Seen::New);
        }
        assert_eq!(repeated_scene.compare(&old, FOCAL), Seen::Copied);
        assert_eq!(repeated_scene.compare(&new, FOCAL), Seen::New);
        repeated_scene.remember(&new, FOCAL);
        assert_eq!(repeated_scene.compare(&new, FOCAL), Seen::Copied);
    }

    #[test]
    fn a_copy_has_the_same_matches_and_noise_makes_a_new_measurement() {
        let seen = scene(256, 13);
        let mut repeated_scene = RepeatedScene::NEW;
        repeated_scene.takes(&rays(&seen, 0.0, 0.0, 0), FOCAL);
        for (noise_px, expected) in
            [(0.0, Seen::Copied), (0.1, Seen::Repeated), (0.5, Seen::Repeated)]
        {
            for seed in 1..20 {
                let pairs = rays(&seen, 0.0, noise_px, seed);
                assert_eq!(repeated_scene.compare(&pairs, FOCAL), expected, "{noise_px} {seed}");
            }
        }
        // A copy may differ from its original in less than a tenth of the matches.
        let changed = |part: usize| {
            let mut pairs = rays(&seen, 0.0, 0.0, 0);
            let others = rays(&scene(256, 14), 0.0, 0.0, 0);
            for (pair, other) in pairs.iter_mut().zip(others).step_by(part) {
                *pair = other;
            }
            pairs
        };
        assert_eq!(repeated_scene.compare(&changed(25), FOCAL), Seen::Copied);
        assert_eq!(repeated_scene.compare(&changed(3), FOCAL), Seen::Repeated);
    }
}
