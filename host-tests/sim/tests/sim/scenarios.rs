//! Properties of the scenarios. The reference of a moving rig is the truth of each pair.

use nalgebra::{Matrix3, Vector3};
use rigs::data::{Dataset, TurnedView};
use sim::run::{Start, replay};
use sim::synth::{
    Depth, Disturbance, LensError, LensErrors, Scenario, ScenarioKind, ScenarioPair, Scene, rig,
};
use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::metrics::rotation_angle;
use stereo_selfcal::geometry::so3;
use stereo_selfcal::paper::Settings;
use strum::VariantArray;

fn frames(kind: ScenarioKind, pairs: usize) -> Vec<ScenarioPair> {
    let mut scenario = Scenario::new(kind, pairs);
    scenario.scene.rig = rig([2.0, -3.0, 1.0], [2.0, -1.0]).unwrap();
    scenario.scene.outliers = 0.2;
    scenario.frames(7).unwrap().collect()
}

/// Inverse depths of the points of a frame, per baseline, and their left rays at unit depth.
fn inverse_depths(ScenarioPair { scene, pair, .. }: &ScenarioPair) -> Vec<(f64, Vector3<f64>)> {
    let inverse = |&pixels: &[f64; 4]| {
        let [p_l, p_r] = scene.rays(pixels);
        // `p_r z_r = R p_l z_l + t`, multiplied by `p_r` (cross product).
        let turned = p_r.cross(&(scene.rig.rotation() * p_l));
        let known = p_r.cross(&scene.rig.translation().into_inner());
        (-known.dot(&turned) / known.norm_squared(), p_l)
    };
    pair.clean.iter().map(inverse).collect()
}

/// Largest distance of the points from the plane fitted to them, in inverse depth, and the slope of the plane.
fn fitted_plane(frame: &ScenarioPair) -> (f64, [f64; 2]) {
    let points = inverse_depths(frame);
    let normal: Matrix3<f64> = points.iter().map(|(_, p)| p * p.transpose()).sum();
    let right: Vector3<f64> = points.iter().map(|(inverse, p)| p * *inverse).sum();
    let plane = normal.lu().solve(&right).unwrap();
    let off = points.iter().map(|(inverse, p)| (inverse - p.dot(&plane)).abs());
    (off.fold(0.0, f64::max), [plane.x / plane.z, plane.y / plane.z])
}

#[test]
fn every_scenario_is_the_same_for_the_same_seed_and_differs_for_another_seed() {
    for &kind in ScenarioKind::VARIANTS {
        let scenario = Scenario::new(kind, 4);
        let of = |seed| scenario.frames(seed).unwrap().collect::<Vec<ScenarioPair>>();
        assert_eq!(of(1), of(1), "{kind}");
        assert_ne!(of(1)[0].pair, of(2)[0].pair, "{kind}");
        assert_eq!(of(1).len(), 4, "{kind}");
        let fresh = of(1)[2].pair.clean != of(1)[3].pair.clean;
        assert_eq!(fresh, kind != ScenarioKind::Parked, "{kind}");
    }
}

#[test]
fn near_is_the_scene_of_the_figures() {
    let default = Scene::default();
    let frames = Scenario::new(ScenarioKind::Near, 3).frames(5).unwrap();
    for (ScenarioPair { scene, pair, .. }, expected) in frames.zip(default.pairs(5)) {
        assert_eq!((&scene, pair), (&default, expected));
    }
}

#[test]
fn far_points_are_far() {
    for (kind, [near, far]) in [
        (ScenarioKind::Far, [30.0, 800.0]),
        (ScenarioKind::VeryFar, [300.0, 3000.0]),
        (ScenarioKind::Altitude, [1000.0, 10_000.0]),
    ] {
        for (inverse, _) in frames(kind, 3).iter().flat_map(inverse_depths) {
            assert!((near - 0.001..far + 0.01).contains(&inverse.recip()), "{kind} {inverse}");
        }
    }
}

#[test]
fn a_small_share_of_the_points_is_near_and_the_others_are_far_or_in_the_sky() {
    for (kind, share, far) in
        [(ScenarioKind::NearFew, 0.06, [300.0, 3000.0]), (ScenarioKind::Sky, 0.05, [1e5, 1e7])]
    {
        let inverses: Vec<f64> =
            frames(kind, 20).iter().flat_map(inverse_depths).map(|(inverse, _)| inverse).collect();
        // For 5120 points, 4 standard deviations of the share are below 0.014.
        let count = |n: usize| f64::from(u32::try_from(n).unwrap());
        let near = inverses.iter().filter(|&&inverse| inverse > 1.0 / 80.001).count();
        let found = count(near) / count(inverses.len());
        assert!((found - share).abs() < 0.014, "{kind}: {found}");
        let rest = inverses.iter().filter(|&&inverse| inverse <= 1.0 / 80.001);
        let [least, most] = [1.0 / far[1], 1.0 / far[0]];
        for inverse in rest {
            assert!((least - 1e-9..most + 1e-9).contains(inverse), "{kind}: {inverse}");
        }
    }
}

