//! Campaigns over scenes of real rigs: wrong lenses, altitude, vibration and other situations of a vehicle.
#![expect(clippy::unnecessary_wraps, reason = "all groups of cases have one type")]

use anyhow::{Error, Result};
use sim::run::LensTracking::{self, Compensate};
use sim::synth::{
    Depth, Disturbance, LensErrors, Mistake, Motion, Rangefinder, Scenario, ScenarioKind, Scene,
    Witnesses, five_degrees_off, rig,
};
use stereo_selfcal::Extrinsics;

use super::made::fences;
use super::{Campaign, Case, Measure};

/// Default share of outliers.
const OUTLIERS: f64 = 0.1;

/// A small camera from high above: focal length and image size, px.
const SMALL: (f64, [u16; 2]) = (250.0, [640, 480]);

/// The camera of the project's figures.
const LARGE: (f64, [u16; 2]) = (1400.0, [1920, 1200]);

const LENSES: &str = "e_t median, e_t worst, e_t over sd 95 %, e_R over sd 95 %, armed at 50, armed, \
    runs beyond 5 sd";
const REFOCUS: &str = "e_t median, e_t worst, e_t over sd 95 %, e_R over sd 95 %, yaw in use worst, \
    yaw over reported worst, armed, runs beyond 5 sd";
const OVER_FIT: &str =
    "e_t over joint fit, e_R over joint fit, e_t median, e_t worst, runs beyond 5 sd";
const ALTITUDE: &str =
    "e_R over joint fit, e_t median, e_t in use over start worst, runs beyond 5 sd";
const VIBRATION: &str = "ever locked, e_t median, e_R median, e_t over sd 95 %, e_R over sd 95 %, \
    vibration R least, vibration R most, runs beyond 5 sd";
const METRIC: &str = "e_R median, e_R worst, e_t median, e_R over sd worst, runs beyond 5 sd";
const YAW: &str = "yaw in use worst, yaw in use, yaw over reported worst, reloads";
const MISTAKE: &str = "ever locked, armed";

type Group = fn() -> Result<Vec<Case>>;

pub(super) fn campaigns() -> Vec<Campaign> {
    let near_54 = Some("ideal/near-54");
    let shaken_runs = real("vibration", VIBRATION, || cases(&[vibration, rolling]));
    let high_runs = real("altitude-1000", ALTITUDE, || cases(&[altitude]));
    vec![
        Campaign { quick: near_54, ..real("ideal", OVER_FIT, ideal) },
        real("lenses", LENSES, || cases(&[lens, moving, creeping, long, parked])),
        Campaign {
            lens: Compensate,
            ..real("compensated", LENSES, || cases(&[lens, moving, creeping, shaken]))
        },
        Campaign { lens: Compensate, ..real("refocus", REFOCUS, || cases(&[refocused])) },
        real("fences", OVER_FIT, || cases(&[fenced, noise])),
        Campaign { trials: 200, seeds: &[4_000_000], ..shaken_runs },
        Campaign {
            quick: Some("altitude/f250-300-3000"),
            ..real("altitude", ALTITUDE, || cases(&[altitude]))
        },
        Campaign { trials: 1000, seeds: &[3_000_000], ..high_runs },
        real("climb", ALTITUDE, || cases(&[climb])),
        Campaign {
            trials: 6,
            quick: Some("depth/0-"),
            ..real("depth", METRIC, || cases(&[depth]))
        },
        Campaign {
            trials: 6,
            worst_first: Some("yaw in use worst"),
            ..real("drift", YAW, || cases(&[drift, small_knocks, warm_up, drives, quiet]))
        },
        real("witness", METRIC, || cases(&[witnesses])),
        Campaign { quick: Some("mistake/"), ..real("mistakes", MISTAKE, || cases(&[mistakes])) },
    ]
}

/// 24 runs of each case.
fn real(name: &'static str, columns: &'static str, cases: Group) -> Campaign {
    let (lens, measure) = (LensTracking::Report, Measure::Runs(cases));
    Campaign {
        name,
        trials: 24,
        seeds: &[1_000_000],
        lens,
        columns,
        quick: None,
        worst_first: None,
        measure,
        chart: None,
    }
}

