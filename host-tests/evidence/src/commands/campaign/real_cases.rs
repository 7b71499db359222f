//! Cases of `evidence campaign real`.

use anyhow::{Error, Result};
use sim::synth::{
    Depth, Disturbance, Fence, LensErrors, Mistake, Motion, Rangefinder, Scenario, ScenarioKind,
    Scene, Witnesses, five_degrees_off, rig,
};
use stereo_selfcal::Extrinsics;

/// Default share of outliers.
const OUTLIERS: f64 = 0.1;

/// A small camera from high above: focal length and image size, px.
const SMALL: (f64, [u16; 2]) = (250.0, [640, 480]);

/// The camera of the project's figures.
const LARGE: (f64, [u16; 2]) = (1400.0, [1920, 1200]);

/// One case of the campaign.
#[derive(Debug, Clone)]
pub(super) struct Case {
    /// Its group.
    pub(super) group: &'static str,
    /// Its name in the group.
    pub(super) name: String,
    /// Its scenes.
    pub(super) scenario: Scenario,
    /// Numbers of pairs after which figures are also reported.
    pub(super) also_after: Vec<usize>,
}

impl Case {
    fn new(group: &'static str, name: impl Into<String>, kind: ScenarioKind, pairs: usize) -> Self {
        let mut scenario = Scenario::new(kind, pairs);
        scenario.scene.outliers = OUTLIERS;
        Self { group, name: name.into(), scenario, also_after: Vec::new() }
    }

    /// `group/name`.
    pub(super) fn path(&self) -> String {
        format!("{}/{}", self.group, self.name)
    }

    fn with(mut self, change: impl FnOnce(&mut Scene)) -> Self {
        change(&mut self.scenario.scene);
        self
    }

    fn with_rig(self, rig: Extrinsics<f64>) -> Self {
        self.with(|scene| scene.rig = rig)
    }

    /// * `errors`: as the option `--lens-error`, or `none`.
    fn with_lens(mut self, errors: &str) -> Result<Self> {
        if errors != "none" {
            let errors: LensErrors = errors.parse().map_err(Error::msg)?;
            self.scenario.lens_prior = errors.prior;
            self.scenario.scene.lens_errors = errors.given;
        }
        Ok(self)
    }

    fn with_camera(self, (focal, size): (f64, [u16; 2])) -> Self {
        self.with(|scene| (scene.focal, scene.size) = (focal, size))
    }
}

/// All cases, group by group.
pub(super) fn all() -> Result<Vec<Case>> {
    let rig = rig([3.0, -2.0, 4.0], [3.0, -3.0])?;
    let mut cases = ideal();
    let others = [
        altitude(),
        lens()?,
        depth()?,
        witnesses()?,
        mistakes(),
        long()?,
        moving()?,
        parked(),
        fences(),
        noise(),
        vibration(),
    ]
    .concat();
    cases.extend(others.into_iter().map(|case| case.with_rig(rig)));
    Ok(cases)
}

/// The scenes of the project's figures, which a change for real rigs must not degrade.
fn ideal() -> Vec<Case> {
    let case = |name, kind| Case::new("ideal", name, kind, 100).with_rig(five_degrees_off());
    vec![
        case("near", ScenarioKind::Near),
        case("far", ScenarioKind::Far),
        case("heterogeneous", ScenarioKind::Heterogeneous),
        case("near-54", ScenarioKind::Near).with(|scene| scene.matches = 54),
    ]
}

/// Disparities from far above the noise to far below it.
fn altitude() -> Vec<Case> {
    let case = |name: String, kind, pairs| Case::new("altitude", name, kind, pairs);
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
    for kind in [ScenarioKind::Climb, ScenarioKind::Descent] {
        for camera in [SMALL, LARGE] {
            cases.push(case(format!("{kind}-f{}", camera.0), kind, 100).with_camera(camera));
        }
    }
    cases
}

