//! `selfcal synth`.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use rigs::data::{ranges, tracked};
use sim::synth::{Scenario, ScenarioKind, SceneFile};
use strum::{EnumMessage, VariantArray};

use crate::args::parse::numbers;

/// Generate a data set of a known rig, for `selfcal replay DIR`: a named scene, or a scene file.
///
/// Pinhole cameras, points uniform in the image and log-uniform in depth, Gaussian noise on all four coordinates. The
/// same seed gives the same scenes. If the rig moves (step, drift, flight), the data set has the rig of every pair, and
/// a replay compares each pair and the estimate after it with the rig at that pair.
///
/// A scene file is YAML. --print writes the complete file of a scene, with a comment for each key. A key that a file
/// leaves out has the value of the file's named scene. Options win over the file.
#[derive(Debug, Args)]
#[command(after_help = format!("Scenes:
{}
Examples:
  selfcal synth near --rotation 5,0,0 --outliers 0.3 --out near && selfcal replay near
  selfcal synth planar --print > my_scene.yaml
  selfcal synth my_scene.yaml --seed 7 --out my_scene

A scene file, here of a knock of 1 degree about the vertical axis, and a lens that has changed:
  scene: step
  turn_deg: 1
  axis: [0, 1, 0]
  lens_errors: f_r=0.1%,cx_r=1
  rangefinder: {{baseline_m: 0.12, sd: 0.01, nearer: 0}}", scenes()))]
pub(crate) struct SynthArgs {
    /// Name of a scene, or a scene file.
    #[arg(value_name = "SCENE|FILE")]
    scene: PathBuf,

    /// Stereo pairs to generate [default: 100].
    #[arg(long, value_name = "N")]
    pairs: Option<usize>,

    /// Correspondences a pair; in heterogeneous the maximum [default: 256, heterogeneous 512].
    #[arg(long, value_name = "N")]
    matches: Option<usize>,

    /// Standard deviation of each coordinate, new in every pair, px [default: 0.3, parked-landmarks and creeping 0.1].
    #[arg(long, value_name = "PX")]
    noise: Option<f64>,

    /// Share of gross outliers, 0 to 1 [default: 0, flight 0.3].
    #[arg(long, value_name = "SHARE")]
    outliers: Option<f64>,

    /// True R as a rotation vector, degrees [default: 0,0,0].
    #[arg(long, value_parser = numbers::<f64, 3>, value_name = "X,Y,Z", allow_hyphen_values = true)]
    rotation: Option<[f64; 3]>,

    /// Turn of the true t about y and z away from (-1, 0, 0), degrees [default: 0,0].
    #[arg(long, value_parser = numbers::<f64, 2>, value_name = "Y,Z", allow_hyphen_values = true)]
    baseline: Option<[f64; 2]>,

    /// Seed of the generator.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// New folder for the data set.
    #[arg(long, value_name = "DIR", required_unless_present = "print")]
    out: Option<PathBuf>,

    /// Print the scene file instead.
    #[arg(long, conflicts_with = "out")]
    print: bool,
}

/// Runs `selfcal synth`.
pub(crate) fn synth(args: &SynthArgs) -> Result<()> {
    let file = args.file()?;
    let scenario = file.scenario().with_context(|| args.scene.display().to_string())?;
    match &args.out {
        Some(dir) => write(&scenario, args.seed, dir),
        None => Ok(write!(io::stdout(), "{file}")?),
    }
}

impl SynthArgs {
    /// The named scene or the scene file, with the values of the options.
    fn file(&self) -> Result<SceneFile> {
        let mut file = open(&self.scene)?;
        let SceneFile { scenario, rotation_deg, baseline_deg, .. } = &mut file;
        give(self.pairs, &mut scenario.pairs);
        give(self.matches, &mut scenario.scene.matches);
        give(self.noise, &mut scenario.scene.noise_px);
        give(self.outliers, &mut scenario.scene.outliers);
        give(self.rotation, rotation_deg);
        give(self.baseline, baseline_deg);
        Ok(file)
    }
}

fn give<T>(option: Option<T>, value: &mut T) {
    if let Some(given) = option {
        *value = given;
    }
}

fn open(scene: &Path) -> Result<SceneFile> {
    if let Some(named) = scene.to_str().and_then(|name| name.parse().ok()) {
        return Ok(SceneFile::named(named));
    }
    let place = scene.display();
    ensure!(
        scene.is_file(),
        "{place} is neither a scene nor a scene file; the scenes are\n{}",
        scenes()
    );
    let yaml = fs::read_to_string(scene).with_context(|| format!("cannot read {place}"))?;
    SceneFile::read(&yaml).with_context(|| format!("{place}"))
}

/// A line for each named scene.
fn scenes() -> String {
    let line = |scene: &ScenarioKind| {
        let words = scene.get_documentation().unwrap_or_default().split_whitespace();
        format!("  {scene}: {}\n", words.collect::<Vec<_>>().join(" "))
    };
    ScenarioKind::VARIANTS.iter().map(line).collect()
}

fn write(scenario: &Scenario, seed: u64, dir: &Path) -> Result<()> {
    scenario.dataset(seed)?.save(dir)?;
    let (readings, tracks): (Vec<_>, Vec<_>) =
        scenario.witnessed(seed)?.into_iter().map(|after| (after.readings, after.tracks)).unzip();
    let place = dir.display();
    let (mut with_ranges, mut with_motion) = (String::new(), "");
    if scenario.witnesses.rangefinder.is_some() {
        ranges::write(&dir.join("ranges.csv"), &readings.into_iter().enumerate().collect())?;
        with_ranges = format!(" --ranges {place}/ranges.csv");
    }
    if scenario.witnesses.motion.is_some() {
        tracked::write(dir, &tracks)?;
        with_motion = " --motion";
    }
    writeln!(
        io::stdout(),
        "{} pairs written to {place}: selfcal replay {place}{with_ranges}{with_motion}",
        scenario.pairs
    )?;
    Ok(())
}
