//! Warps, disparities and spheres against known scenes.

use evidence::pictures::{KNOCKED, PicturedScene, comparison, knocked};
use images::pictures::{
    Disparities, Grey, Rectification, disparity_picture, pair_picture, turned, warp,
};
use nalgebra::Matrix3;
use page::report::Picture;
use page::run::{Estimates, sphere_figure};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim::stats::{median, quantile};
use sim::synth::rig;
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};

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
    let set = PicturedScene::shipped("motorcycle_sift", 0.0).unwrap();
    let camera = set.set.cameras::<f64>().unwrap().right;
    assert_eq!(turned(&set.right, &camera, &Matrix3::identity()), set.right);
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

#[test]
fn rows_of_a_turned_pair_align_and_its_disparities_are_found_after_calibration_only() {
    let all = comparison(&PicturedScene::shipped("motorcycle_sift", 5.0).unwrap()).unwrap();
    let [start, ours] = [&all[0], &all[3]].map(|a| a.outcome.as_ref().unwrap());
    let [(start, before), (ours, after)] = [start, ours];
    assert!(before.row_offset_px > 20.0 && after.row_offset_px < 0.6, "{before:?} {after:?}");
    assert!(after.valid > 2.0 * before.valid, "{before:?} {after:?}");
    assert!(before.right.unwrap() < 0.1 && after.right.unwrap() > 0.6, "{before:?} {after:?}");
    let apart =
        |one: &Rectification| median(one.matches.iter().map(|[l, r]| (l[1] - r[1]).abs())).unwrap();
    assert!(apart(start) > 20.0 && apart(ours) < 1.0, "{} {}", apart(start), apart(ours));
    for one in [start, ours] {
        let [width, height] = scene_size(one);
        let pictures = [disparity_picture(one).unwrap(), pair_picture(one).unwrap()];
        for (picture, width) in pictures.into_iter().zip([width, 2 * width]) {
            let Picture::Jpeg(jpeg) = picture else { panic!("no JPEG") };
            let decoded = image::load_from_memory(&jpeg).unwrap();
            // The shape of the image is kept, at most as wide as a panel of the page.
            let shown = width.min(640);
            assert_eq!([decoded.width(), decoded.height()], [shown, height * shown / width]);
        }
    }
}

#[test]
fn the_command_makes_the_picture_of_the_readme() {
    let drawn = image::load_from_memory(&knocked(KNOCKED).unwrap().jpeg).unwrap().into_rgb8();
    let kept = image::load_from_memory(include_bytes!("../../knocked.jpg"));
    let kept = kept.unwrap().into_rgb8();
    assert_eq!(drawn.dimensions(), kept.dimensions());
    let apart: u64 = drawn.iter().zip(kept.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    let values = u64::try_from(drawn.len()).unwrap();
    let advice = "cargo evidence picture --out host-tests/evidence/knocked.jpg";
    assert!(apart < values, "the picture has changed: {advice}");
}

fn scene_size(one: &Rectification) -> [u32; 2] {
    one.images[0].size().map(u32::from)
}

#[test]
fn the_published_depth_agrees_with_the_published_rig_and_with_what_is_found() {
    let scene = PicturedScene::shipped("motorcycle_sift", 0.0).unwrap();
    let [left, right] = scene.set.cameras::<f64>().map(|c| [c.left, c.right]).unwrap();
    let [[cx, cy], [cx_r, _]] = [left, right].map(|camera| camera.intrinsics().principal);
    let target = RectifiedCamera { focal: left.mean_focal(), principal: [cx, cy] };
    let rotations = RectifyingRotations::from(&scene.set.truth().unwrap());
    let found = Disparities::of(&scene.left, &scene.right, 64);
    let places = (0..500_u16).flat_map(|v| (0..741_u16).map(move |u| [u, v].map(f64::from)));
    let off = places.zip(&found.pixels).filter_map(|(pixel, d)| {
        // The right camera's principal point is further right, which reduces all disparities.
        let truth = scene.true_disparity(&rotations, &target, pixel)? - (cx_r - cx);
        Some(((*d)? - truth).abs())
    });
    let off: Vec<f64> = off.collect();
    let (count, median) = (off.len(), median(off).unwrap());
    assert!(count > 200_000 && median < 0.5, "{count} {median}");
}

#[test]
fn every_pair_is_on_its_sphere() {
    let reference = rig([2.0, -1.0, 0.5], [1.0, 2.0]).unwrap();
    let pairs: Vec<_> = (0..7)
        .map(|i| {
            rig([2.0, -1.0 + 0.1 * f64::from(i), 0.5], [1.0, 2.0 - 0.1 * f64::from(i)]).unwrap()
        })
        .collect();
    let estimates = Estimates { pairs, fused: Some(reference), reference };
    let figure = sphere_figure("sphere", &estimates, estimates.reach(), "selfcal replay");
    assert_eq!(figure.panels.len(), 4);
    for (picture, label) in &figure.panels {
        let Picture::Svg(svg) = picture else { panic!("{label} is no SVG") };
        // Seven pairs and the fused estimate.
        assert_eq!(svg.matches("<circle").count(), 8, "{label}");
    }
    assert_eq!(figure.numbers.rows.len(), 9);
}

/// The words of a picture, and the numbers at its axes.
fn texts(svg: &str) -> Vec<String> {
    let after = svg.split("<text").skip(1).filter_map(|text| text.split(['>', '<']).nth(1));
    after.map(String::from).collect()
}

#[test]
fn spheres_of_one_reach_have_one_scale() {
    let reference = rig([2.0, -1.0, 0.5], [1.0, 2.0]).unwrap();
    let off = |degrees: f64| Estimates {
        pairs: vec![rig([2.0 + degrees, -1.0, 0.5], [1.0, 2.0 + degrees]).unwrap()],
        fused: Some(reference),
        reference,
    };
    let (near, far) = (off(0.1), off(1.0));
    let reach = near.reach().or(far.reach());
    let scales = |estimates: &Estimates, reach| {
        let figure = sphere_figure("sphere", estimates, reach, "selfcal replay");
        let of = |(picture, _): &(Picture, String)| match picture {
            Picture::Svg(svg) => texts(svg),
            Picture::Png(_) | Picture::Jpeg(_) => panic!("no SVG"),
        };
        figure.panels.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(scales(&near, reach), scales(&far, reach));
    assert_ne!(scales(&near, near.reach()), scales(&far, reach));
}