/// The cases of some groups, whose rig is 3 to 5 degrees off.
fn cases(groups: &[Group]) -> Result<Vec<Case>> {
    let rig = rig([3.0, -2.0, 4.0], [3.0, -3.0])?;
    let groups: Vec<Vec<Case>> = groups.iter().map(|group| group()).collect::<Result<_>>()?;
    Ok(groups.concat().into_iter().map(|case| case.with_rig(rig)).collect())
}

impl Case {
    fn real(group: &str, name: impl AsRef<str>, kind: ScenarioKind, pairs: usize) -> Self {
        let mut scenario = Scenario::new(kind, pairs);
        scenario.scene.outliers = OUTLIERS;
        let name = format!("{group}/{}", name.as_ref());
        Self { name, scenarios: vec![scenario], also_after: &[] }
    }

    fn changed(mut self, change: impl FnOnce(&mut Scenario)) -> Self {
        self.scenarios.first_mut().map(change);
        self
    }

    fn with(self, change: impl FnOnce(&mut Scene)) -> Self {
        self.changed(|scenario| change(&mut scenario.scene))
    }

    fn with_rig(self, rig: Extrinsics<f64>) -> Self {
        self.with(|scene| scene.rig = rig)
    }

    /// * `errors`: as the option `--lens-error`, or `none`.
    fn with_lens(self, errors: &str) -> Result<Self> {
        if errors == "none" {
            return Ok(self);
        }
        let LensErrors { prior, given, .. } = errors.parse().map_err(Error::msg)?;
        Ok(self.changed(|one| (one.lens_prior, one.scene.lens_errors) = (prior, given)))
    }

    fn with_camera(self, (focal, size): (f64, [u16; 2])) -> Self {
        self.with(|scene| (scene.focal, scene.size) = (focal, size))
    }
}

/// The scenes of the project's figures, which a change for real rigs must not degrade.
fn ideal() -> Result<Vec<Case>> {
    let case = |name, kind| Case::real("ideal", name, kind, 100).with_rig(five_degrees_off());
    Ok(vec![
        case("near", ScenarioKind::Near),
        case("far", ScenarioKind::Far),
        case("heterogeneous", ScenarioKind::Heterogeneous),
        case("near-54", ScenarioKind::Near).with(|scene| scene.matches = 54),
    ])
}

/// Disparities from far above the noise to far below it.
fn altitude() -> Result<Vec<Case>> {
    let case = |name: String, kind, pairs| Case::real("altitude", name, kind, pairs);
    let depths = |camera: (f64, [u16; 2]), range: [f64; 2]| {
        let name = format!("f{}-{}-{}", camera.0, range[0], range[1]);
        let case = case(name, ScenarioKind::Altitude, 60).with_camera(camera);
        case.with(|scene| scene.depth = Depth::LogUniform(range))
    };
    let small = [[300.0, 3000.0], [500.0, 5000.0], [1000.0, 10_000.0]];
    let large =
        [[3.0, 80.0], [30.0, 800.0], [300.0, 3000.0], [1000.0, 10_000.0], [3000.0, 30_000.0]];
    let mut cases: Vec<Case> = small.map(|range| depths(SMALL, range)).to_vec();
    cases.extend(large.map(|range| depths(LARGE, range)));
    cases.extend([0.0, OUTLIERS, 0.3].map(|outliers| {
        let name = format!("near-few-{outliers}");
        case(name, ScenarioKind::NearFew, 60).with(|scene| scene.outliers = outliers)
    }));
    cases.push(case("sky".into(), ScenarioKind::Sky, 60));
    Ok(cases)
}

