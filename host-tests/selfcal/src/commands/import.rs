//! `selfcal import`.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use rigs::formats;
use rigs::read_rig;

use crate::args::rig::RigArgs;

/// Read the rig in the files of another tool, and write it as the meta.json of a data set,
/// for `selfcal replay FILE --rig meta.json` or a recording of your own.
///
/// The keys tell the format; all formats are listed below. T, t and `P[0][3]` are negative in x for a side-by-side rig,
/// unless the right camera is mounted upside down.
///
/// A baseline of 1 stands for an unknown one. Lenses: k1 k2 p1 p2 k3, with k4 k5 k6, or a fisheye of four.
#[derive(Debug, Args)]
#[command(after_help = format!("Formats:
{}

Examples:
  selfcal import intrinsics.yml extrinsics.yml --size 640,480 --unit 0.001 --out meta.json
  selfcal import camchain.yaml --out meta.json
  selfcal import camera_info/ --out meta.json", formats::list()))]
pub(crate) struct ImportArgs {
    /// The files of one rig. A folder stands for its *.yaml and *.yml; without these for its JSON, XML, TXT or conf.
    #[arg(required = true, value_name = "FILE|DIR")]
    files: Vec<PathBuf>,

    #[command(flatten)]
    rig: RigArgs,

    /// File for the rig; must not exist.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Plausible baselines of a rig, m.
const LIKELY_M: std::ops::Range<f64> = 0.005..10.0;

/// Runs `selfcal import`.
pub(crate) fn import(args: &ImportArgs) -> Result<()> {
    let out = args.out.display();
    ensure!(!args.out.exists(), "{out} exists: nothing is overwritten");
    let unknowns = args.rig.unknowns();
    let meta = read_rig(&args.files, unknowns)?;
    if let Some(given) = unknowns.sizes.filter(|given| *given != meta.sizes()) {
        let [[w, h], [x, y]] = meta.sizes();
        let [[a, b], [c, d]] = given;
        bail!(
            "{}: the images have {w} x {h} and {x} x {y} px, --size says {a} x {b} and {c} x {d}: leave --size out",
            meta.source
        );
    }
    let text = serde_json::to_string_pretty(&meta)?;
    fs::write(&args.out, text + "\n").with_context(|| format!("cannot write {out}"))?;
    if let Some(b) = meta.baseline_m.filter(|b| !LIKELY_M.contains(b)) {
        eprintln!(
            "note: a baseline of {b} m is unlikely: is the unit of the translation another one (--unit)?"
        );
    }
    let [x, y, z] = meta.t;
    let baseline = meta.baseline_m.map_or("not known".into(), |b| format!("{b} m"));
    writeln!(io::stdout(), "{out}: t = ({x:.4}, {y:.4}, {z:.4}), baseline {baseline}")?;
    Ok(())
}
