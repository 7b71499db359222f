//! `evidence link`.

use std::io::{self, Write};

use anyhow::{Result, ensure};
use clap::Args;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use sim::run::progress;
use sim::wire::{Faults, Soak, SoakCounts};

/// Largest number of frames that are sent to one decoder.
const SHARE: u32 = 20_000;

/// Faults of a bad wire.
const FAULTS: Faults = Faults { damaged: 0.2, dropped: 0.02, repeated: 0.02, noise_after: 0.05 };

/// Send generated frames over a wire with faults, through the decoder, and check its output.
///
/// Frames of 0 to 512 matches with any content, in pieces of any length. 20 % of them are damaged, 2 %
/// dropped, 2 % repeated, and noise follows 5 %. The run fails if the output differs from the input, or if a frame is
/// lost that was whole on the wire and did not take the place of lost bytes of a damaged frame.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  evidence link
  evidence link --frames 100000 --seed 7

Exit status: 0 if all checks passed, 1 if not.")]
pub struct LinkArgs {
    /// Frames to send.
    #[arg(long, default_value_t = 10_000_000, value_name = "N",
          value_parser = clap::value_parser!(u64).range(1..))]
    frames: u64,

    /// Seed of frames and faults.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Runs `evidence link`.
pub(crate) fn link(args: &LinkArgs) -> Result<()> {
    let bar = progress::over(usize::try_from(args.frames)?, "frames");
    let shares = args.frames.div_ceil(SHARE.into());
    let run = |share: u64| {
        let left = args.frames - share * u64::from(SHARE);
        let frames = u32::try_from(left).unwrap_or(SHARE).min(SHARE);
        let seed = args.seed.wrapping_mul(1 << 32).wrapping_add(share);
        Soak { frames, faults: FAULTS, seed }.run(|sent| bar.inc(sent))
    };
    let counts = (0..shares).into_par_iter().map(run).reduce(SoakCounts::default, SoakCounts::plus);
    bar.finish_and_clear();
    print(&counts)?;
    ensure!(counts.is_good(), "a check of the link failed");
    Ok(())
}

fn print(counts: &SoakCounts) -> Result<()> {
    let mut out = io::stdout();
    // The checksum of a damaged frame fits by chance with a probability of 2^-32.
    #[expect(clippy::cast_precision_loss, reason = "a share of a chance")]
    let by_chance = counts.damaged as f64 / 2.0_f64.powi(32);
    for (what, count) in [
        ("frames sent", counts.frames),
        ("  damaged", counts.damaged),
        ("  dropped", counts.dropped),
        ("  repeated", counts.repeated),
        ("bytes received", counts.bytes),
        ("correspondences handed out", counts.correspondences),
        ("frames received whole and handed out", counts.decoded),
        ("handed out, not as sent", counts.wrong),
        ("handed out twice", counts.twice),
        ("whole, in the place of lost bytes of another", counts.taken),
        ("whole and lost for no reason", counts.missed),
        ("without its end, which the next frame supplied, handed out", counts.mended),
    ] {
        writeln!(out, "{what:<45} {count:>12}")?;
    }
    writeln!(out, "{:<45} {by_chance:>12.4}", "damaged frames that pass a CRC-32 by chance")?;
    Ok(())
}
