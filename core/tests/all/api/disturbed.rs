//! Disturbed correspondences: with outliers, outliers alone, and with additional noise.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::{Correspondence, Scalar};

use crate::api::scene::SIZE;

/// Gives one match in `one_in` the right point of another match.
pub(crate) fn with_outliers<T: Scalar>(
    mut all: Vec<Correspondence<T>>,
    one_in: usize,
) -> Vec<Correspondence<T>> {
    for i in (0..all.len().saturating_sub(one_in)).step_by(one_in) {
        let other = all[i + one_in].right;
        all[i].right = other;
    }
    all
}

/// Only outliers: both points are anywhere in the image.
pub(crate) fn garbage<T: Scalar>(n: usize, seed: u64) -> Vec<Correspondence<T>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let [width, height] = SIZE.map(|n| f64::from(n) - 1.0);
    let mut point = || [rng.random_range(0.0..width), rng.random_range(0.0..height)].map(T::lit);
    let mut one = || {
        let [left, right] = [point(), point()];
        Correspondence { left, right, score: T::ONE, grid_step: T::ZERO }
    };
    (0..n).map(|_| one()).collect()
}

/// The scene with every coordinate moved by uniform noise of +-`noise_px`, within the image.
pub(crate) fn jittered<T: Scalar>(
    scene: &[Correspondence<T>],
    noise_px: f64,
    seed: u64,
) -> Vec<Correspondence<T>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let limits = SIZE.map(|n| f64::from(n) - 1.0);
    let mut moved = |[u, v]: [T; 2]| {
        let mut noisy = |x: T, limit: f64| {
            T::lit((x.to_f64() + rng.random_range(-noise_px..noise_px)).clamp(0.0, limit))
        };
        [noisy(u, limits[0]), noisy(v, limits[1])]
    };
    scene
        .iter()
        .map(|c| Correspondence { left: moved(c.left), right: moved(c.right), ..*c })
        .collect()
}
