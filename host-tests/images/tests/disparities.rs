//! Warps and disparities of random textures.

use images::pictures::{Disparities, Grey, warp};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim::stats::quantile;

const SIZE: [u16; 2] = [160, 90];

fn texture(seed: u64) -> Grey {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let pixels = 0..usize::from(SIZE[0]) * usize::from(SIZE[1]);
    Grey::try_new(SIZE, pixels.map(|_| Some(random.random())).collect()).unwrap()
}

/// The right image of a scene with known disparities at the pixels of the right image.
fn seen_from_the_right(left: &Grey, disparity: impl Fn([f64; 2]) -> f64 + Sync) -> Grey {
    warp(left, left.size(), |[u, v]| Some([u + disparity([u, v]), v]))
}

/// Median and largest error over the found disparities away from the borders, and their share.
fn errors(found: &Disparities, truth: impl Fn(f64) -> f64) -> [f64; 3] {
    let width = usize::from(SIZE[0]);
    let (mut errors, mut inner) = (Vec::new(), 0.0);
    for (i, d) in found.pixels.iter().enumerate() {
        let [u, v] = [i % width, i / width].map(|x| f64::from(u16::try_from(x).unwrap()));
        if (40.0..150.0).contains(&u) && (8.0..80.0).contains(&v) {
            inner += 1.0;
            errors.extend(d.map(|d| (d - truth(u)).abs()));
        }
    }
    let share = f64::from(u32::try_from(errors.len()).unwrap()) / inner;
    let [median, worst] = [0.5, 1.0].map(|share| quantile(errors.iter().copied(), share).unwrap());
    [median, worst, share]
}

#[test]
fn the_warp_that_moves_nothing_changes_nothing() {
    let image = texture(1);
    assert_eq!(warp(&image, SIZE, Some), image);
}

#[test]
fn a_warp_by_half_a_pixel_is_the_mean_of_neighbours_and_ends_at_the_border() {
    let image = texture(2);
    let half = warp(&image, SIZE, |[u, v]| Some([u + 0.5, v]));
    let mean = image.at(10, 7).unwrap().midpoint(image.at(11, 7).unwrap());
    assert!(half.at(10, 7).unwrap().abs_diff(mean) <= 1);
    assert_eq!(half.at(159, 7), None);
}

#[test]
fn a_constant_shift_of_a_random_texture_is_found() {
    let left = texture(3);
    let right = seen_from_the_right(&left, |_| 13.0);
    let found = Disparities::of(&left, &right, 32);
    let [median, worst, share] = errors(&found, |_| 13.0);
    assert!(median < 0.1 && worst < 0.5 && share > 0.98, "{median} {worst} {share}");
}

#[test]
fn a_ramp_is_found_to_a_fraction_of_a_pixel() {
    let left = texture(4);
    // u_l = u_r + d, d = 6 + u_r / 16, so d = (16 * 6 + u_l) / 17.
    let right = seen_from_the_right(&left, |[u, _]| 6.0 + u / 16.0);
    let found = Disparities::of(&left, &right, 32);
    let [median, _, share] = errors(&found, |u| (96.0 + u) / 17.0);
    // Disparities in whole px would be off by 0.25 px in the median.
    assert!(median < 0.2 && share > 0.85, "{median} {share}");
}

#[test]
fn two_unrelated_textures_agree_nearly_nowhere() {
    let found = Disparities::of(&texture(5), &texture(6), 32);
    let share = found.valid_share(&texture(5));
    assert!(share < 0.35, "{share}");
}