#[test]
fn a_climb_multiplies_depths_by_a_thousand_and_a_descent_reverses_it() {
    let ranges = |kind| -> Vec<[f64; 2]> {
        let range = |frame: &ScenarioPair| match frame.scene.depth {
            Depth::LogUniform(range) => range,
            Depth::Mixture { .. } | Depth::Plane { .. } => [f64::NAN; 2],
        };
        frames(kind, 5).iter().map(range).collect()
    };
    let [up, mut down] = [ScenarioKind::Climb, ScenarioKind::Descent].map(ranges);
    down.reverse();
    assert_eq!(ranges(ScenarioKind::Near)[0].map(f64::to_bits), up[0].map(f64::to_bits));
    for (i, (up, down)) in (0..5).zip(up.iter().zip(&down)) {
        let factor = 1000_f64.powf(f64::from(i) / 4.0);
        assert!((up[0] / (3.0 * factor) - 1.0).abs() < 1e-12, "{i}: {up:?}");
        assert!((up[1] / (80.0 * factor) - 1.0).abs() < 1e-12, "{i}: {up:?}");
        assert!((down[0] / up[0] - 1.0).abs() < 1e-12, "{i}: {down:?}");
    }
    assert_eq!(frames(ScenarioKind::Climb, 1).len(), 1);
}

#[test]
fn a_narrow_band_is_in_the_middle_rows() {
    for ScenarioPair { pair, .. } in frames(ScenarioKind::NarrowBand, 3) {
        let rows = pair.clean.iter().map(|[_, v, ..]| (v - 599.5).abs() / 1199.0);
        assert!((0.07..=0.075).contains(&rows.fold(0.0, f64::max)));
    }
}

#[test]
fn points_of_a_planar_pair_are_coplanar_and_each_pair_has_a_new_plane() {
    let mut seen: Vec<[f64; 2]> = Vec::new();
    for frame in frames(ScenarioKind::Planar, 50) {
        let (off, [x, y]) = fitted_plane(&frame);
        assert!(off < 1e-9, "{off}");
        let slant = x.hypot(y).atan().to_degrees();
        assert!((14.999..60.001).contains(&slant), "{slant}");
        assert!(seen.iter().all(|[u, v]| (x - u).hypot(y - v) > 1e-6));
        seen.push([x, y]);
    }
    assert!(fitted_plane(&frames(ScenarioKind::Near, 1)[0]).0 > 0.1);
}

#[test]
fn a_fronto_parallel_plane_has_one_depth_a_pair() {
    let depths: Vec<f64> = frames(ScenarioKind::FrontoParallel, 50)
        .iter()
        .map(|frame| {
            let inverse = inverse_depths(frame);
            assert!(inverse.iter().all(|(i, _)| (i - inverse[0].0).abs() < 1e-9));
            inverse[0].0.recip()
        })
        .collect();
    assert!(depths.iter().all(|z| (2.999..80.001).contains(z)));
    assert!(depths.iter().any(|&z| z < 8.0) && depths.iter().any(|&z| z > 40.0));
}

#[test]
fn heterogeneous_pairs_differ_in_matches_depth_and_band() {
    let frames = frames(ScenarioKind::Heterogeneous, 200);
    let matches: Vec<usize> = frames.iter().map(|f| f.pair.matches.len()).collect();
    assert!(matches.iter().all(|n| (48..=512).contains(n)));
    assert!(matches.iter().any(|&n| n < 80) && matches.iter().any(|&n| n > 480));
    let centred = frames.iter().filter(|f| (f.scene.band_centre - 0.5).abs() < 1e-9).count();
    assert!((70..130).contains(&centred), "{centred}");
    let mut few = Scenario::new(ScenarioKind::Heterogeneous, 5);
    few.scene.matches = 30;
    assert!(few.frames(1).unwrap().all(|frame| frame.pair.matches.len() == 30));
}

#[test]
fn parked_pairs_show_the_same_points_and_outliers_under_new_noise() {
    let frames = frames(ScenarioKind::Parked, 5);
    let first = &frames[0].pair;
    assert!(first.inlier.contains(&false));
    for ScenarioPair { pair, .. } in &frames[1..] {
        assert_eq!((&pair.clean, &pair.matched), (&first.clean, &first.matched));
        assert_eq!(pair.inlier, first.inlier);
        assert_ne!(pair.matches, first.matches);
    }
}