/// Each lens error alone, and all lens errors from the prior.
fn lens() -> Result<Vec<Case>> {
    [
        "none",
        "f_r=0.01%",
        "f_r=0.02%",
        "f_r=0.05%",
        "f_r=0.1%",
        "f_r=0.2%",
        "f_r=0.5%",
        "f_r=1%",
        "k1_r=0.0002",
        "k1_r=0.002",
        "k1_r=0.005",
        "k1_r=0.02",
        "cx_r=1",
        "cx_r=5",
        "cy_r=0.5",
        "cy_r=2",
        "p1_r=0.0005",
        "p2_r=0.0005",
        "k2_r=0.01",
        "aspect_r=0.2%",
        "f_both=0.2%",
        "f_both=1%",
        "k1_both=0.02",
        "prior",
    ]
    .map(|errors| Case::new("lens", errors, ScenarioKind::Near, 200).with_lens(errors))
    .into_iter()
    .collect()
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
                let mut case = Case::new("depth", format!("{a}-{knock}-{start}"), kind, 60)
                    .with_lens(&format!("a_r={a}"))?;
                (case.scenario.axis, case.scenario.turn_deg) =
                    (axis, f64::from(u8::from(axis.is_some())));
                case.scenario.commissioned = commissioned;
                cases.push(case);
            }
        }
    }
    // The knock is below the noise of a pair, so it enters the sums of the fusion before it is detected.
    let late = cases.iter().filter(|case| case.name == "0.003-yaw-factory").cloned();
    let few = |mut case: Case| {
        case.name = "few-0.003-yaw-factory".into();
        case.also_after = vec![30, 35, 45];
        case.with(|scene| (scene.matches, scene.noise_px) = (54, 2.0))
    };
    cases.extend(late.map(few).collect::<Vec<_>>());
    Ok(cases)
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
        let mut case =
            Case::new("witness", name, ScenarioKind::Step, 200).with_lens("a_r=0.003")?;
        (case.scenario.axis, case.scenario.turn_deg) = (Some([0.0, 1.0, 0.0]), 1.0);
        case.scenario.witnesses = witnesses;
        case.also_after = vec![100];
        Ok(case)
    };
    let none = [("none".to_owned(), Witnesses::default())];
    none.into_iter().chain(ranges).chain(motions).map(case).collect()
}

/// Matches that must not lead to a calibration.
fn mistakes() -> Vec<Case> {
    let case = |(name, mistake)| {
        let mut case = Case::new("mistake", name, ScenarioKind::Far, 40);
        case.scenario.mistake = Some(mistake);
        case
    };
    [("exchanged", Mistake::Exchanged), ("identical", Mistake::Identical)].map(case).to_vec()
}

/// Small lens errors, which show in time.
fn long() -> Result<Vec<Case>> {
    ["none", "f_r=0.01%", "f_r=0.02%", "cx_r=1", "cy_r=0.5"]
        .map(|errors| Case::new("long", errors, ScenarioKind::Near, 1000).with_lens(errors))
        .into_iter()
        .collect()
}

/// A rig that moves, with a wrong lens.
fn moving() -> Result<Vec<Case>> {
    let case = |kind: ScenarioKind, turn_deg: f64, errors: &str| {
        let mut case = Case::new("moving", format!("{kind}-{turn_deg}-{errors}"), kind, 200);
        case.scenario.turn_deg = turn_deg;
        case.with_lens(errors)
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
fn vibration() -> Vec<Case> {
    let case = |name: String, disturbance: Disturbance| {
        let mut case = Case::new("vibration", name, ScenarioKind::Near, 60);
        case.scenario.disturbance = disturbance;
        case.also_after = vec![8, 10, 15, 30];
        case
    };
    let none = Disturbance::default();
    let mut cases = [0.02, 0.05, 0.1, 0.2]
        .map(|deg| case(deg.to_string(), Disturbance { vibration_deg: deg, ..none }))
        .to_vec();
    cases.extend(
        [0.3, 1.0].map(|px| case(format!("rolling-{px}"), Disturbance { rolling_px: px, ..none })),
    );
    cases.extend(
        [0.05, 0.2].map(|deg| case(format!("skew-{deg}"), Disturbance { skew_deg: deg, ..none })),
    );
    cases.extend([0.05, 0.2].map(|deg| {
        let skew = Disturbance { alternating_skew_deg: deg, ..none };
        case(format!("skew-alternating-{deg}"), skew)
    }));
    cases
}

/// Matches whose errors stay while their landmarks are visible.
fn parked() -> Vec<Case> {
    let mut parked = Case::new("parked", "landmarks", ScenarioKind::ParkedLandmarks, 300);
    parked.also_after = vec![200, 220];
    let creeping = [2.0, 4.0, 10.0].map(|px| {
        let name = format!("creeping-{px}");
        let mut case = Case::new("creeping", name, ScenarioKind::Creeping, 200);
        case.scenario.creep_px = px;
        case
    });
    [vec![parked], creeping.to_vec()].concat()
}

/// Matches that agree with each other but not with the scene.
fn fences() -> Vec<Case> {
    let shapes = [(1.5, false), (3.0, false), (8.0, false), (8.0, true)];
    let fences = [0.2, 0.3, 0.4].into_iter().flat_map(|share| shapes.map(|shape| (share, shape)));
    let case = |(share, (across_px, local))| {
        let place = if local { "-local" } else { "" };
        let case =
            Case::new("fence", format!("{share}-{across_px}{place}"), ScenarioKind::Near, 60);
        case.with(|scene| scene.fence = Some(Fence { share, across_px, local }))
    };
    fences.map(case).collect()
}

/// Noise of poor matchers.
fn noise() -> Vec<Case> {
    let noises = [1.0, 2.0, 4.0].into_iter().flat_map(|px| [(px, 0.0), (px, 0.3)]);
    let case = |(px, outliers): (f64, f64)| {
        let case = Case::new("noise", format!("{px}-outliers-{outliers}"), ScenarioKind::Near, 60);
        case.with(|scene| (scene.noise_px, scene.outliers) = (px, outliers))
    };
    noises.map(case).collect()
}
