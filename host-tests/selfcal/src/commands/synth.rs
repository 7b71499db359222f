//! `selfcal synth`.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use rigs::data::ranges::{self, Ranges};
use rigs::data::tracked::{self, Track};
use sim::synth::{
    Disturbance, Fence, Grid, LensErrors, Mistake, Motion, Rangefinder, Scenario, ScenarioKind,
    Scene, Witnessed, Witnesses, rig,
};

use crate::args::choice;
use crate::args::numbers::numbers;
use crate::args::run::RunArgs;

/// Length of the baseline of a rig with a rangefinder, m.
const BASELINE_M: f64 = 0.12;

/// Generate scenes of a known rig and feed them to the calibrator, or write them as a data set.
///
/// Pinhole cameras, points uniform in the image and log-uniform in depth, Gaussian noise on all four
/// coordinates. Half of the outliers are uniform in the right image, half within 60 px (u) and 20
/// px (v) of the truth. The same seed gives the same scenes.
///
/// A named scene sets its own options; options on the command line override them. If the rig moves (step, drift,
/// flight), every pair and the estimate after it are compared with the rig at that pair.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal synth --pairs 100 --rotation 5,0,0
  selfcal synth far --outliers 0.3 --band 0.2
  selfcal synth planar --depth 5,20 --grid pyramid
  selfcal synth step --step-deg 1 --pairs 40
  selfcal synth flight --pairs 400 --lens-warming 0.001
  selfcal synth --pairs 200 --lens-error f_r=0.1%,cx_r=1
  selfcal synth step --axis 0,1,0 --lens-error a_r=0.005
  selfcal synth step --axis 0,1,0 --step-deg 1 --lens-error a_r=0.003 --rangefinder 0.01
  selfcal synth step --axis 0,1,0 --step-deg 1 --lens-error a_r=0.003 --travel 12,0
  selfcal synth far --mistake exchanged --rotation 0.5,-0.5,0.5
  selfcal synth --vibration 0.05 --pairs 60
  selfcal synth creeping --creep-px 4 --pairs 200
  selfcal synth --pairs 60 --fence 0.3,8 --rotation 3,-2,4
  selfcal synth --pairs 20 --seed 7 --out my_scene && selfcal replay my_scene")]
pub(crate) struct SynthArgs {
    /// Scene to generate.
    #[arg(value_parser = choice::<ScenarioKind>(), default_value_t = ScenarioKind::Near)]
    scene: ScenarioKind,

    /// Stereo pairs to generate.
    #[arg(long, default_value_t = 100)]
    pairs: usize,

    /// Correspondences a pair; in heterogeneous the maximum [default: 256, heterogeneous 512].
    #[arg(long, value_name = "N")]
    matches: Option<usize>,

    /// Standard deviation of each coordinate, new in every pair, px [default: 0.3, parked-landmarks and
    /// creeping 0.1].
    #[arg(long, value_name = "PX")]
    noise: Option<f64>,

    /// Standard deviation of the matching error of each coordinate that a landmark keeps, px; scenes
    /// parked-landmarks and creeping only [default: 0.3].
    #[arg(long, value_name = "PX")]
    landmark_noise: Option<f64>,

    /// Motion of the landmarks through the images from pair to pair, px; scene creeping only [default: 2].
    #[arg(long, value_name = "PX", allow_hyphen_values = true)]
    creep_px: Option<f64>,

    /// Share of gross outliers, 0 to 1 [default: 0, flight 0.3].
    #[arg(long, value_name = "SHARE")]
    outliers: Option<f64>,

    /// A repeated structure: share of the matches on it, and their offset across the rows, px; along the rows each is
    /// off by up to five steps of 12 px. With `local`, only in a part of the image.
    #[arg(long, value_name = "SHARE,PX[,local]", allow_hyphen_values = true)]
    fence: Option<Fence>,

    /// Nearest and farthest depth, in baselines; for planes on the optical axis; for a climb at its foot; in near-few
    /// and sky for the far points [default: the range of the scene, or 3,80].
    #[arg(long, value_parser = numbers::<f64, 2>, value_name = "NEAR,FAR")]
    depth: Option<[f64; 2]>,

    /// Height of the centred band that points come from, in image heights; in heterogeneous the maximum [default: 1,
    /// narrow-band 0.15].
    #[arg(long, value_name = "SHARE")]
    band: Option<f64>,

