//! Pairs of one scene that creeps, before and after a restart or a renewal: one scene replaces no baseline.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::geometry::so3;
use stereo_selfcal::{Calibrator, Correspondence, Extrinsics, Fused, State};

use crate::api::presets::calibrated;
use crate::api::scene::{FOCAL, SIZE, correspondences_within, rig, take};

type Tested = Calibrator<f32, 256>;

const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
const BASELINE: [f64; 2] = [0.5, -0.4];
const DEPTHS: [f64; 2] = [5.0, 50.0];

/// Points in the left camera frame, each with errors of its pixels, which stay with it when the view turns.
struct Scene(Vec<(Vector3<f64>, [f64; 4])>);

impl Scene {
    fn new(noise_px: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [near, far] = DEPTHS;
        let point = |_| {
            let [u, v] = [rng.random_range(-300.0..2219.0), rng.random_range(-300.0..1499.0)];
            let depth = near * (far / near).powf(rng.random::<f64>());
            let ray = Vector3::new((u - 959.5) / FOCAL, (v - 599.5) / FOCAL, 1.0);
            (ray * depth, [(); 4].map(|()| (rng.random::<f64>() * 2.0 - 1.0) * noise_px))
        };
        Self((0..450).map(point).collect())
    }

    /// The view of a rig that has turned, so that the images have moved by some pixels.
    fn view(&self, of: &Extrinsics<f64>, px: f64) -> Vec<Correspondence<f32>> {
        let turn = so3::exp(&Vector3::new(0.0, px / FOCAL, 0.0)).unwrap();
        let [width, height] = SIZE.map(|n| f64::from(n) - 1.0);
        let seen = |(point, e): &(Vector3<f64>, [f64; 4])| {
            let l = turn * point;
            let r = of.rotation() * l + of.translation().into_inner();
            let [a, b] = [l, r].map(|p| [959.5 + FOCAL * p.x / p.z, 599.5 + FOCAL * p.y / p.z]);
            let both = [[a[0] + e[0], a[1] + e[1]], [b[0] + e[2], b[1] + e[3]]];
            let inside =
                |[u, v]: [f64; 2]| (0.0..=width).contains(&u) && (0.0..=height).contains(&v);
            let [left, right] = both.map(|pixel| pixel.map(|x| x as f32));
            let seen = Correspondence { left, right, score: 1.0, grid_step: 0.0 };
            both.into_iter().all(inside).then_some(seen)
        };
        self.0.iter().filter_map(seen).take(250).collect()
    }
}

/// The rig with another baseline direction, as matches with a common bias show it.
fn biased(degrees: f64) -> Extrinsics<f64> {
    rig(ROTATION, BASELINE.map(|angle| angle + degrees * angle.signum()))
}

fn replaces(calibrator: &Tested) -> bool {
    let t = calibrator.proposal().unwrap().applicable.translation().into_inner();
    (t - calibrator.in_use().extrinsics.translation().into_inner()).norm() > 1e-4
}

#[test]
fn a_restart_makes_no_scenes_of_the_pairs_of_one_scene() {
    let scene = Scene::new(1.0, 3);
    let new = || calibrated(rig(ROTATION, BASELINE));
    let mut calibrator = new();
    for pair in 0..9_u8 {
        let _ = take(&mut calibrator, &scene.view(&biased(8.0), 1.7 * f64::from(pair)));
    }
    assert!(calibrator.state() == State::Locked && !replaces(&calibrator));
    let mut restarted = new();
    restarted.restore(&calibrator.snapshot()).unwrap();
    let _ = take(&mut restarted, &scene.view(&biased(8.0), 1.7 * 8.0));
    assert!(restarted.state() == State::Locked && !replaces(&restarted));
}

#[test]
fn a_renewed_estimate_has_the_scenes_of_its_window() {
    let mut renewals = 0;
    for seed in 999..1004 {
        let mut calibrator = calibrated(rig(ROTATION, BASELINE));
        for seed in 0..30 {
            let pair = correspondences_within(&rig(ROTATION, BASELINE), DEPTHS, 250, 1.0, seed);
            let _ = take(&mut calibrator, &pair);
        }
        let scene = Scene::new(1.0, seed);
        let (mut is_renewed, mut last) = (false, 0);
        for frame in 0..24_u8 {
            let fused = take(&mut calibrator, &scene.view(&biased(0.2), 1.8 * f64::from(frame)));
            is_renewed |= fused == Ok(Fused::Renewed);
            let pairs = calibrator.proposal().unwrap().pairs;
            // At the second renewal the sums have ten pairs, which moved by 18 px in all.
            if is_renewed && pairs < last && fused == Ok(Fused::Added) {
                renewals += 1;
                assert!(!replaces(&calibrator), "{seed} {frame}");
            }
            last = pairs;
        }
    }
    assert!(renewals >= 4, "{renewals}");
}
