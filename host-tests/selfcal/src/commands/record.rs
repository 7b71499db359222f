//! `selfcal record`.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use rigs::data::Dataset;
use sim::wire::{Faults, FaultyWire, Sender, Sent};

use crate::args::parse::share;

/// Write a data set as the bytes that a matcher sends, frame after frame, for `selfcal replay FILE` or your own
/// receiver; optionally over a wire with faults.
///
/// The format is version 1 of stereo_selfcal::link, coordinates in 1/256 px. The file holds only the bytes on the wire,
/// so the log of a vehicle's matcher has this format too.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal record opencv_chess_sift flight.scmf
  selfcal record opencv_chess_sift bad.scmf --damaged 0.2 --dropped 0.1 --seed 7
  selfcal replay bad.scmf --rig opencv_chess_sift")]
pub(crate) struct RecordArgs {
    /// Folder of a data set, or the name of one that comes with the project.
    #[arg(value_name = "DATASET")]
    set: PathBuf,

    /// File for the bytes; must not exist.
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Share of the frames that are damaged: flipped bits, lost, inserted or repeated bytes, an overwritten run, a
    /// missing end.
    #[arg(long, value_name = "SHARE", value_parser = share, default_value_t = 0.0)]
    damaged: f64,

    /// Share of the frames that never arrive.
    #[arg(long, value_name = "SHARE", value_parser = share, default_value_t = 0.0)]
    dropped: f64,

    /// Share of the frames that arrive twice.
    #[arg(long, value_name = "SHARE", value_parser = share, default_value_t = 0.0)]
    repeated: f64,

    /// Share of the frames that are followed by idle bytes or noise.
    #[arg(long, value_name = "SHARE", value_parser = share, default_value_t = 0.0)]
    noise_after: f64,

    /// Seed of the faults.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Runs `selfcal record`.
pub(crate) fn record(args: &RecordArgs) -> Result<()> {
    let set = Dataset::find(&args.set)?;
    ensure!(!args.file.exists(), "{} exists: nothing is overwritten", args.file.display());
    let sender = Sender::of(&set)?;
    let RecordArgs { damaged, dropped, repeated, noise_after, .. } = *args;
    let mut wire = FaultyWire::new(Faults { damaged, dropped, repeated, noise_after }, args.seed);
    let (mut bytes, mut left_out) = (Vec::new(), 0);
    let [mut intact, mut damaged, mut dropped, mut repeated] = [0; 4];
    for (sequence, pair) in (0..).zip(&set.pairs) {
        let (frame, without) = sender.frame(sequence, pair);
        left_out += without;
        *match wire.send(&frame, &mut bytes) {
            Sent::Intact => &mut intact,
            Sent::Damaged => &mut damaged,
            Sent::Dropped => &mut dropped,
            Sent::Repeated => &mut repeated,
        } += 1;
    }
    fs::write(&args.file, &bytes)
        .with_context(|| format!("cannot write {}", args.file.display()))?;
    let mut out = io::stdout();
    let (frames, length) = (set.pairs.len(), bytes.len());
    writeln!(out, "{}: {frames} frames of {}, {length} bytes", args.file.display(), set.name)?;
    writeln!(out, "{intact} as sent, {damaged} damaged, {dropped} dropped, {repeated} repeated")?;
    if left_out > 0 {
        writeln!(out, "{left_out} matches left out: they do not fit a frame")?;
    }
    Ok(())
}
