//! `selfcal matcher`.

use std::io::{self, Write};
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use selfcal_images::matcher::{Matcher, MatcherConfig};
use selfcal_images::measure::{Quality, VIEWS, measure};
use selfcal_images::picture::Picture;
use selfcal_images::shipped::ShippedImages;

/// Measure the matcher against the truth of the shipped images, beside the SIFT matches of the project: as they
/// are, and with the left image warped as if its camera was turned by 5 degrees up, down, left and right.
///
/// Right: within 1.5 px of the true row. Noise: RMS of those. e_t, e_theta: fused, rad, from the nominal rig.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal matcher
  selfcal matcher chess
  selfcal matcher --time")]
pub(crate) struct MatcherArgs {
    /// Which images; all of them if none is given.
    #[arg(value_enum)]
    images: Vec<ShippedImages>,

    /// Measure the time a pair takes on one thread: Aloe at 0.3, 1.4 and 6 Mpx, the best of five.
    #[arg(long)]
    time: bool,
}

/// Sizes of the pairs that are timed, px.
const SIZES: [[u32; 2]; 3] = [[640, 554], [1282, 1110], [2632, 2280]];

/// Runs `selfcal matcher`.
pub(crate) fn matcher(args: &MatcherArgs) -> Result<()> {
    if args.time {
        return time();
    }
    let all =
        if args.images.is_empty() { ShippedImages::ALL.to_vec() } else { args.images.clone() };
    let mut out = io::stdout();
    writeln!(
        out,
        "{:<11}{:<7} {:>7} {:>6} {:>6} {:>8} {:>8}  {:>7} {:>6} {:>6} {:>8} {:>8}  {:>5} {:>7}",
        "images",
        "view",
        "matches",
        "right",
        "noise",
        "e_t",
        "e_theta",
        "SIFT",
        "right",
        "noise",
        "e_t",
        "e_theta",
        "e_t",
        "e_theta"
    )?;
    let mut ratios = Vec::new();
    for images in all {
        for view in VIEWS {
            let m = measure(images, view, MatcherConfig::default())?;
            let view = view.map_or("none".into(), |view| format!("{view:?}").to_lowercase());
            let error = [m.ours.error, m.sift.error];
            let ratio = [
                error[0].translation / error[1].translation,
                error[0].rotation / error[1].rotation,
            ];
            ratios.push(ratio);
            let [ours, sift] = [quality(&m.ours), quality(&m.sift)];
            let [t, r] = ratio;
            writeln!(out, "{:<11}{view:<7} {ours}  {sift}  {t:>5.2} {r:>7.2}", m.name)?;
        }
    }
    let mean = |i: usize| {
        let sum: f64 = ratios.iter().map(|ratio| ratio[i].ln()).sum();
        (sum / ratios.len() as f64).exp()
    };
    writeln!(out, "{:<101}{:>5.2} {:>7.2}", "geometric mean", mean(0), mean(1))?;
    Ok(())
}

fn quality(q: &Quality) -> String {
    let Quality { matches, right, noise_px, error } = q;
    let right = 100.0 * right;
    let [t, r] = [error.translation, error.rotation];
    format!("{matches:>7.0} {right:>5.1}% {noise_px:>6.3} {t:>8.5} {r:>8.5}")
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
