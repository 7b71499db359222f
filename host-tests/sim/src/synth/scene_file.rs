//! Scene files: a scenario as YAML, with a key for each parameter.

use std::collections::BTreeMap;
use std::fmt;

use anyhow::{Context, Result, anyhow, bail, ensure};
use serde_json::Value;

use super::lens_error::LensErrors;
use super::rig::rig;
use super::scenario::Scenario;
use super::scenario_kind::ScenarioKind;

/// Number of pairs of a named scene.
const PAIRS: usize = 100;

/// A scenario as a file has it. [`fmt::Display`] writes the complete file, with a comment for each key.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneFile {
    /// All other parameters, with the rig and the lens errors of the named scene.
    pub scenario: Scenario,
    /// True `R` as a rotation vector, degrees.
    pub rotation_deg: [f64; 3],
    /// Turn of the true `t` about y and z away from (-1, 0, 0), degrees.
    pub baseline_deg: [f64; 2],
    lens_errors: Option<String>,
}

/// Declares each key once: its comment, and its place in [`SceneFile`].
macro_rules! keys {
    ($($(#[doc = $doc:literal])+ $key:ident: $($place:ident).+,)+) => {
        impl SceneFile {
            /// The keys of a file, in their order.
            pub const KEYS: &[&str] = &[$(stringify!($key)),+];

            fn set(&mut self, key: &str, value: Value) -> Result<()> {
                match key {
                    $(stringify!($key) => {
                        self.$($place).+ = serde_json::from_value(value)
                            .map_err(|why| anyhow!("{key}: {why}. Meaning:{}", concat!($($doc),+)))?;
                    })+
                    _ => bail!("`{key}` is not a key; the keys are {}", Self::KEYS.join(", ")),
                }
                Ok(())
            }

            /// The comment, the key and the value of each parameter.
            fn entries(&self) -> Vec<(&'static [&'static str], &'static str, Value)> {
                vec![$((&[$($doc),+], stringify!($key), serde_json::json!(self.$($place).+))),+]
            }
        }
    };
}

keys! {
    /// A named scene (`selfcal synth --help` lists them). It tells what varies from pair to pair, and its values stand
    /// for the keys that are left out.
    scene: scenario.kind,
    /// Number of pairs.
    pairs: scenario.pairs,
    /// Correspondences of a pair; in heterogeneous the maximum.
    matches: scenario.scene.matches,
    /// Standard deviation of each coordinate, new in every pair, px.
    noise_px: scenario.scene.noise_px,
    /// Standard deviation of the matching error of each coordinate that a landmark keeps, px; only in parked-landmarks
    /// and creeping.
    landmark_px: scenario.landmark_px,
    /// Motion of the landmarks through the images from pair to pair, px; only in creeping.
    creep_px: scenario.creep_px,
    /// Share of gross outliers, 0 to 1. Half of them are uniform in the right image, half within 60 px (u) and 20 px
    /// (v) of the truth.
    outliers: scenario.scene.outliers,
    /// A repeated structure, such as {share: 0.3, across_px: 8, local: true}: share of the matches on it, and their
    /// offset across the rows, px. Along the rows each is off by up to five steps of 12 px. local: only in a part of
    /// the image.
    fence: scenario.scene.fence,
    /// Depth of the points in baselines, log-uniform: [nearest, farthest]. For planes it is the depth on the optical
    /// axis, for a climb the depth at its foot. Or two ranges, {near: [3, 80], share: 0.06, far: [300, 3000]}, with the
    /// share of the near points. Or one plane, {on_axis: 12, slope: [-0.8, 0.5]}, with the tangents of its slant.
    depth: scenario.scene.depth,
    /// Height of the band of rows that the points come from, in image heights; in heterogeneous the maximum.
    band: scenario.scene.band,
    /// Middle of the band, in image heights from the top.
    band_centre: scenario.scene.band_centre,
    /// Grid that the coordinates are rounded to, after the noise: continuous (none), {pixels: 0.5} (multiples of 0.5
    /// px), or pyramid (pixels of a random level of an image pyramid: 1.2^level px, level 0 to 7).
    grid: scenario.scene.grid,
    /// Turn of the right camera, degrees: in mid run in step and flight, with every pair in drift, at most in warm-up,
    /// before the second drive in drives; elsewhere 0.
    turn_deg: scenario.turn_deg,
    /// Axis of turn_deg in the right camera's frame, [x, y, z]; null is a random one.
    axis: scenario.axis,
    /// Turn of the right camera about each axis, new with every pair, degrees RMS.
    vibration_deg: scenario.disturbance.vibration_deg,
    /// Turn of the vehicle between the exposures of left and right (rate times trigger skew), about a random axis, in
    /// the second half of the run, degrees.
    skew_deg: scenario.disturbance.skew_deg,
    /// The same turn in the whole run, with a sign that alternates from pair to pair, degrees.
    alternating_skew_deg: scenario.disturbance.alternating_skew_deg,
    /// Shift of the right image's upper and lower border against the middle, new with every pair, px RMS:
    /// unsynchronised rolling shutters.
    rolling_px: scenario.disturbance.rolling_px,
    /// A rangefinder that reads every tenth pair, such as {baseline_m: 0.12, sd: 0.01, nearer: 0}: baseline of the rig,
    /// m; standard deviation of a reading over the distance; share of the readings that hit something nearer. It tells
    /// yaw from the lens. The readings are in ranges.csv.
    rangefinder: scenario.witnesses.rangefinder,
    /// Motion of the vehicle before every tenth pair, such as {travel: 12, turn_deg: 0}: distance along the left
    /// optical axis, in baselines, and turn about the vertical axis, degrees. It tells yaw from the lens. The matches
    /// that are tracked over it are in quads/.
    motion: scenario.witnesses.motion,
    /// A mistake in all matches: exchanged (left and right), or identical (both images are the left one). Readings of a
    /// rangefinder and tracks stay right.
    mistake: scenario.mistake,
    /// True R as a rotation vector, degrees.
    rotation_deg: rotation_deg,
    /// Turn of the true t about y and z away from (-1, 0, 0), degrees.
    baseline_deg: baseline_deg,
    /// Focal length of both cameras, px.
    focal_px: scenario.scene.focal,
    /// Width and height of the images, px.
    size_px: scenario.scene.size,
    /// Errors of the true lenses, which the data set does not have, such as f_r=0.1%,k1_both=0.002: f (relative),
    /// aspect (fy, relative), cx, cy (px), k1, k2, p1, p2, a (rows off by a x y), each with _l, _r or _both; or prior:
    /// drawn by the seed from the errors that a calibration has after a year.
    lens_errors: lens_errors,
    /// Change of the right camera's focal length from the first pair to the last, relative.
    lens_warming: scenario.lens_warming,
}

impl SceneFile {
    /// A named scene.
    #[must_use]
    pub fn named(scene: ScenarioKind) -> Self {
        Self {
            scenario: Scenario::new(scene, PAIRS),
            rotation_deg: [0.0; 3],
            baseline_deg: [0.0; 2],
            lens_errors: None,
        }
    }

    /// Reads a scene file.
    ///
    /// # Errors
    /// Names the line that is not YAML, or the key with the wrong value.
    pub fn read(yaml: &str) -> Result<Self> {
        let mut keys: BTreeMap<String, Value> =
            serde_saphyr::from_str(yaml).map_err(|why| anyhow!("{}", why.without_snippet()))?;
        let mut file = Self::named(ScenarioKind::default());
        let scene =
            keys.remove("scene").context("the key `scene` with a named scene is missing")?;
        file.set("scene", scene)?;
        file = Self::named(file.scenario.kind);
        keys.into_iter().try_for_each(|(key, value)| file.set(&key, value))?;
        Ok(file)
    }

    /// The scenario.
    ///
    /// # Errors
    /// Names a key that another scene has, or whose value is out of range. [`Scenario::frames`] checks the others.
    pub fn scenario(&self) -> Result<Scenario> {
        let mut scenario = self.scenario.clone();
        let kind = scenario.kind;
        let turns = scenario.turn_deg != 0.0;
        ensure!(
            !turns || kind.moves(),
            "turn_deg is for the scenes step, drift, warm-up, drives and flight"
        );
        let axis = scenario.axis.is_some();
        ensure!(!axis || kind.moves(), "axis is for the scenes step, drift and flight");
        let keeps = scenario.landmark_px == 0.0 || kind.keeps_landmarks();
        ensure!(keeps, "landmark_px is for the scenes parked-landmarks and creeping");
        let creeps = scenario.creep_px == 0.0 || kind == ScenarioKind::Creeping;
        ensure!(creeps, "creep_px is for the scene creeping");
        scenario.witnesses.check()?;
        scenario.scene.rig = rig(self.rotation_deg, self.baseline_deg)
            .context("rotation_deg and baseline_deg give no rig")?;
        if let Some(text) = &self.lens_errors {
            let LensErrors { given, prior } =
                text.parse().map_err(|why| anyhow!("lens_errors: {why}"))?;
            (scenario.scene.lens_errors, scenario.lens_prior) = (given, prior);
        }
        Ok(scenario)
    }
}

impl fmt::Display for SceneFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (comment, key, value) in self.entries() {
            comment.iter().try_for_each(|line| writeln!(f, "#{line}"))?;
            writeln!(f, "{key}: {}", flow(&value))?;
        }
        Ok(())
    }
}

