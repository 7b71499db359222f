//! Left and right images of different moments: no common trigger, an image stabiliser, or rows read in opposite order.
//! The calibrator does not arm, and names the cause or the coverage.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::{Calibrator, Cause, Correspondence, Reason};

use crate::api::presets::{ROWS_ALONE, with};
use crate::api::scene::{FOCAL, SIZE, correspondences, rig, take};
use crate::api::vibration::shaken;

type Pair = Vec<Correspondence<f32>>;

const PAIRS: u64 = 20;

/// Checks 12 runs of pairs, each of which is applied if possible.
///
/// * `pair`: pair of a seed.
fn never_arms(name: &str, pair: impl Fn(u64) -> Pair) {
    let mut named = 0;
    for run in 0..12 {
        let mut calibrator: Calibrator<f32, 256> = with(ROWS_ALONE);
        for number in 0..PAIRS {
            let _ = take(&mut calibrator, &pair(100 * run + number));
            let verdict = calibrator.verdict();
            assert!(!verdict.may_arm, "{name}, {run}, {number}: {verdict}");
            let _ = calibrator.apply();
        }
        let verdict = calibrator.verdict();
        println!("{name}, {run}: {verdict}");
        let is_named = verdict.cause == Some(Cause::Moments);
        named += u32::from(is_named || verdict.reasons.contains(Reason::Coverage));
    }
    assert!(named >= 10, "{name}: {named} of 12");
}

fn normal(rng: &mut ChaCha8Rng, sd: f64) -> f64 {
    sd * ((0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0)
}

/// Matches of the rig at rest.
fn steady(seed: u64) -> Pair {
    correspondences(&rig([1.0, -2.0, 1.5], [1.0, -1.0]), 200, 0.5, seed)
}

/// Matches that are within both images after each pixel has been moved.
fn moved(pair: Pair, by: impl Fn([f64; 2], bool) -> [f64; 2]) -> Pair {
    let of = |pixel: [f32; 2], is_right| by(pixel.map(f64::from), is_right).map(|x| x as f32);
    let one = |c: Correspondence<f32>| Correspondence {
        left: of(c.left, false),
        right: of(c.right, true),
        ..c
    };
    let is_inside = |[u, v]: [f32; 2]| {
        let [width, height] = SIZE.map(|n| f32::from(n) - 1.0);
        (0.0..=width).contains(&u) && (0.0..=height).contains(&v)
    };
    pair.into_iter().map(one).filter(|c| is_inside(c.left) && is_inside(c.right)).collect()
}

#[test]
fn without_a_common_trigger_a_shaking_rig_never_arms() {
    // The rows of each pair move by some 12 px.
    never_arms("no trigger", |seed| correspondences(&shaken(0.5, seed), 200, 0.5, seed));
}

#[test]
fn an_image_stabiliser_in_each_camera_never_arms() {
    // Each stabiliser shifts its image by 6 px RMS along each axis, and turns it by 0.1 degrees RMS.
    never_arms("stabilisers", |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let shifts =
            [(); 2].map(|()| [6.0, 6.0, 0.1_f64.to_radians()].map(|sd| normal(&mut rng, sd)));
        moved(steady(seed), |[u, v], is_right| {
            let [du, dv, roll] = shifts[usize::from(is_right)];
            let (sin, cos) = roll.sin_cos();
            let (x, y) = (u - 959.5, v - 599.5);
            [959.5 + cos * x - sin * y + du, 599.5 + sin * x + cos * y + dv]
        })
    });
}

#[test]
fn rolling_shutters_in_opposite_order_never_arm_while_the_rig_turns() {
    // One camera is mounted upside down. Both read their rows in 20 ms, while the vehicle turns at 0.4 rad/s RMS about
    // x and y.
    never_arms("opposite rolling shutters", |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [x, y] = [(); 2].map(|()| normal(&mut rng, 0.4 * 0.02 * FOCAL));
        moved(steady(seed), |[u, v], is_right| {
            let late = v / f64::from(SIZE[1]) - 0.5;
            let late = if is_right { -late } else { late };
            [u + y * late, v + x * late]
        })
    });
}
