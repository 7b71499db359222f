//! Processor in the loop: the pairs of a recording on this computer and on an emulated controller, compared bit for
//! bit.

use std::collections::HashMap;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use firmware_sim::checksums;
use rigs::data::Dataset;

use super::args::PilArgs;
use super::recorded::Recorded;

const PROGRAM: &str = "firmware-pil";

/// Processes a data set on both processors and compares the checksums.
///
/// # Errors
/// If a checksum differs, or QEMU, the image or the data set is missing.
pub(super) fn run(args: &PilArgs, out: &mut impl Write) -> Result<()> {
    let set = args.dataset()?;
    let recorded = Recorded::of(&set)?;
    let here = of_this_computer(&recorded)?;
    heading(out, &set, args)?;
    let image = args.image.clone().map_or_else(|| build(args, &set, &recorded), Ok)?;
    let printed = emulator::output(args.board, &image, &[], args.timeout)?;
    let there = printed.lines().map(|line| u32::from_str_radix(line, 16));
    let there: Vec<u32> = there.collect::<Result<_, _>>().context("not a checksum")?;
    compare(&here, &there, out)
}

/// The checksums of this computer, one for each pair and one at the end.
fn of_this_computer(recorded: &Recorded) -> Result<Vec<u32>> {
    let mut controller = Box::new(firmware_sim::start(recorded.factory.cameras));
    let mut found = Vec::new();
    checksums(&recorded.frames, &mut controller, |checksum| found.push(checksum))?;
    Ok(found)
}

/// Builds the image with the recording in it.
fn build(args: &PilArgs, set: &Dataset, recorded: &Recorded) -> Result<PathBuf> {
    let folder = emulator::root().join("target/firmware-sim/recordings").join(&set.name);
    recorded.write(&folder)?;
    let mut programs: HashMap<_, _> = emulator::build(args.board, |cargo| {
        cargo.args(["--profile", "controller", "-p", "firmware-sim", "--features", "controller"]);
        cargo.args(["--bin", PROGRAM]);
        cargo.env("RECORDING", folder)
    })?;
    programs.remove(PROGRAM).context("cargo has built no image")
}

fn heading(out: &mut impl Write, set: &Dataset, args: &PilArgs) -> Result<()> {
    let matches: usize = set.pairs.iter().map(Vec::len).sum();
    writeln!(out, "Processor in the loop: recorded pairs on an emulated controller and here")?;
    writeln!(out, "data set   {}: {} pairs, {matches} matches", set.name, set.pairs.len())?;
    writeln!(out, "board      {} ({}, {})\n", args.board.name, args.board.machine, args.board.cpu)?;
    Ok(())
}

/// Prints both checksums of each pair.
///
/// # Errors
/// With the first pair that differs.
fn compare(here: &[u32], there: &[u32], out: &mut impl Write) -> Result<()> {
    let pairs = here.len().saturating_sub(1);
    let name = |i| if i < pairs { format!("pair {i}") } else { "the applied calibration".into() };
    writeln!(out, "checksum of the results: here, on the controller")?;
    for (i, (a, b)) in here.iter().zip(there).enumerate() {
        let verdict = if a == b { "same" } else { "DIFFER" };
        writeln!(out, "{a:08x} {b:08x} {verdict:<6} {}", name(i))?;
    }
    if let Some(first) = here.iter().zip(there).position(|(a, b)| a != b) {
        bail!("the controller computes another result first in {}", name(first));
    }
    let [ours, theirs] = [here, there].map(<[u32]>::len);
    ensure!(ours == theirs, "the controller printed {theirs} checksums instead of {ours}");
    writeln!(
        out,
        "\n{pairs} of {pairs} pairs are bit-identical, and so is the calibration at the end"
    )?;
    Ok(())
}