/// A value in one line of YAML.
fn flow(value: &Value) -> String {
    match value {
        Value::Array(all) => format!("[{}]", all.iter().map(flow).collect::<Vec<_>>().join(", ")),
        Value::Object(all) => {
            let all: Vec<_> =
                all.iter().map(|(key, one)| format!("{key}: {}", flow(one))).collect();
            format!("{{{}}}", all.join(", "))
        }
        Value::String(plain) => plain.clone(),
        // Without the decimal point of a whole number.
        other => other.as_f64().map_or_else(|| other.to_string(), |x| x.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use strum::VariantArray;

    use super::*;
    use crate::synth::{
        Depth, Disturbance, Fence, Grid, Mistake, Motion, Rangefinder, Scene, Witnesses,
    };

    #[test]
    fn a_printed_scene_reads_back_to_the_same_scenario_and_explains_each_key() {
        for &scene in ScenarioKind::VARIANTS {
            let named = SceneFile::named(scene);
            let printed = named.to_string();
            assert_eq!(SceneFile::read(&printed).unwrap(), named, "{printed}");
            assert_eq!(named.scenario().unwrap(), Scenario::new(scene, PAIRS));
            assert_eq!(SceneFile::read(&format!("scene: {scene}")).unwrap(), named);
            for key in SceneFile::KEYS {
                let (above, _) = printed.split_once(&format!("\n{key}: ")).unwrap();
                assert!(above.lines().last().unwrap().starts_with("# "), "{key}: {printed}");
            }
        }
    }

    const ALL: &str = "scene: creeping
pairs: 7
matches: 99
noise_px: 0.2
landmark_px: 0.25
creep_px: 3
outliers: 0.15
fence: {share: 0.4, across_px: -8, local: true}
depth: {near: [3, 80], share: 0.1, far: [100, 200]}
band: 0.5
band_centre: 0.6
grid: {pixels: 0.5}
turn_deg: 0.7
axis: [0, 1, 0]
vibration_deg: 0.01
skew_deg: 0.02
alternating_skew_deg: 0.03
rolling_px: 0.04
rangefinder: {baseline_m: 0.2, sd: 0.01, nearer: 0.1}
motion: {travel: 12, turn_deg: -3}
mistake: exchanged
rotation_deg: [1, 2, 3]
baseline_deg: [4, 5]
focal_px: 800
size_px: [640, 480]
lens_errors: f_r=0.1%,k1_both=0.002,prior
lens_warming: 0.001
";

    #[test]
    fn every_key_sets_its_parameter() {
        let keys: Vec<&str> = ALL.lines().filter_map(|line| line.split(':').next()).collect();
        assert_eq!(keys, SceneFile::KEYS);
        let scene = Scene {
            size: [640, 480],
            focal: 800.0,
            noise_px: 0.2,
            outliers: 0.15,
            fence: Some(Fence { share: 0.4, across_px: -8.0, local: true }),
            depth: Depth::Mixture { near: [3.0, 80.0], share: 0.1, far: [100.0, 200.0] },
            band: 0.5,
            band_centre: 0.6,
            matches: 99,
            grid: Grid::Pixels(0.5),
            ..Scene::default()
        };
        let scenario = Scenario {
            scene,
            turn_deg: 0.7,
            axis: Some([0.0, 1.0, 0.0]),
            witnesses: Witnesses {
                rangefinder: Some(Rangefinder { baseline_m: 0.2, sd: 0.01, nearer: 0.1 }),
                motion: Some(Motion { travel: 12.0, turn_deg: -3.0 }),
            },
            mistake: Some(Mistake::Exchanged),
            disturbance: Disturbance {
                vibration_deg: 0.01,
                skew_deg: 0.02,
                alternating_skew_deg: 0.03,
                rolling_px: 0.04,
            },
            lens_warming: 0.001,
            landmark_px: 0.25,
            creep_px: 3.0,
            ..Scenario::new(ScenarioKind::Creeping, 7)
        };
        let file = SceneFile::read(ALL).unwrap();
        assert_eq!(file.scenario, scenario);
        assert_eq!(SceneFile::read(&file.to_string()).unwrap(), file);
        let text = ALL.replace("creeping", "step").replace("0.25", "0").replace("creep_px: 3", "");
        let read = SceneFile::read(&text).unwrap().scenario().unwrap();
        assert_eq!(read.scene.rig, rig([1.0, 2.0, 3.0], [4.0, 5.0]).unwrap());
        let lens: LensErrors = "f_r=0.1%,k1_both=0.002".parse().unwrap();
        assert_eq!((read.scene.lens_errors, read.lens_prior), (lens.given, true));
    }

    #[test]
    fn depth_is_a_range_two_ranges_or_a_plane() {
        let depth = |text: &str| {
            let file = SceneFile::read(&format!("scene: near\ndepth: {text}"));
            file.map(|file| file.scenario.scene.depth)
        };
        assert_eq!(depth("[5, 20]").unwrap(), Depth::LogUniform([5.0, 20.0]));
        let plane = Depth::Plane { on_axis: 12.0, slope: [-0.8, 0.5] };
        assert_eq!(depth("{on_axis: 12, slope: [-0.8, 0.5]}").unwrap(), plane);
        for wrong in ["3", "[3]", "{near: [3, 80]}", "{on_axis: 12, slope: [0, 0], share: 1}"] {
            let why = format!("{:#}", depth(wrong).unwrap_err());
            assert!(why.contains("expected [nearest, farthest], {near"), "{wrong}: {why}");
        }
    }

    #[test]
    fn a_wrong_value_is_named_by_its_key() {
        for (text, said) in [
            ("pairs: 3", "`scene` with a named scene is missing"),
            ("scene: nearr", "unknown variant `nearr`, expected one of `near`, `far`"),
            ("scene: near\nnoise: 1", "`noise` is not a key; the keys are scene, pairs"),
            (
                "scene: near\nnoise_px: a lot",
                "noise_px: invalid type: string \"a lot\", expected f64. Meaning: Standard deviation",
            ),
            ("scene: near\nnoise_px: .inf", "non-finite float `.inf` rejected"),
            (
                "scene: near\npairs: -3",
                "pairs: invalid value: integer `-3`, expected usize. Meaning: Number of pairs.",
            ),
            ("scene: near\naxis: [0, 1]", "axis: invalid length 2, expected an array of length 3"),
            ("scene: near\ngrid: fine", "expected one of `continuous`, `pixels`, `pyramid`"),
            ("scene: near\nmistake: some", "expected `exchanged` or `identical`"),
            ("scene: near\nfence: {share: 0.4}", "missing field `across_px`"),
            ("scene: near\nmotion: {travel: 1, turn: 2}", "unknown field `turn`"),
            ("scene: near\npairs: 3\npairs: 4", "duplicate"),
            ("scene: near\npairs", "line 2"),
            ("scene: near\nturn_deg: 1", "turn_deg is for the scenes step"),
            ("scene: near\naxis: [0, 1, 0]", "axis is for the scenes step"),
            ("scene: parked\nlandmark_px: 1", "landmark_px is for the scenes parked"),
            ("scene: parked\ncreep_px: 1", "creep_px is for the scene creeping"),
            ("scene: near\nrangefinder: {baseline_m: 1, sd: 0.5, nearer: 0}", "sd must be"),
            ("scene: near\nrangefinder: {baseline_m: 0, sd: 0.1, nearer: 0}", "baseline_m must"),
            ("scene: near\nrangefinder: {baseline_m: 1, sd: 0.1, nearer: 2}", "nearer must be"),
            ("scene: near\nmotion: {travel: 2000, turn_deg: 2}", "travel must be"),
            ("scene: near\nmotion: {travel: 2, turn_deg: 200}", "turn_deg must be"),
            ("scene: near\nbaseline_deg: [90, 0]", "baseline_deg"),
            ("scene: near\nlens_errors: z_r=1", "lens_errors: `z_r` is not one of"),
            ("scene: near\noutliers: 1.5", "outliers must be"),
            ("scene: near\nfence: {share: 4, across_px: 1}", "fence's share must be"),
            ("scene: near\nband_centre: 0.9", "band must be"),
            ("scene: near\nsize_px: [1, 1]", "image must be"),
            ("scene: near\nfocal_px: 0", "focal must be"),
            ("scene: step\naxis: [0, 0, 0]", "axis of a turn must"),
        ] {
            let frames =
                SceneFile::read(text).and_then(|file| file.scenario()?.frames(1).map(drop));
            let why = format!("{:#}", frames.expect_err(text));
            assert!(why.contains(said), "{text}: {why}");
        }
    }
}
