//! More matches than the batch holds: which matches stay, whether the selection is fair, and what it improves.

use std::collections::HashMap;

use crate::api::presets::with;
use crate::api::scene::{cameras, correspondences, rig};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::batch::{Batch, Pushed};
use stereo_selfcal::geometry::{RadialTangential, Side, UndistortError};
use stereo_selfcal::outcome::StandardDeviations;
use stereo_selfcal::{Camera, Cameras, Config, Correspondence, Extrinsics, Lens, PushError};

fn at(u: f32, v: f32, disparity: f32, score: f32) -> Correspondence<f32> {
    Correspondence { left: [u, v], right: [u - disparity, v], score, grid_step: 0.0 }
}

fn batch_of<const N: usize>(offered: &[Correspondence<f32>]) -> Batch<f32, N> {
    let mut batch = Batch::new();
    for c in offered {
        batch.push(&cameras(), c).unwrap();
        assert!(batch.matches().len() <= N);
    }
    batch
}

/// Bits of the rays, which identify a match.
fn key(left: [f32; 2], right: [f32; 2]) -> [u32; 4] {
    let [[a, b], [c, d]] = [left, right];
    [a, b, c, d].map(f32::to_bits)
}

fn keys<const N: usize>(batch: &Batch<f32, N>) -> Vec<[u32; 4]> {
    batch.matches().iter().map(|pair| key(pair.left(), pair.right())).collect()
}

fn holds<const N: usize>(batch: &Batch<f32, N>, c: &Correspondence<f32>) -> bool {
    let rays = cameras().rays(c).unwrap();
    keys(batch).contains(&key(rays.left(), rays.right()))
}

/// `n` matches on a lattice of 10 x 8 px within one cell of 240 x 200 px, with random disparities.
fn one_cell(n: u16, rng: &mut ChaCha8Rng) -> Vec<Correspondence<f32>> {
    let disparity = |rng: &mut ChaCha8Rng| f32::from(rng.random_range(1..120_u8));
    let place = |i: u16| [490.0 + f32::from(i % 20) * 10.0, 410.0 + f32::from(i / 20 * 8)];
    (0..n).map(|i| (place(i), disparity(rng))).map(|([u, v], d)| at(u, v, d, 0.5)).collect()
}

#[test]
fn the_few_matches_outside_a_crowd_stay_whenever_they_come() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    // Twelve matches of the lowest score in the eight cells of a row of cells.
    let few: Vec<_> = (0..12).map(|i| at(130.0 + 160.0 * i as f32, 900.0, 30.0, 0.0)).collect();
    for place in [0, 20, 60, 400] {
        let mut offered = one_cell(400, &mut rng);
        offered.splice(place..place, few.iter().copied());
        let batch = batch_of::<64>(&offered);
        assert!(few.iter().all(|c| holds(&batch, c)), "{place}");
        assert_eq!((batch.matches().len(), batch.offered(), batch.left_out()), (64, 412, 348));
    }
}

#[test]
fn the_better_scores_of_a_cell_stay() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut offered = one_cell(400, &mut rng);
    for (i, c) in (0_u16..).zip(&mut offered) {
        c.score = f32::from(i) / 400.0;
    }
    let best = offered.split_off(336);
    let mut all = [offered, best.clone()].concat();
    all.shuffle(&mut rng);
    let batch = batch_of::<64>(&all);
    assert!(best.iter().all(|c| holds(&batch, c)));
}

/// Chi-square of `counts` against equal chances, minus its mean, in standard deviations.
///
/// * `share`: chance of each match to be kept.
fn excess(counts: &[u32], share: f64) -> f64 {
    let cells = counts.len() as f64;
    let mean = f64::from(counts.iter().sum::<u32>()) / cells;
    let squares: f64 = counts.iter().map(|&n| (f64::from(n) - mean).powi(2)).sum();
    let chi2 = squares / (mean * (1.0 - share));
    (chi2 - cells) / (2.0 * cells).sqrt()
}

