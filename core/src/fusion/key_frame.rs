//! Key frame: the scene of the last pair that was added, and how far the scene has moved since then (`ESTIMATOR.md`,
//! section 14). Errors of matches stay with the scene, outliers included. So a pair counts by how far the scene has
//! moved: a standing vehicle adds one pair, and a creeping one adds information with the distance that it travels.

use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;
use crate::thresholds::{
    COPIED_SHARE, FAR_STEPS, KEY_STEPS, REMEMBERED, REMEMBERED_STEPS_PER_PX, SAME_SHARE, SAME_STEPS,
};

/// Motion of the scene in the images since the key frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Moved {
    /// Motion, in steps of a quarter of a pixel, at most [`FAR_STEPS`].
    steps: u16,
    /// Whether nearly all matches have the same coordinates in whole steps: a copy of the key frame.
    is_copy: bool,
}

impl Moved {
    /// Another scene.
    pub(super) const FAR: Self = Self { steps: FAR_STEPS, is_copy: false };

    /// Returns whether the pair adds no information, because the scene has hardly moved.
    pub(super) fn is_repeated(self) -> bool {
        self.steps <= SAME_STEPS
    }

    /// Returns whether the pair is a copy of the key frame.
    pub(super) fn is_copy(self) -> bool {
        self.is_copy
    }

    /// Returns the share of the information of a pair that is new, above 0 to 1, for a pair that is not repeated: the
    /// motion over [`KEY_STEPS`].
    pub(super) fn share<T: Scalar>(self) -> T {
        (T::count(self.steps.into()) / T::count(KEY_STEPS.into())).min(T::ONE)
    }

    /// Returns the factor, at least 1, by which the gradients of successive pairs scatter more than their shares say,
    /// in variance: errors that stay with the scene up to a motion of [`FAR_STEPS`] are alike in these pairs.
    pub(super) fn scatter<T: Scalar>(self) -> T {
        T::count(FAR_STEPS.into()) / T::count(self.steps.max(KEY_STEPS).into())
    }
}

/// Sampled correspondences of the last pair that was added. RAM: 6 bytes per sample.
#[derive(Debug, Clone)]
pub(super) struct KeyFrame {
    remembered: Sampled,
}

/// Samples. The length has 8 bits, so that the slice has a valid size even if a fault has overwritten the length.
type Sampled = heapless::Vec<[u16; 3], REMEMBERED, u8>;

impl KeyFrame {
    pub(super) const NONE: Self = Self { remembered: heapless::Vec::new() };

    /// Returns whether the length is within the capacity.
    pub(super) fn is_within(&self) -> bool {
        self.remembered.len() <= REMEMBERED
    }

    /// Returns how far the scene of a batch has moved since the key frame: the least distance within which more than
    /// [`SAME_SHARE`] of the remembered correspondences are found again. Beyond the motion of a scene at rest, those
    /// that another scene would contain by chance do not count: as many as are found at displaced places.
    #[inline(never)]
    pub(super) fn compare<T: Scalar>(&self, pairs: &[RayPair<T>], focal: T) -> Moved {
        let scale = focal * T::lit(REMEMBERED_STEPS_PER_PX);
        let (found, copied) = self.find(pairs, scale, [0; 2]);
        let part = |share| (T::lit(share) * count::<T>(self.remembered.len())).to_u16();
        let (mut least, mut within) = (part(SAME_SHARE), 0);
        let is_copy = copied > part(COPIED_SHARE);
        let at_rest = usize::from(SAME_STEPS) + 1;
        for (at_distance, steps) in found.iter().zip(0..).take(at_rest) {
            within += u16::from(*at_distance);
            if within > least {
                return Moved { steps, is_copy };
            }
        }
        let (by_chance, _) = self.find(pairs, scale, DISPLACED);
        for ((at_distance, chance), steps) in found.iter().zip(by_chance).zip(0..).skip(at_rest) {
            within += u16::from(*at_distance);
            least += u16::from(chance);
            if within > least {
                return Moved { steps, is_copy };
            }
        }
        Moved { steps: FAR_STEPS, is_copy }
    }

