//! A view that moves by a few pixels from pair to pair, as that of a slow robot: information grows with the distance
//! that the scene has moved, and not with the number of pairs.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rigs::data::in_f64;
use sim::stats::rms_deviation;
use sim::synth::rig;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, Correspondence, Extrinsics, FactoryCalibration, Fused,
    Intrinsics, Lens, Scalar,
};
use test_support::runs;

const SIZE: [f64; 2] = [1920.0, 1200.0];
const FOCAL: f64 = 1400.0;
const NOISE_PX: f64 = 0.3;
/// Points in an image.
const MATCHES: f64 = 256.0;
const WRONG: f64 = 0.1;
/// Depths, in baselines.
const DEPTHS: [f64; 2] = [3.0, 80.0];

fn cameras<T: Scalar>() -> Cameras<T> {
    let principal = SIZE.map(|n| T::lit((n - 1.0) / 2.0));
    let intrinsics =
        Intrinsics { focal: [T::lit(FOCAL); 2], principal, size: SIZE.map(Scalar::to_u16) };
    let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
    Cameras { left: camera, right: camera }
}

/// A point of the scene.
#[derive(Debug, Clone, Copy)]
struct Point {
    /// Left pixel at the first pair.
    at: [f64; 2],
    depth: f64,
    /// Errors of its four coordinates that stay, px.
    off: [f64; 4],
    /// Displacement of a wrong match.
    wrong: Option<[f64; 2]>,
}

/// A scene that moves to the left past the view.
struct Scene {
    rig: Extrinsics<f64>,
    cameras: Cameras<f64>,
    points: Vec<Point>,
}

impl Scene {
    /// * `length`: motion over all pairs, px; `staying_px`: standard deviation of the errors that stay.
    fn new(length: f64, staying_px: f64, rng: &mut ChaCha8Rng) -> Self {
        let [width, height] = SIZE;
        let turn = [0.0; 3].map(|_: f64| rng.random_range(-3.0..3.0));
        let baseline = [0.0; 2].map(|_: f64| rng.random_range(-3.0..3.0));
        let [nearest, farthest]: [f64; 2] = DEPTHS;
        let mut at = 0.0;
        let points = std::iter::from_fn(|| {
            at += 2.0 * width / MATCHES * rng.random_range(0.0..1.0);
            let wrong = [60.0, 20.0].map(|most: f64| rng.random_range(-most..most));
            Some(Point {
                at: [at, rng.random_range(0.0..height - 1.0)],
                depth: nearest * (farthest / nearest).powf(rng.random()),
                off: [0.0; 4].map(|_: f64| staying_px * normal(rng)),
                wrong: rng.random_bool(WRONG).then_some(wrong),
            })
        });
        let points = points.take_while(|point| point.at[0] < width + length).collect();
        Self { rig: rig(turn, baseline).unwrap(), cameras: cameras(), points }
    }

    fn pair(&self, moved: f64, rng: &mut ChaCha8Rng) -> Vec<Correspondence<f32>> {
        self.points.iter().filter_map(|point| self.seen(point, moved, rng)).collect()
    }