/// From 3 to 80 baselines to a thousand times as far, and back.
fn climb() -> Result<Vec<Case>> {
    let all = [ScenarioKind::Climb, ScenarioKind::Descent].into_iter();
    let all = all.flat_map(|kind| [SMALL, LARGE].map(|camera| (kind, camera)));
    let case = |(kind, camera): (ScenarioKind, (f64, _))| {
        Case::real("altitude", format!("{kind}-f{}", camera.0), kind, 100).with_camera(camera)
    };
    Ok(all.map(case).collect())
}

/// Each lens error alone, and all lens errors from the prior.
fn lens() -> Result<Vec<Case>> {
    let all = "none f_r=0.01% f_r=0.02% f_r=0.05% f_r=0.1% f_r=0.2% f_r=0.5% f_r=1% \
        k1_r=0.0002 k1_r=0.002 k1_r=0.005 k1_r=0.02 cx_r=1 cx_r=5 cy_r=0.5 cy_r=2 \
        p1_r=0.0005 p2_r=0.0005 k2_r=0.01 aspect_r=0.2% f_both=0.2% f_both=1% \
        k1_both=0.02 prior";
    let case = |errors| Case::real("lens", errors, ScenarioKind::Near, 200).with_lens(errors);
    all.split(' ').map(case).collect()
}

/// Lenses that change in mid run, with and without a factory calibration.
fn refocused() -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for errors in ["f_r=0.2%", "f_r=0.5%", "f_r=1%", "f_r=2%", "k1_r=0.005", "k1_r=0.02"] {
        for (start, commissioned) in [("factory", true), ("guess", false)] {
            let name = format!("{errors}-{start}");
            let case = Case::real("refocus", name, ScenarioKind::Refocus, 200);
            cases.push(case.with_lens(errors)?.changed(|one| one.commissioned = commissioned));
        }
    }
    Ok(cases)
}

/// Rows off by `a x y`, with or without a factory calibration, and with or without a knock of 1 degree about each axis
/// of the right camera in mid run.
fn depth() -> Result<Vec<Case>> {
    let knocks = [
        ("none", None),
        ("pitch", Some([1.0, 0.0, 0.0])),
        ("yaw", Some([0.0, 1.0, 0.0])),
        ("roll", Some([0.0, 0.0, 1.0])),
    ];
    let mut cases = Vec::new();
    for a in [0.0, 0.001, 0.003, 0.01] {
        for (knock, axis) in knocks {
            for (start, commissioned) in [("factory", true), ("guess", false)] {
                let kind = if axis.is_some() { ScenarioKind::Step } else { ScenarioKind::Near };
                let case = Case::real("depth", format!("{a}-{knock}-{start}"), kind, 60);
                let turn_deg = f64::from(u8::from(axis.is_some()));
                cases.push(case.with_lens(&format!("a_r={a}"))?.changed(|one| {
                    (one.axis, one.turn_deg, one.commissioned) = (axis, turn_deg, commissioned);
                }));
            }
        }
    }
    // The knock is below the noise of a pair, so it enters the sums of the fusion before it is detected.
    let late = cases.iter().filter(|case| case.name == "depth/0.003-yaw-factory").cloned();
    let few = |mut case: Case| {
        case.name = "depth/few-0.003-yaw-factory".into();
        case.also_after = &[30, 35, 45];
        case.with(|scene| (scene.matches, scene.noise_px) = (54, 2.0))
    };
    cases.extend(late.map(few).collect::<Vec<_>>());
    Ok(cases)
}

/// Axes of a turn, right camera frame.
const YAW_AXIS: (&str, [f64; 3]) = ("yaw", [0.0, 1.0, 0.0]);
const PITCH_AXIS: (&str, [f64; 3]) = ("pitch", [1.0, 0.0, 0.0]);
const MIXED_AXIS: (&str, [f64; 3]) = ("mixed", [1.0, 1.0, 1.0]);