    /// Makes the batch of a pair that was added the key frame.
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

    /// Returns the number of remembered correspondences that a batch contains at each distance, in steps below
    /// [`FAR_STEPS`], and the number whose coordinates are the same in whole steps.
    ///
    /// * `scale`: coordinate steps per unit at unit depth.
    /// * `[right, down]`: displacement of the remembered correspondences, in steps.
    #[inline(never)]
    fn find<T: Scalar>(
        &self,
        pairs: &[RayPair<T>],
        scale: T,
        [right, down]: [u16; 2],
    ) -> ([u8; DISTANCES], u16) {
        let mut found = [0; DISTANCES];
        let (mut distances, mut copied) = ([FAR_STEPS; REMEMBERED], 0_u32);
        let [columns, rows] = [(0, right), (1, down)].map(|(axis, by)| {
            let along = |old: &[u16; 3]| old.get(axis).map_or(0, |x| x.saturating_add(by));
            Buckets::of(self.remembered.iter().map(along))
        });
        for pair in pairs {
            let mut left = columns.near(steps(pair.left.x, scale)) & !copied;
            if left == 0 {
                continue;
            }
            left &= rows.near(steps(pair.left.y, scale));
            if left == 0 {
                continue;
            }
            let [column, row, other] = coordinates(pair, scale);
            let new = [
                column.saturating_sub(right),
                row.saturating_sub(down),
                other.saturating_sub(right),
            ];
            while left != 0 {
                let place = left.trailing_zeros();
                left &= left - 1;
                let Ok(at) = usize::try_from(place) else { continue };
                let places = (self.remembered.get(at), distances.get_mut(at));
                let (Some(old), Some(distance)) = places else { continue };
                let apart = new.iter().zip(old).map(|(a, b)| a.abs_diff(*b));
                let apart = apart.fold(0, u16::max);
                if apart == 0 {
                    copied |= 1_u32.checked_shl(place).unwrap_or(0);
                }
                if apart < FAR_STEPS {
                    // A pixel near the border of a wide-angle lens is larger.
                    let apart = (T::count(apart.into()) / pair.scale()).to_u16();
                    *distance = (*distance).min(apart);
                }
            }
        }
        for distance in distances {
            if let Some(count) = found.get_mut(usize::from(distance)) {
                *count += 1;
            }
        }
        (found, u16::try_from(copied.count_ones()).unwrap_or(u16::MAX))
    }

    pub(super) fn clear(&mut self) {
        self.remembered.clear();
    }
}

/// Displacement at which correspondences are found by chance only: right and down, in steps. It is beyond
/// [`FAR_STEPS`], and the two numbers have no common divisor, because of regular patterns.
const DISPLACED: [u16; 2] = [211, 149];

/// Number of distances that are counted apart.
const DISTANCES: usize = 64;
const _: () = assert!(FAR_STEPS <= 64, "each distance below it is counted");

/// Remembered correspondences by one coordinate, in 32 buckets that repeat. Each bucket is a set with one bit per
/// correspondence.
struct Buckets([u32; 32]);

/// Width of a bucket as a power of 2, steps.
const BUCKET_BITS: u32 = FAR_STEPS.ilog2() + 1;

