//! Mistakes of a first day: whatever is wrong with the data or the rig file, nothing arms, and the cause is named.

use nalgebra::Vector3;
use stereo_selfcal::{
    Arming, Calibrator, Camera, Cameras, Config, Correspondence, Extrinsics, Intrinsics, Lens,
    PairError, RadialTangential, Reason, Reasons, Rejection, State,
};

use crate::api::disturbed::with_outliers;
use crate::api::scene::{SIZE, cameras, correspondences_within, rig};

type Tested = Calibrator<f32, 256>;
type Pair = Vec<Correspondence<f32>>;

const DEPTHS: [[f64; 2]; 2] = [[3.0, 80.0], [30.0, 800.0]];

/// A mistake, as a rig file and a change of each pair.
struct Mistake {
    name: &'static str,
    cameras: Cameras<f32>,
    truth: Extrinsics<f64>,
    change: fn(&Correspondence<f32>) -> Correspondence<f32>,
}

fn truth(seed: u64) -> Extrinsics<f64> {
    let angle = |k: u64| (seed * 7 + k * 5) as f64 % 11.0 / 5.0 - 1.0;
    rig([angle(1), angle(2), angle(3)], [angle(4), angle(5)])
}

fn sized(scale: f32, size: [u16; 2]) -> Cameras<f32> {
    let intrinsics =
        Intrinsics { focal: [1400.0 * scale; 2], principal: [959.5 * scale, 599.5 * scale], size };
    let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
    Cameras { left: camera, right: camera }
}

fn mistakes(seed: u64) -> [Mistake; 15] {
    let given = |name, change| Mistake { name, cameras: cameras(), truth: truth(seed), change };
    let upright = truth(seed);
    let vertical =
        Extrinsics::try_new(upright.rotation().matrix(), &Vector3::new(0.05, -1.0, 0.03)).unwrap();
    let off = |deg: f64| {
        let (sin, cos) = deg.to_radians().sin_cos();
        Extrinsics::try_new(upright.rotation().matrix(), &Vector3::new(-cos, -sin, 0.0)).unwrap()
    };
    let lens =
        Lens::RadialTangential(RadialTangential::try_new([-0.28, 0.07, 0.0, 0.0, 0.0]).unwrap());
    let camera = Camera::try_new(*cameras::<f32>().left.intrinsics(), lens).unwrap();
    let strong = Cameras { left: camera, right: camera };
    let longer = Intrinsics { focal: [1405.0; 2], ..*cameras::<f32>().left.intrinsics() };
    let longer = Camera::try_new(longer, Lens::Pinhole).unwrap();
    let unequal = Cameras { right: longer, ..cameras() };
    [
        given("none", |c| *c),
        given("exchanged", |c| Correspondence { left: c.right, right: c.left, ..*c }),
        given("mirrored", |c| Correspondence { right: [1919.0 - c.right[0], c.right[1]], ..*c }),
        given("upside down", |c| {
            let turned = |[u, v]: [f32; 2]| [1919.0 - u, 1199.0 - v];
            Correspondence { left: turned(c.left), right: turned(c.right), ..*c }
        }),
        given("identical", |c| Correspondence { right: c.left, ..*c }),
        given("u, v exchanged", |c| {
            let exchanged = |[u, v]: [f32; 2]| [v, u];
            Correspondence { left: exchanged(c.left), right: exchanged(c.right), ..*c }
        }),
        Mistake { cameras: sized(0.5, SIZE.map(|n| n / 2)), ..given("half size", |c| *c) },
        Mistake { cameras: sized(2.0, SIZE.map(|n| n * 2)), ..given("double size", |c| *c) },
        Mistake { truth: vertical, ..given("vertical", |c| *c) },
        Mistake { truth: off(60.0), ..given("t 60 off", |c| *c) },
        Mistake { truth: off(120.0), ..given("t 120 off", |c| *c) },
        Mistake { truth: off(150.0), ..given("t 150 off", |c| *c) },
        given("identical, moved", |c| {
            let [u, v] = c.left;
            Correspondence { left: [(u + 20.0).min(1919.0), v], right: [u.min(1899.0), v], ..*c }
        }),
        Mistake {
            cameras: unequal,
            ..given("identical, unequal", |c| Correspondence { right: c.left, ..*c })
        },
        Mistake { cameras: strong, ..given("undistorted", |c| *c) },
    ]
}

/// After the pairs of a run.
#[derive(Default, Debug)]
struct Outcome {
    armed: u32,
    locked: u32,
    behind: u32,
    columns: u32,
    no_depth: u32,
    unfit: u32,
    fused: u32,
}

