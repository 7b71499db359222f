//! `evidence matcher`.

use std::io::{self, Write};
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use images::matcher::{Matcher, MatcherConfig};
use images::picture::Picture;
use images::shipped::ShippedImages;

use crate::campaigns::{Table, means, named};

/// Measure the matcher against the truth of the shipped images, beside the SIFT matches of the project: unchanged, and
/// with the left image warped as if its camera were turned by 5 degrees up, down, left and right.
///
/// It prints the campaign `images`, and the geometric means of its errors. Right: share of the matches within 1.5 px of
/// their true row. Noise: RMS row offset of these matches. e_t, e_R: errors of the fused estimate, rad; it starts from
/// the nominal rig.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  evidence matcher
  evidence matcher --time")]
pub struct MatcherArgs {
    /// Measure the time of a pair on one thread: Aloe at 0.3, 1.4 and 6 Mpx, the best of five.
    #[arg(long)]
    time: bool,
}

/// Sizes of the timed pairs, px.
const SIZES: [[u32; 2]; 3] = [[640, 554], [1282, 1110], [2632, 2280]];

/// Runs `evidence matcher`.
pub(crate) fn matcher(args: &MatcherArgs) -> Result<()> {
    if args.time {
        return time();
    }
    let campaign = named(&["images".to_owned()])?.pop().context("the campaign of the matcher")?;
    let rows = campaign.rows(&campaign.request(false).context("all cases")?)?;
    let [t, r, t_over_sift, r_over_sift] = means(&rows);
    let mut out = io::stdout();
    write!(out, "{}", Table::of(&rows, Some(&campaign.columns())).aligned())?;
    writeln!(
        out,
        "geometric means: e_t {t:.5}, e_R {r:.5}, over SIFT {t_over_sift:.2}, {r_over_sift:.2}"
    )?;
    Ok(())
}

fn time() -> Result<()> {
    let set = ShippedImages::Aloe.sift()?;
    let files = ShippedImages::Aloe.files().remove(0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    for [width, height] in SIZES {
        let pictures = files.each_ref().map(|file| -> Result<Picture> {
            let whole = image::open(file)?;
            let filter = image::imageops::FilterType::CatmullRom;
            Picture::of(whole.resize_exact(width, height, filter))
        });
        let [left, right] = pictures;
        let (left, right) = (left?, right?);
        let scale = f64::from(width) / f64::from(set.meta.width);
        let mut meta = set.meta.clone();
        for k in [&mut meta.k_l, &mut meta.k_r] {
            k.iter_mut().take(2).flatten().for_each(|x| *x *= scale);
        }
        [meta.width, meta.height] = left.size();
        let matcher = Matcher::new(meta.cameras()?, &meta.extrinsics()?, MatcherConfig::default());
        let once = || -> Result<(f64, usize)> {
            let start = Instant::now();
            let matched = matcher.matches(&left, &right)?;
            Ok((start.elapsed().as_secs_f64(), matched.matches.len()))
        };
        let runs = pool.install(|| (0..5).map(|_| once()).collect::<Result<Vec<_>>>())?;
        let best = runs.iter().map(|(seconds, _)| *seconds).fold(f64::INFINITY, f64::min);
        let megapixels = f64::from(width) * f64::from(height) / 1e6;
        writeln!(io::stdout(), "{megapixels:.1} Mpx: {best:.3} s, {} matches", runs[0].1)?;
    }
    Ok(())
}