/// Cases of a turn, with exact lenses and with rows off by `a x y`, with and without a factory calibration.
fn turning(
    kind: ScenarioKind,
    (axis, direction): (&str, [f64; 3]),
    turn_deg: f64,
    pairs: usize,
) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for a in [0.0, 0.003] {
        for (start, commissioned) in [("factory", true), ("guess", false)] {
            let name = format!("{kind}-{axis}-{turn_deg:.2e}-{a}-{start}");
            let case = Case::real("drift", name, kind, pairs).with_lens(&format!("a_r={a}"))?;
            cases.push(case.changed(|one| {
                (one.axis, one.turn_deg, one.commissioned) =
                    (Some(direction), turn_deg, commissioned);
            }));
        }
    }
    Ok(cases)
}

/// A drift of 3e-7 to 3e-4 rad a pair.
fn drift() -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (rad, pairs) in [(3e-7_f64, 2000), (3e-6, 1000), (3e-5, 300), (3e-4, 60)] {
        for axis in [YAW_AXIS, PITCH_AXIS, MIXED_AXIS] {
            cases.extend(turning(ScenarioKind::Drift, axis, rad.to_degrees(), pairs)?);
        }
    }
    Ok(cases)
}

/// Knocks of a few hundredths of a degree.
fn small_knocks() -> Result<Vec<Case>> {
    let all = [0.02, 0.05, 0.1].into_iter().flat_map(|deg| [(YAW_AXIS, deg), (PITCH_AXIS, deg)]);
    let cases = all.map(|(axis, deg)| turning(ScenarioKind::Step, axis, deg, 200));
    Ok(cases.collect::<Result<Vec<_>>>()?.concat())
}

/// A mount that warms up and cools down.
fn warm_up() -> Result<Vec<Case>> {
    let all = [0.1, 0.3].into_iter().flat_map(|deg| [(YAW_AXIS, deg), (MIXED_AXIS, deg)]);
    let cases = all.map(|(axis, deg)| turning(ScenarioKind::WarmUp, axis, deg, 600));
    Ok(cases.collect::<Result<Vec<_>>>()?.concat())
}

/// A long rest between two drives, with and without a knock.
fn drives() -> Result<Vec<Case>> {
    let cases = [0.0, 0.1].map(|deg| turning(ScenarioKind::Drives, YAW_AXIS, deg, 2000));
    Ok(cases.into_iter().collect::<Result<Vec<_>>>()?.concat())
}

/// A rig that does not move, whose reloads count.
fn quiet() -> Result<Vec<Case>> {
    turning(ScenarioKind::Near, YAW_AXIS, 0.0, 1050)
}

/// A turn of yaw and rows off by `a x y`, without a factory calibration, with ranges or motion that tell them apart.
fn witnesses() -> Result<Vec<Case>> {
    let ranges = [0.01, 0.03, 0.1].map(|sd| {
        let rangefinder = Some(Rangefinder { baseline_m: 0.12, sd, nearer: 0.1 });
        (format!("range-{}%", 100.0 * sd), Witnesses { rangefinder, motion: None })
    });
    let motions = [(0.0, 0.0), (0.0, 5.0), (4.0, 0.0), (12.0, 0.0), (12.0, 5.0)];
    let motions = motions.map(|(travel, turn_deg)| {
        let motion = Some(Motion { travel, turn_deg });
        (format!("motion-{travel}-turn-{turn_deg}"), Witnesses { rangefinder: None, motion })
    });
    let case = |(name, witnesses): (String, Witnesses)| {
        let case = Case::real("witness", name, ScenarioKind::Step, 200).with_lens("a_r=0.003")?;
        Ok(case.changed(|one| {
            (one.axis, one.turn_deg, one.witnesses) = (Some([0.0, 1.0, 0.0]), 1.0, witnesses);
        }))
    };
    let none = [("none".to_owned(), Witnesses::default())];
    none.into_iter().chain(ranges).chain(motions).map(case).collect()
}

/// Matches that must not lead to a calibration.
fn mistakes() -> Result<Vec<Case>> {
    let case = |(name, mistake)| {
        let case = Case::real("mistake", name, ScenarioKind::Far, 40);
        case.changed(|one| one.mistake = Some(mistake))
    };
    Ok([("exchanged", Mistake::Exchanged), ("identical", Mistake::Identical)].map(case).to_vec())
}