impl Buckets {
    #[inline(never)]
    fn of(remembered: impl Iterator<Item = u16>) -> Self {
        let mut buckets = Self([0; 32]);
        for (steps, place) in remembered.zip(0_u32..) {
            // Enters both ends of the interval of distances below `FAR_STEPS`, which is narrower than a bucket.
            let most = FAR_STEPS - 1;
            for end in [steps.saturating_sub(most), steps.saturating_add(most)] {
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
        usize::from((steps >> BUCKET_BITS) & 31)
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

    impl KeyFrame {
        /// Compares a pair and remembers it. Returns whether the pair repeats the previous one.
        fn takes(&mut self, pairs: &[RayPair<f32>], focal: f32) -> bool {
            let moved = self.compare(pairs, focal);
            self.remember(pairs, focal);
            moved.is_repeated()
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
            let mut key_frame = KeyFrame::NONE;
            assert!(!key_frame.takes(&rays(&scene, 0.0, 0.5, 0), FOCAL));
            for seed in 1..20 {
                // Uniform noise of +-0.5 px has a standard deviation of 0.3 px.
                assert!(key_frame.takes(&rays(&scene, 0.0, 0.5, seed), FOCAL), "{n} {seed}");
            }
        }
    }

    #[test]
    fn a_scene_that_has_moved_or_changed_is_another() {
        let seen = scene(256, 2);
        let mut key_frame = KeyFrame::NONE;
        for k in 0..20_u8 {
            // 4 px per pair is more than the tolerance of a coordinate.
            let moved = rays(&seen, 4.0 * f32::from(k), 0.5, k.into());
            assert!(!key_frame.takes(&moved, FOCAL), "{k}");
        }
        for seed in 3..50 {
            assert!(!key_frame.takes(&rays(&scene(256, seed), 0.0, 0.5, seed), FOCAL));
        }
    }

    /// Returns whether the second batch counts as the same scene as the first.
    fn repeats(first: &[[f32; 4]], second: &[RayPair<f32>]) -> bool {
        let mut key_frame = KeyFrame::NONE;
        key_frame.takes(&rays(first, 0.0, 0.0, 0), FOCAL);
        key_frame.takes(second, FOCAL)
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
        let mut key_frame = KeyFrame::NONE;
        key_frame.takes(&old, FOCAL);
        let backwards: Vec<_> = old.iter().rev().copied().collect();
        assert!(key_frame.takes(&backwards, FOCAL));
        assert!(!key_frame.takes(&new, FOCAL));
        assert!(!key_frame.takes(&old, FOCAL));
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
        let mut key_frame = KeyFrame::NONE;
        key_frame.takes(&pairs, FOCAL);
        key_frame.clear();
        assert!(!key_frame.takes(&pairs, FOCAL));
        assert!(key_frame.takes(&pairs, FOCAL));
        assert!(!key_frame.takes(&[], FOCAL));
        assert!(!key_frame.takes(&pairs, FOCAL));
    }

    #[test]
    fn a_pair_is_remembered_once_it_is_added_however_often_it_is_compared() {
        let [old, new] = [11, 12].map(|seed| rays(&scene(256, seed), 0.0, 0.0, 0));
        let mut key_frame = KeyFrame::NONE;
        key_frame.takes(&old, FOCAL);
        for _ in 0..3 {
            assert_eq!(key_frame.compare(&new, FOCAL), Moved::FAR);
        }
        assert!(key_frame.compare(&old, FOCAL).is_copy());
        assert_eq!(key_frame.compare(&new, FOCAL), Moved::FAR);
        key_frame.remember(&new, FOCAL);
        assert!(key_frame.compare(&new, FOCAL).is_copy());
    }

    #[test]
    fn a_copy_has_the_same_matches_and_noise_makes_a_new_measurement() {
        let seen = scene(256, 13);
        let mut key_frame = KeyFrame::NONE;
        key_frame.takes(&rays(&seen, 0.0, 0.0, 0), FOCAL);
        for (noise_px, is_copy) in [(0.0, true), (0.1, false), (0.5, false)] {
            for seed in 1..20 {
                let moved = key_frame.compare(&rays(&seen, 0.0, noise_px, seed), FOCAL);
                assert!(moved.is_repeated(), "{noise_px} {seed}");
                assert_eq!(moved.is_copy(), is_copy, "{noise_px} {seed}");
            }
        }
        // A copy may differ from its original in less than a tenth of the matches.
        let changed = |part: usize| {
            let mut pairs = rays(&seen, 0.0, 0.0, 0);
            let others = rays(&scene(256, 14), 0.0, 0.0, 0);
            for (pair, other) in pairs.iter_mut().zip(others).step_by(part) {
                *pair = other;
            }
            let moved = key_frame.compare(&pairs, FOCAL);
            (moved.is_repeated(), moved.is_copy())
        };
        assert_eq!([25, 3].map(changed), [(true, true), (true, false)]);
    }

    #[test]
    fn a_pair_counts_by_how_far_the_scene_has_moved() {
        let seen = scene(256, 15);
        let mut key_frame = KeyFrame::NONE;
        key_frame.takes(&rays(&seen, 0.0, 0.3, 0), FOCAL);
        let distance = f32::from(KEY_STEPS) / REMEMBERED_STEPS_PER_PX.to_single();
        for step in 0..72_u8 {
            let motion = 0.25 * f32::from(step);
            let moved = key_frame.compare(&rays(&seen, motion, 0.3, step.into()), FOCAL);
            assert_eq!(moved.is_repeated(), moved.steps <= SAME_STEPS);
            if motion >= 1.0 {
                let share = (motion / distance).min(1.0);
                assert!(
                    (moved.share::<f32>() - share).abs() * distance < 0.6,
                    "{motion} {moved:?}"
                );
                let scatter = (2.0 * distance / motion).clamp(1.0, 2.0);
                let off = moved.scatter::<f32>() / scatter - 1.0;
                assert!(off.abs() < 0.06, "{motion} {moved:?}");
            } else {
                assert!(moved.is_repeated(), "{motion}");
            }
        }
    }

    #[test]
    fn matches_that_are_dense_enough_to_be_near_others_by_chance_show_no_motion() {
        // Points at infinity in a small image: 0.7 of the matches of another pair are within 16 px in both columns and
        // rows, and 0.3 within 9 px.
        let far = |seed| -> Vec<_> {
            scene(256, seed).iter().map(|[x, y, ..]| [x / 2.0, y / 2.0, x / 2.0, y / 2.0]).collect()
        };
        let mut key_frame = KeyFrame::NONE;
        key_frame.takes(&rays(&far(17), 0.0, 0.3, 0), 900.0);
        let moved = (18..118).map(|seed| key_frame.compare(&rays(&far(seed), 0.0, 0.3, 0), 900.0));
        let shares = moved.map(Moved::share::<f32>);
        let mean = shares.sum::<f32>() / 100.0;
        assert!(mean > 0.95, "{mean}");
        // The same points, moved by 4 px.
        let moved = key_frame.compare(&rays(&far(17), 4.0 * FOCAL / 900.0, 0.3, 1), 900.0);
        assert!((moved.share::<f32>() - 0.5).abs() < 0.1, "{moved:?}");
    }

    #[test]
    fn motion_near_the_border_of_a_wide_lens_is_in_its_pixels() {
        let (seen, scale) = (scene(256, 16), 4.0);
        let wide = |pairs: Vec<RayPair<f32>>| -> Vec<_> {
            pairs.into_iter().map(|pair| pair.with_scale(scale)).collect()
        };
        let mut key_frame = KeyFrame::NONE;
        key_frame.takes(&wide(rays(&seen, 0.0, 0.0, 0)), FOCAL);
        // A noise of up to 1 px there is one of up to 4 px in the middle of the image.
        assert!(key_frame.compare(&wide(rays(&seen, 0.0, 4.0, 1)), FOCAL).is_repeated());
        assert!(!key_frame.compare(&rays(&seen, 0.0, 4.0, 1), FOCAL).is_repeated());
        let moved = key_frame.compare(&wide(rays(&seen, 7.0, 0.0, 1)), FOCAL);
        assert_eq!(moved.steps, 7);
    }
}
