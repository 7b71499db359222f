//! Tests of the motion of a scene since the key frame.

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
        let mixed: Vec<_> = old.iter().take(kept).chain(new.iter().skip(kept)).copied().collect();
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
            assert!((moved.share::<f32>() - share).abs() * distance < 0.6, "{motion} {moved:?}");
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
