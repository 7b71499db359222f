//! `evidence picture`.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;

use crate::pictures::{KNOCKED, WRONG_PX, knocked};

/// Draw the picture of the README: a real pair whose left camera is knocked, before and after calibration.
///
/// Two rows: rectified with the extrinsics of before the knock, and with the estimate from the matches of
/// this one pair. In each row the left image, the right image with level lines and matches, and dense disparities from
/// yellow (near) to dark blue (far), grey where left and right do not agree.
#[derive(Debug, Args)]
pub struct PictureArgs {
    /// Turn of the left camera, degrees upwards.
    #[arg(long, default_value_t = KNOCKED, value_name = "D", allow_hyphen_values = true, value_parser = turn)]
    degrees: f64,

    /// File of the picture (JPEG); its folder is made.
    #[arg(long, value_name = "FILE", default_value = "target/knocked.jpg")]
    out: PathBuf,
}

/// Runs `evidence picture`.
pub(crate) fn picture(args: &PictureArgs) -> Result<()> {
    let knocked = knocked(args.degrees)?;
    let mut out = io::stdout();
    for (name, one) in ["before", "after"].into_iter().zip(&knocked.rectified) {
        let right = 100.0 * one.right;
        writeln!(
            out,
            "{name:<8} row offset {:6.2} px (median), depth of {right:.0} % of the pixels (disparity found and \
             within {WRONG_PX} px of the published one)",
            one.row_offset_px
        )?;
    }
    let write = || {
        args.out.parent().map_or(Ok(()), fs::create_dir_all)?;
        fs::write(&args.out, &knocked.jpeg)
    };
    write().with_context(|| format!("cannot write {}", args.out.display()))?;
    Ok(writeln!(out, "picture  {}", args.out.display())?)
}

fn turn(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|degrees: &f64| degrees.abs() <= 30.0);
    degrees.ok_or_else(|| "expected a turn from -30 to 30 degrees".into())
}