    /// Grid that the coordinates are rounded to, after the noise: none, multiples of Q px, or the
    /// pixels of a random level of an image pyramid (1.2^level px, level 0 to 7).
    #[arg(long, default_value = "continuous", value_name = "continuous|Q|pyramid")]
    grid: Grid,

    /// Turn of the right camera in mid run, degrees; scenes step and flight only [default: 0.5, flight
    /// 0.3].
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    step_deg: Option<f64>,

    /// Turn of the right camera with every pair, degrees; scene drift only [default: 0.01].
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    drift_deg: Option<f64>,

    /// Turn of the right camera about each axis, new with every pair, degrees RMS [default: 0, flight 0.005].
    #[arg(long, value_name = "D")]
    vibration: Option<f64>,

    /// A rangefinder that reads every tenth pair: its standard deviation over the distance, 0.001 to 0.3. It tells yaw
    /// from the lens. With --out, the readings are in ranges.csv.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    rangefinder: Option<f64>,

    /// Motion of the vehicle before every tenth pair, over which matches are tracked: distance along the left optical
    /// axis, in baselines, and turn about the vertical axis, degrees. Motion tells yaw from the lens. With --out, the
    /// tracks are in quads/.
    #[arg(long, value_parser = travel, value_name = "LENGTHS,DEGREES", allow_hyphen_values = true)]
    travel: Option<[f64; 2]>,

    /// A mistake in all matches; readings of a rangefinder and tracks stay right.
    #[arg(long, value_parser = choice::<Mistake>())]
    mistake: Option<Mistake>,

    /// Axis of the turn of the scenes step, drift and flight, in the right camera's frame [default: random].
    #[arg(long, value_parser = numbers::<f64, 3>, value_name = "X,Y,Z", allow_hyphen_values = true)]
    axis: Option<[f64; 3]>,

    /// Turn of the vehicle between the exposures of left and right (rate times trigger skew), about a random axis, in
    /// the second half of the run, degrees.
    #[arg(long, default_value_t = 0.0, value_name = "D", allow_hyphen_values = true)]
    skew: f64,

    /// Turn as with --skew, but in the whole run and with a sign that alternates from pair to pair, degrees.
    #[arg(long, default_value_t = 0.0, value_name = "D", allow_hyphen_values = true)]
    alternating_skew: f64,

    /// Shift of the right image's upper and lower border against the middle, new with every pair, px RMS:
    /// unsynchronised rolling shutters.
    #[arg(long, default_value_t = 0.0, value_name = "PX")]
    rolling: f64,

    /// True R as a rotation vector, degrees.
    #[arg(long, value_parser = numbers::<f64, 3>, default_value = "0,0,0", value_name = "X,Y,Z",
          allow_hyphen_values = true)]
    rotation: [f64; 3],

    /// Turn of the true t about y and z away from (-1, 0, 0), degrees.
    #[arg(long, value_parser = numbers::<f64, 2>, default_value = "0,0", value_name = "Y,Z",
          allow_hyphen_values = true)]
    baseline: [f64; 2],

    /// Focal length, px.
    #[arg(long, default_value_t = 1400.0, value_name = "PX")]
    focal: f64,

    /// Errors of the true lenses, unknown to the calibrator and absent from a data set: f (relative), aspect (fy,
    /// relative), cx, cy (px), k1, k2, p1, p2, a (rows off by a x y), each with _l, _r or _both; or `prior`: drawn by
    /// the seed from the errors that a calibration has after a year.
    #[arg(long, value_name = "f_r=0.1%,k1_r=0.002,...|prior")]
    lens_error: Option<LensErrors>,

    /// Change of the right camera's focal length from the first pair to the last, relative.
    #[arg(long, default_value_t = 0.0, value_name = "SHARE", allow_hyphen_values = true)]
    lens_warming: f64,

    /// Image width and height, px.
    #[arg(long, value_parser = numbers::<u16, 2>, default_value = "1920,1200", value_name = "W,H")]
    size: [u16; 2],

    /// Seed of the generator.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Write a data set into this new folder instead of running the calibrator.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    run: RunArgs,
}

impl SynthArgs {
    fn witnesses(&self) -> Witnesses {
        let baseline_m = BASELINE_M;
        let rangefinder = self.rangefinder.map(|sd| Rangefinder { baseline_m, sd, nearer: 0.0 });
        let motion = self.travel.map(|[travel, turn_deg]| Motion { travel, turn_deg });
        Witnesses { rangefinder, motion }
    }