/// Small lens errors, which show in time.
fn long() -> Result<Vec<Case>> {
    ["none", "f_r=0.01%", "f_r=0.02%", "cx_r=1", "cy_r=0.5"]
        .map(|errors| Case::real("long", errors, ScenarioKind::Near, 1000).with_lens(errors))
        .into_iter()
        .collect()
}

/// A rig that moves, with a wrong lens.
fn moving() -> Result<Vec<Case>> {
    let case = |kind: ScenarioKind, turn_deg: f64, errors: &str| {
        let case = Case::real("moving", format!("{kind}-{turn_deg}-{errors}"), kind, 200);
        case.changed(|one| one.turn_deg = turn_deg).with_lens(errors)
    };
    [
        case(ScenarioKind::Drift, 0.005, "none"),
        case(ScenarioKind::Drift, 0.005, "f_r=0.1%"),
        case(ScenarioKind::Drift, 0.005, "f_r=0.2%"),
        case(ScenarioKind::Step, 0.5, "f_r=0.1%"),
    ]
    .into_iter()
    .collect()
}

/// Views that move against each other from pair to pair.
fn shaken() -> Result<Vec<Case>> {
    let none = Disturbance::default();
    let all = [0.02, 0.05, 0.1, 0.2];
    let vibrating =
        |deg: f64| disturbed(deg.to_string(), Disturbance { vibration_deg: deg, ..none });
    Ok(all.map(vibrating).into())
}

fn rolling() -> Result<Vec<Case>> {
    let none = Disturbance::default();
    let rolling = |px: f64| (format!("rolling-{px}"), Disturbance { rolling_px: px, ..none });
    let skew = |deg: f64| (format!("skew-{deg}"), Disturbance { skew_deg: deg, ..none });
    let alternating = |deg: f64| {
        let skew = Disturbance { alternating_skew_deg: deg, ..none };
        (format!("skew-alternating-{deg}"), skew)
    };
    let all = [[0.3, 1.0].map(rolling), [0.05, 0.2].map(skew), [0.05, 0.2].map(alternating)];
    let all = all.concat().into_iter();
    Ok(all.map(|(name, disturbance)| disturbed(name, disturbance)).collect())
}

fn vibration() -> Result<Vec<Case>> {
    Ok(shaken()?.into_iter().map(|case| Case { also_after: &[8, 10, 15, 30], ..case }).collect())
}

fn disturbed(name: String, disturbance: Disturbance) -> Case {
    let case = Case::real("vibration", name, ScenarioKind::Near, 60);
    case.changed(|one| one.disturbance = disturbance)
}

/// Matches whose errors stay while their landmarks are visible.
fn parked() -> Result<Vec<Case>> {
    Ok(vec![Case::real("parked", "landmarks", ScenarioKind::ParkedLandmarks, 300)])
}

fn creeping() -> Result<Vec<Case>> {
    let creeping = |px: f64| {
        let case = Case::real("creeping", format!("{px}-px"), ScenarioKind::Creeping, 200);
        case.changed(|one| one.creep_px = px)
    };
    Ok([2.0, 4.0, 10.0].map(creeping).into())
}

/// Matches that agree with each other but not with the scene.
fn fenced() -> Result<Vec<Case>> {
    let case = |(name, fence): (String, _)| {
        Case::real("fence", name, ScenarioKind::Near, 60).with(|scene| scene.fence = Some(fence))
    };
    Ok(fences().into_iter().map(case).collect())
}

/// Noise of poor matchers.
fn noise() -> Result<Vec<Case>> {
    let noises = [0.0, 0.3].into_iter().flat_map(|share| [1.0, 2.0, 4.0].map(|px| (px, share)));
    let case = |(px, outliers): (f64, f64)| {
        let case = Case::real("noise", format!("{px}-outliers-{outliers}"), ScenarioKind::Near, 60);
        case.with(|scene| (scene.noise_px, scene.outliers) = (px, outliers))
    };
    Ok(noises.map(case).collect())
}