#[test]
fn a_step_turns_the_rig_once_in_mid_run() {
    for (pairs, still) in [(1, 1), (10, 5), (11, 6)] {
        let frames = frames(ScenarioKind::Step, pairs);
        for (i, frame) in frames.iter().enumerate() {
            let turn = rotation_angle(frame.scene.rig.rotation(), frames[0].scene.rig.rotation());
            let expected = if i < still { 0.0 } else { 0.5_f64.to_radians() };
            assert!((turn - expected).abs() < 1e-12, "{pairs} {i}: {turn}");
        }
    }
}

#[test]
fn a_drift_turns_the_rig_by_the_same_angle_with_every_pair() {
    let frames = frames(ScenarioKind::Drift, 20);
    for two in frames.windows(2) {
        let turn = two[1].scene.rig.rotation() * two[0].scene.rig.rotation().inverse();
        let vector = so3::log(&turn);
        assert!((vector.norm() - 0.01_f64.to_radians()).abs() < 1e-12);
        let t = turn * two[0].scene.rig.translation().into_inner();
        assert!((t - two[1].scene.rig.translation().into_inner()).norm() < 1e-12);
    }
    let whole = rotation_angle(frames[19].scene.rig.rotation(), frames[0].scene.rig.rotation());
    assert!((whole - 0.19_f64.to_radians()).abs() < 1e-12);
}

#[test]
fn a_warm_up_turns_the_rig_and_turns_it_back() {
    let frames = frames(ScenarioKind::WarmUp, 101);
    let turns: Vec<f64> = frames
        .iter()
        .map(|frame| rotation_angle(frame.scene.rig.rotation(), frames[0].scene.rig.rotation()))
        .map(f64::to_degrees)
        .collect();
    assert!(turns[..51].is_sorted() && turns[50..].is_sorted_by(|a, b| a > b), "{turns:?}");
    // One time constant after the start, and at the end.
    assert!((turns[10] - 0.0632).abs() < 1e-4 && (turns[50] - 0.0993).abs() < 1e-4, "{turns:?}");
    assert!(turns[100] < 0.001, "{turns:?}");
}

#[test]
fn two_drives_have_a_rest_between_and_a_turn_after_it() {
    let frames = frames(ScenarioKind::Drives, 20);
    let is_same = |i: usize| frames[i].pair.clean == frames[i - 1].pair.clean;
    let is_turned = |i: usize| frames[i].scene.rig != frames[0].scene.rig;
    for i in 1..20 {
        assert_eq!([is_same(i), is_turned(i)], [(6..15).contains(&i), i >= 15], "{i}");
    }
}

#[test]
fn a_flight_vibrates_warps_is_knocked_once_and_climbs() {
    let scenario = Scenario::new(ScenarioKind::Flight, 100);
    let calm = Scenario { disturbance: Disturbance::default(), ..scenario.clone() };
    let [rigs, steady] = [&scenario, &calm].map(|scenario| scenario.rigs(4).unwrap());
    let turn = |a: &Extrinsics<f64>, b: &Extrinsics<f64>| {
        so3::log(&(b.rotation() * a.rotation().inverse())).map(f64::to_degrees)
    };
    let shakes = rigs.iter().zip(&steady).map(|(rig, steady)| turn(steady, rig));
    let squares: Vector3<f64> = shakes.map(|shake| shake.component_mul(&shake)).sum();
    let rms = (squares / 100.0).map(f64::sqrt);
    assert!(rms.iter().all(|rms| (0.004..0.006).contains(rms)), "{rms}");
    for (i, two) in steady.windows(2).enumerate() {
        let turned = turn(&two[0], &two[1]).norm();
        let expected = if i + 1 == scenario.turned_from() { 0.3 } else { 0.0005 };
        assert!((turned - expected).abs() < 0.0006, "{i}: {turned}");
    }
    let farthest = |frame: &ScenarioPair| match frame.scene.depth {
        Depth::LogUniform([_, far]) => far,
        Depth::Mixture { .. } | Depth::Plane { .. } => f64::NAN,
    };
    let far: Vec<f64> = scenario.frames(4).unwrap().map(|frame| farthest(&frame)).collect();
    assert!((far[0] - 80.0).abs() < 1e-9 && (far[50] - 800.0).abs() < 1e-9 && far[99] < 90.0);
}

/// Largest epipolar residual `|p_r^T E p_l|` of the noise-free matches of a frame, with the cameras and the rig of
/// `scene`.
fn off_epipolar(frame: &ScenarioPair, scene: &Scene) -> f64 {
    let e = scene.rig.translation().cross_matrix() * scene.rig.rotation().matrix();
    let off = frame.pair.clean.iter().map(|&pixels| {
        let [p_l, p_r] = scene.rays(pixels);
        p_r.dot(&(e * p_l)).abs()
    });
    off.fold(0.0, f64::max)
}