#[test]
fn among_equal_scores_every_match_of_a_cell_has_the_same_chance() {
    // Counts by the position in the stream, which determines the position in the image.
    let mut kept = [0; 400];
    // Counts by the disparity: every match is offered equally often with each of 100 disparities.
    let mut kept_by_disparity = [0; 100];
    for seed in 0..1000_u16 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed.into());
        let mut offered = one_cell(400, &mut rng);
        let mut index = HashMap::new();
        for (i, c) in offered.iter_mut().enumerate() {
            let disparity = (i * 7 + usize::from(seed)) % 100;
            c.right[0] = c.left[0] - disparity as f32;
            // A random fraction of a pixel, so that the runs hardly ever offer the same match twice.
            c.right[1] += f32::from(rng.random::<u16>()) / 65_536.0;
            let rays = cameras::<f32>().rays(c).unwrap();
            index.insert(key(rays.left(), rays.right()), [i, disparity]);
        }
        for key in keys(&batch_of::<40>(&offered)) {
            let [i, disparity] = index[&key];
            kept[i] += 1;
            kept_by_disparity[disparity] += 1;
        }
    }
    let [place, disparity] = [excess(&kept, 0.1), excess(&kept_by_disparity, 0.1)];
    println!("chi-square beyond its mean, in deviations: {place:.2}, {disparity:.2}");
    assert!(place.abs() < 4.0 && disparity.abs() < 4.0);
}

#[test]
fn the_same_matches_give_the_same_bits_and_in_another_order_the_same_set() {
    let mut offered = correspondences::<f32>(&rig([1.0, 2.0, -1.0], [2.0, 1.0]), 700, 0.3, 4);
    let batch = batch_of::<100>(&offered);
    assert_eq!(batch.matches(), batch_of::<100>(&offered).matches());
    let sorted = |batch: &Batch<f32, 100>| {
        let mut keys = keys(batch);
        keys.sort_unstable();
        keys
    };
    offered.shuffle(&mut ChaCha8Rng::seed_from_u64(4));
    assert_eq!(sorted(&batch), sorted(&batch_of::<100>(&offered)));
}

#[test]
fn clearing_leaves_nothing_behind() {
    let offered = correspondences::<f32>(&Extrinsics::SIDE_BY_SIDE, 300, 0.3, 5);
    let mut batch = batch_of::<64>(&offered);
    assert_eq!([batch.offered(), batch.left_out(), batch.refused()], [300, 236, 0]);
    batch.clear();
    assert_eq!([batch.offered(), batch.left_out(), batch.refused()], [0, 0, 0]);
    for c in &offered {
        batch.push(&cameras(), c).unwrap();
    }
    assert_eq!(batch.matches(), batch_of::<64>(&offered).matches());
}

#[test]
fn the_fate_of_each_match_is_reported_and_counted() {
    let mut batch = batch_of::<2>(&[at(500.0, 500.0, 9.0, 0.5), at(510.0, 500.0, 9.0, 0.6)]);
    let mut push = |c| batch.push(&cameras(), &c);
    assert_eq!(push(at(520.0, 500.0, 9.0, 0.4)), Ok(Pushed::LeftOut));
    assert_eq!(push(at(530.0, 500.0, 9.0, 0.7)), Ok(Pushed::Replaced));
    assert_eq!(push(at(900.0, 900.0, 9.0, 0.1)), Ok(Pushed::Replaced));
    assert_eq!(push(at(900.0, 900.0, 9.0, 1.1)), Err(PushError::Score));
    assert_eq!([batch.offered(), batch.left_out(), batch.refused()], [6, 3, 1]);
    let scores: Vec<f32> = batch.matches().iter().map(|p| (p.score() * 10.0).round()).collect();
    assert_eq!(scores, [7.0, 1.0]);
    let mut none = Batch::<f32, 0>::new();
    assert_eq!(none.push(&cameras(), &at(500.0, 500.0, 9.0, 0.5)), Ok(Pushed::LeftOut));
}