    fn scenario(&self) -> Result<Scenario> {
        let named = Scenario::new(self.scene, self.pairs);
        let step = self
            .step_deg
            .filter(|_| matches!(self.scene, ScenarioKind::Step | ScenarioKind::Flight));
        let drift = self.drift_deg.filter(|_| self.scene == ScenarioKind::Drift);
        ensure!(step == self.step_deg, "--step-deg is an option of the scenes step and flight");
        ensure!(drift == self.drift_deg, "--drift-deg is an option of the scene drift");
        ensure!(
            self.landmark_noise.is_none() || self.scene.keeps_landmarks(),
            "--landmark-noise is an option of the scenes parked-landmarks and creeping"
        );
        let creeps = self.creep_px.is_none() || self.scene == ScenarioKind::Creeping;
        ensure!(creeps, "--creep-px is an option of the scene creeping");
        let turns = self.axis.is_none() || self.scene.moves();
        ensure!(turns, "--axis is an option of the scenes step, drift and flight");
        let lens = self.lens_error.unwrap_or_default();
        let scene = Scene {
            size: self.size,
            focal: self.focal,
            lens_errors: lens.given,
            rig: rig(self.rotation, self.baseline)?,
            noise_px: self.noise.unwrap_or(named.scene.noise_px),
            outliers: self.outliers.unwrap_or(named.scene.outliers),
            fence: self.fence,
            depth: self.depth.map_or(named.scene.depth, |range| named.scene.depth.within(range)),
            band: self.band.unwrap_or(named.scene.band),
            matches: self.matches.unwrap_or(named.scene.matches),
            grid: self.grid,
            ..named.scene
        };
        Ok(Scenario {
            scene,
            disturbance: Disturbance {
                vibration_deg: self.vibration.unwrap_or(named.disturbance.vibration_deg),
                skew_deg: self.skew,
                alternating_skew_deg: self.alternating_skew,
                rolling_px: self.rolling,
            },
            turn_deg: step.or(drift).unwrap_or(named.turn_deg),
            axis: self.axis,
            witnesses: self.witnesses(),
            mistake: self.mistake,
            lens_prior: lens.prior,
            lens_warming: self.lens_warming,
            landmark_px: self.landmark_noise.unwrap_or(named.landmark_px),
            creep_px: self.creep_px.unwrap_or(named.creep_px),
            ..named
        })
    }
}

/// A share from 0.001 to 0.3.
fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| (0.001..=0.3).contains(share));
    share.ok_or_else(|| "expected a share from 0.001 to 0.3".into())
}

/// A way of up to 1000 baselines, and a turn of up to 180 degrees.
fn travel(text: &str) -> Result<[f64; 2], String> {
    let found = numbers::<f64, 2>(text)?;
    let fits = found[0].abs() <= 1000.0 && found[1].abs() <= 180.0;
    let expected = "expected a way of up to 1000 baselines and a turn of up to 180 degrees";
    if fits { Ok(found) } else { Err(expected.into()) }
}

/// Runs `selfcal synth`.
pub(crate) fn synth(args: &SynthArgs) -> Result<()> {
    ensure!(!args.run.uses_motion(), "--motion reads the tracks of a recording: choose --travel");
    let scenario = args.scenario()?;
    let set = scenario.dataset(args.seed)?;
    match &args.out {
        Some(dir) => {
            set.save(dir)?;
            let (ranges, tracks) = witnessed(&scenario, args.seed)?;
            if args.rangefinder.is_some() {
                ranges::write(&dir.join("ranges.csv"), &ranges)?;
            }
            if args.travel.is_some() {
                tracked::write(dir, &tracks)?;
            }
            writeln!(io::stdout(), "{} pairs written to {}", set.pairs.len(), dir.display())?;
            Ok(())
        }
        None => args.run.run_with(&set, None, witnessed(&scenario, args.seed)?),
    }
}

/// Ranges by pair, and the tracks of each pair.
fn witnessed(scenario: &Scenario, seed: u64) -> Result<(Ranges, Vec<Vec<Track>>)> {
    if scenario.witnesses == Witnesses::default() {
        return Ok((Ranges::new(), Vec::new()));
    }
    let all = scenario.witnessed(seed)?.into_iter().enumerate();
    Ok(all.map(|(i, Witnessed { readings, tracks })| ((i, readings), tracks)).unzip())
}
