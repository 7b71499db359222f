//! `selfcal import`.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use rigs::data::Meta;
use rigs::formats;
use rigs::read_rig;

use crate::args::rig::{RigArgs, tell_doubts};

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
    let [x, y, z] = meta.t;
    let baseline =
        meta.baseline_m.map_or("not known".into(), |b| format!("{b} m{}", depths(&meta, b)));
    writeln!(io::stdout(), "{out}: t = ({x:.4}, {y:.4}, {z:.4}), baseline {baseline}")?;
    tell_doubts(&meta);
    Ok(())
}

/// The depths that a baseline measures, by which the user knows a wrong unit: the disparity is from half of the width
/// to 1 px.
fn depths(meta: &Meta, baseline_m: f64) -> String {
    let at_1_px = meta.k_l[0][0] * baseline_m;
    let half = f64::from(meta.width) / 2.0;
    format!(
        ": depths from {:.2e} m (a disparity of half the width) to {at_1_px:.2e} m (1 px); if the scene has others, T is in another unit: \
         --unit, or change the file",
        at_1_px / half
    )
}