#[test]
fn a_match_without_rays_takes_no_place_of_a_full_batch() {
    // The model folds back at a distorted radius of 0.385.
    let fold = RadialTangential::try_new([-1.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    let pinhole = cameras::<f32>().left;
    let folding = Camera::try_new(*pinhole.intrinsics(), Lens::RadialTangential(fold)).unwrap();
    let cameras = Cameras { left: pinhole, right: folding };
    let mut batch = Batch::<f32, 8>::new();
    for i in 0..8_u8 {
        batch.push(&cameras, &at(900.0 + f32::from(i), 600.0, 9.0, 0.5)).unwrap();
    }
    let before = batch.matches().to_vec();
    let pixel = |side, why| PushError::Pixel(side, why);
    let cases = [
        // A better score in a cell of its own: the match would stay if it had rays.
        (at(100.0, 100.0, 9.0, 1.0), pixel(Side::Right, UndistortError::NotInvertible)),
        (at(100.0, f32::NAN, 9.0, 1.0), pixel(Side::Left, UndistortError::NotFinite)),
        (at(100.0, 100.0, 900.0, 1.0), pixel(Side::Right, UndistortError::OutsideImage)),
        // This match is refused, although even a valid one with its score would be left out.
        (at(901.0, 600.0, 9e9, 0.0), pixel(Side::Right, UndistortError::OutsideImage)),
        (Correspondence { grid_step: 256.0, ..at(100.0, 100.0, 9.0, 1.0) }, PushError::GridStep),
    ];
    for (i, (bad, why)) in (1..).zip(cases) {
        assert_eq!(batch.push(&cameras, &bad), Err(why));
        assert_eq!((batch.matches(), batch.refused(), batch.left_out()), (&before[..], i, 0));
    }
}

/// 2000 matches, row by row, as a matcher scans. Nine in ten are in a window of a fifteenth of the image.
fn crowded_scene(seed: u64) -> Vec<Correspondence<f32>> {
    let crowded = |c: &Correspondence<f32>| {
        (1100.0..1600.0).contains(&c.left[0]) && (300.0..600.0).contains(&c.left[1])
    };
    let all = correspondences::<f32>(&rig([1.0, 2.0, -1.0], [2.0, 1.0]), 40_000, 0.5, seed);
    let (crowd, rest): (Vec<_>, Vec<_>) = all.into_iter().partition(crowded);
    let mut scene = [&crowd[..1800], &rest[..200]].concat();
    scene.sort_by(|a, b| a.left[1].total_cmp(&b.left[1]));
    scene
}

fn reported(matches: impl IntoIterator<Item = Correspondence<f32>>) -> StandardDeviations<f32> {
    let mut calibrator = with::<f32, 128>(Config::robust());
    calibrator.take_pair(matches).pair.unwrap().information.standard_deviations().unwrap()
}

#[test]
fn a_selected_batch_knows_more_than_the_first_or_every_nth_match() {
    let [mut first, mut even, mut selected] = [[0.0_f32; 2]; 3];
    let trials = 20;
    for seed in 0..trials {
        let scene = crowded_scene(seed);
        let add = |sum: &mut [f32; 2], sd: StandardDeviations<f32>| {
            sum[0] += sd.translation.ln() / trials as f32;
            sum[1] += sd.rotation.ln() / trials as f32;
        };
        add(&mut first, reported(scene[..128].iter().copied()));
        add(&mut even, reported((0..128).map(|i| scene[i * 2000 / 128])));
        add(&mut selected, reported(scene));
    }
    let [first, even, selected] = [first, even, selected].map(|sum| sum.map(f32::exp));
    println!("sd of t, R in rad: first {first:?}, even {even:?}, selected {selected:?}");
    for unknown in [0, 1] {
        assert!(first[unknown] > 4.0 * selected[unknown]);
        assert!(even[unknown] > 2.5 * selected[unknown]);
    }
}