/// Applies after every pair, as a careless vehicle does.
fn run(config: Config, mistake: &Mistake, depths: [f64; 2], seed: u64) -> Outcome {
    let mut calibrator = Tested::new(config);
    calibrator.set_cameras(mistake.cameras);
    let mut outcome = Outcome::default();
    for pair in 0..20 {
        let matches: Pair =
            correspondences_within(&mistake.truth, depths, 250, 0.5, seed * 1000 + pair);
        let matches = if seed.is_multiple_of(2) { with_outliers(matches, 4) } else { matches };
        calibrator.clear_pair();
        for c in &matches {
            let _ = calibrator.push(&(mistake.change)(c));
        }
        let solved = calibrator.solve_pair().map_err(Rejection::from);
        match solved.and_then(|_| Ok(calibrator.fuse()?)) {
            Ok(_) => outcome.fused += 1,
            Err(Rejection::Unsolved(PairError::Behind)) => outcome.behind += 1,
            Err(Rejection::Unsolved(PairError::Columns)) => outcome.columns += 1,
            Err(Rejection::Unsolved(PairError::NoDepth)) => outcome.no_depth += 1,
            Err(_) => {}
        }
        let _ = calibrator.apply();
        let health = calibrator.health();
        let armed = health.is_some_and(|health| health.arming == Arming::Yes);
        let is_unfit = |reasons: Reasons| {
            reasons.contains(Reason::Refused) || reasons.contains(Reason::Corner)
        };
        outcome.unfit += u32::from(health.is_some_and(|health| is_unfit(health.reasons)));
        outcome.armed += u32::from(armed);
        outcome.locked += u32::from(calibrator.state() == State::Locked);
    }
    outcome
}

/// Runs of both depths that a mistake locks or arms in, and those that name it.
fn locked_and_named(
    config: Config,
    names: &[&str],
    is_named: fn(&Outcome) -> bool,
) -> Vec<(&'static str, usize, usize)> {
    let of = |index: usize| {
        let name = mistakes(0)[index].name;
        let runs = DEPTHS.iter().flat_map(|depths| (0..12).map(move |seed| (depths, seed)));
        let outcomes: Vec<_> =
            runs.map(|(depths, seed)| run(config, &mistakes(seed)[index], *depths, seed)).collect();
        let count = |is: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|o| is(o)).count();
        (name, count(&|o| o.armed + o.locked > 0), count(&|o| is_named(o)))
    };
    let is_asked = |index: &usize| names.contains(&mistakes(0)[*index].name);
    (0..mistakes(0).len()).filter(is_asked).map(of).collect()
}

#[test]
fn a_rig_as_given_locks_and_arms() {
    for depths in DEPTHS {
        for seed in 0..12 {
            let outcome = run(Config::robust(), &mistakes(seed)[0], depths, seed);
            assert_eq!((outcome.armed, outcome.locked, outcome.fused), (17, 17, 20), "{outcome:?}");
        }
    }
}

const REVERSED: [&str; 3] = ["exchanged", "mirrored", "upside down"];

#[test]
fn points_behind_the_cameras_lock_nothing_and_are_named() {
    for (name, locked, named) in
        locked_and_named(Config::robust(), &REVERSED, |outcome| outcome.behind > 0)
    {
        assert!(locked == 0 && named >= 20, "{name}: {locked} locked, {named} named of 24");
    }
}

#[test]
fn the_published_method_takes_no_points_behind_the_cameras() {
    let config = Config::paper();
    for (name, locked, _) in locked_and_named(config, &REVERSED, |outcome| outcome.behind > 0) {
        assert!(locked == 0, "{name}: {locked} locked of 24");
    }
}

#[test]
fn a_baseline_along_the_columns_locks_nothing_and_is_named() {
    let turned = ["u, v exchanged", "vertical", "t 60 off", "t 120 off"];
    for (name, locked, named) in
        locked_and_named(Config::robust(), &turned, |outcome| outcome.columns > 0)
    {
        assert!(locked == 0 && named >= 20, "{name}: {locked} locked, {named} named of 24");
    }
    let is_named = |outcome: &Outcome| outcome.columns + outcome.behind > 0;
    for (name, locked, named) in locked_and_named(Config::robust(), &["t 150 off"], is_named) {
        assert!(locked == 0 && named >= 20, "{name}: {locked} locked, {named} named of 24");
    }
}

#[test]
fn the_same_image_on_both_sides_locks_nothing_and_is_named() {
    let identical = ["identical", "identical, moved", "identical, unequal"];
    for (name, locked, named) in
        locked_and_named(Config::robust(), &identical, |outcome| outcome.no_depth > 0)
    {
        // With unequal intrinsics most pairs are `Unobservable` or without consensus.
        let is_named = named >= 20 || name == "identical, unequal";
        assert!(locked == 0 && is_named, "{name}: {locked} locked, {named} named of 24");
    }
}

#[test]
fn matches_of_images_of_another_size_arm_nothing_and_are_named() {
    for index in 0..mistakes(0).len() {
        let name = mistakes(0)[index].name;
        if !["half size", "double size"].contains(&name) {
            continue;
        }
        for (depths, seed) in
            DEPTHS.iter().flat_map(|depths| (0..12).map(move |seed| (depths, seed)))
        {
            let outcome = run(Config::robust(), &mistakes(seed)[index], *depths, seed);
            let is_named = outcome.unfit > 0 || outcome.locked == 0;
            assert!(outcome.armed == 0 && is_named, "{name} {depths:?} {seed}: {outcome:?}");
        }
    }
}