    fn seen(&self, point: &Point, moved: f64, rng: &mut ChaCha8Rng) -> Option<Correspondence<f32>> {
        let inside = |x: f64, n: f64| (0.0..=n - 1.0).contains(&x);
        let left @ [u, _] = [point.at[0] - moved, point.at[1]];
        if !inside(u, SIZE[0]) {
            return None;
        }
        let ray = self.cameras.left.ray(left).unwrap().push(1.0);
        let seen = self.rig.rotation() * (ray * point.depth) + self.rig.translation().into_inner();
        let right = self.cameras.right.pixel(seen.xy() / seen.z).ok()?;
        let [x, y] = point.wrong.unwrap_or([0.0; 2]);
        let mut pixels = [left[0], left[1], right[0] + x, right[1] + y];
        for (pixel, off) in pixels.iter_mut().zip(point.off) {
            *pixel += off + NOISE_PX * normal(rng);
        }
        let [ul, vl, ur, vr] = pixels;
        let is_inside = [ul, ur].iter().all(|u| inside(*u, SIZE[0]))
            && [vl, vr].iter().all(|v| inside(*v, SIZE[1]));
        let [ul, vl, ur, vr] = pixels.map(f32::lit);
        let (left, right) = ([ul, vl], [ur, vr]);
        is_inside.then_some(Correspondence { left, right, score: 1.0, grid_step: 0.0 })
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// Estimates over rigs whose scene moves.
#[derive(Debug)]
struct Creeping {
    /// RMS error of `t`, rad, and its ratio to the reported deviation; the same of `R`.
    translation: [f64; 2],
    rotation: [f64; 2],
    /// Mean number of pairs added.
    added: f64,
    /// Number of pairs that were taken for a change of the rig.
    changes: u32,
}

fn creeping(px_a_pair: f64, staying_px: f64, rigs: u16) -> Creeping {
    let (mut errors, mut sds, mut added, mut changes) = (Vec::new(), Vec::new(), 0, 0);
    for seed in 0..rigs {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed.into());
        let scene = Scene::new(px_a_pair * f64::from(PAIRS), staying_px, rng);
        let factory = FactoryCalibration::guess(cameras::<f32>());
        let mut calibrator = Box::new(Calibrator::<f32, 512>::new(Config::robust(), &factory));
        for pair in 0..PAIRS {
            let matches = scene.pair(px_a_pair * f64::from(pair), rng);
            let fused = calibrator.take_pair(matches).fused;
            added += u32::from(fused == Ok(Fused::Added));
            changes += u32::from(matches!(fused, Ok(Fused::Renewed | Fused::TookOver)));
        }
        let proposal = calibrator.proposal().unwrap();
        let [translation, rotation] =
            [proposal.sd.translation, proposal.sd.rotation].map(f64::from);
        errors.push(Deviation::between(&in_f64(&proposal.extrinsics), &scene.rig));
        sds.push(Deviation { translation, rotation });
    }
    let [error, sd] = [errors, sds].map(rms_deviation);
    Creeping {
        translation: [error.translation, error.translation / sd.translation],
        rotation: [error.rotation, error.rotation / sd.rotation],
        added: f64::from(added) / f64::from(rigs),
        changes,
    }
}

/// Motions from pair to pair, px. Short runs take the first two.
const MOTIONS: [f64; 5] = [0.2, 2.5, 0.5, 1.0, 5.0];
/// Pairs of a rig.
const PAIRS: u16 = 400;

fn over_motions(staying_px: f64) -> Vec<Creeping> {
    let (motions, rigs) = runs((2, 6), (MOTIONS.len(), 30));
    let of = |px_a_pair: &f64| {
        let creeping = creeping(*px_a_pair, staying_px, rigs);
        println!("{staying_px} px stay, {px_a_pair} px a pair: {creeping:.6?}");
        creeping
    };
    MOTIONS[..motions].iter().map(of).collect()
}

#[test]
fn information_grows_with_the_distance_that_the_scene_has_moved() {
    let creeping = over_motions(0.0);
    for Creeping { translation: [t, t_sd], rotation: [_, r_sd], added, changes } in &creeping {
        assert!(*t < 3e-4 && *t_sd < 2.0 && *r_sd < 2.0);
        assert!(*added > 40.0 && *changes == 0);
    }
    // 2.5 px a pair is 12.5 times the distance of 0.2 px a pair.
    let [slow, fast] = [0, 1].map(|i| {
        let [t, of_sd] = creeping[i].translation;
        t / of_sd
    });
    assert!((2.5..4.5).contains(&(slow / fast)), "{slow} {fast}");
}

#[test]
fn errors_that_stay_with_the_points_of_a_creeping_scene_are_no_change_of_the_rig() {
    for Creeping { translation: [_, t_sd], rotation: [_, r_sd], changes, .. } in over_motions(0.2) {
        assert!(t_sd < 2.5 && r_sd < 2.5, "{t_sd} {r_sd}");
        assert_eq!(changes, 0);
    }
}