#[test]
fn pixels_come_from_the_true_lenses_and_a_data_set_has_the_nominal_ones() {
    let nominal = Scenario::new(ScenarioKind::Near, 2);
    let mut given = nominal.clone();
    let errors = "f_l=0.3%,cy_r=2,k1_l=0.01,k2_r=0.01,p1_r=0.001,p2_l=-0.001";
    given.scene.lens_errors = errors.parse::<LensErrors>().unwrap().given;
    let prior = Scenario { lens_prior: true, ..nominal.clone() };
    for wrong in [&given, &prior] {
        for frame in wrong.frames(3).unwrap() {
            assert!(off_epipolar(&frame, &frame.scene) < 1e-12);
            assert!(off_epipolar(&frame, &nominal.scene) > 1e-4);
        }
        let meta = wrong.dataset(3).unwrap().meta;
        assert_eq!(meta, nominal.dataset(3).unwrap().meta);
    }
    let drawn = |seed| prior.frames(seed).unwrap().next().unwrap().scene.lens_errors;
    assert_ne!(drawn(3), drawn(4));
}

#[test]
fn a_lens_warms_evenly_from_the_first_pair_to_the_last() {
    let warm = Scenario { lens_warming: 0.002, ..Scenario::new(ScenarioKind::Flight, 5) };
    for (i, frame) in (0..5).zip(warm.frames(1).unwrap()) {
        let [left, right] = frame.scene.lens_errors;
        assert_eq!(left, LensError::NONE);
        assert!((right.focal - 0.0005 * f64::from(i)).abs() < 1e-15, "{i}: {right:?}");
        assert!(off_epipolar(&frame, &frame.scene) < 1e-12);
    }
}

#[test]
fn a_pair_without_a_common_view_is_named() {
    let away = Scenario { turn_deg: 15.0, ..Scenario::new(ScenarioKind::Drift, 30) };
    let error = format!("{:#}", away.frames(1).err().unwrap());
    assert!(error.contains("pair "), "{error}");
}

/// A step of 2 degrees, with so much noise that the rows of an aligned rig do not tie.
fn step() -> Dataset {
    let mut scenario = Scenario { turn_deg: 2.0, ..Scenario::new(ScenarioKind::Step, 6) };
    scenario.scene.noise_px = 0.02;
    scenario.dataset(3).unwrap()
}

/// Errors of `R`, rad: of the single pairs, of the running estimate, and of the final estimate.
fn errors(set: &Dataset) -> ([Vec<f64>; 2], f64) {
    let run = replay::<f64>(set, Settings::DEFAULT, Start::Guess, |_| {}).unwrap();
    let single = run.steps().iter().map(|step| step.solved.unwrap().error.unwrap().rotation);
    let running = run.steps().iter().map(|step| step.running.unwrap().rotation);
    ([single.collect(), running.collect()], run.summary(set).unwrap().e_theta.unwrap())
}

#[test]
fn pairs_and_estimate_are_compared_with_the_truth_of_their_time() {
    let set = step();
    let ([single, running], last) = errors(&set);
    assert!(single.iter().all(|&e| e < 1e-4), "{single:?}");
    assert!(running[..3].iter().all(|&e| e < 1e-4) && running[3] > 0.01, "{running:?}");
    assert_eq!(last.to_bits(), running[5].to_bits());
    // Compared with the truth of the last pair, the pairs before the step are wrong by the angle of the step.
    let ([single, _], _) = errors(&Dataset { rigs: Vec::new(), ..set });
    assert!((single[0] - 2_f64.to_radians()).abs() < 1e-4 && single[5] < 1e-4, "{single:?}");
}

#[test]
fn a_turned_view_turns_the_truth_of_each_pair() {
    let ([single, _], _) = errors(&TurnedView::Top.turn(&step(), 3.0).unwrap());
    assert!(single.iter().all(|&e| e < 1e-4), "{single:?}");
}

#[test]
fn a_saved_moving_scenario_loads_back_with_the_rig_of_each_pair() {
    for (kind, rigs) in [(ScenarioKind::Step, 4), (ScenarioKind::Drift, 4), (ScenarioKind::Near, 0)]
    {
        let set = Scenario::new(kind, 4).dataset(1).unwrap();
        assert_eq!(set.rigs.len(), rigs, "{kind}");
        let dir = tempfile::tempdir().unwrap();
        let copy = dir.path().join("copy");
        set.save(&copy).unwrap();
        let loaded = Dataset::load(&copy).unwrap();
        // Not `assert_eq`: it would print every match.
        assert!(Dataset { name: set.name.clone(), ..loaded } == set, "{kind}");
        if let Some(last) = set.rigs.last() {
            assert_eq!((last.r, last.t), (set.meta.r, set.meta.t), "{kind}");
        }
    }
}
