//! `evidence matcher`.

use std::io::{self, Write};
use std::time::Instant;

use crate::measure::{Quality, VIEWS, measure};
use anyhow::Result;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use images::matcher::{Matcher, MatcherConfig};
use images::picture::Picture;
use images::shipped::ShippedImages;
use sim::stats::geometric_mean;

/// Measure the matcher against the truth of the shipped images, beside the SIFT matches of the project: unchanged, and
/// with the left image warped as if its camera were turned by 5 degrees up, down, left and right.
///
/// Right: share of the matches within 1.5 px of their true row. Noise: RMS row offset of these matches. e_t, e_theta:
/// errors of the fused estimate, rad; it starts from the nominal rig.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  evidence matcher
  evidence matcher chess
  evidence matcher --time")]
pub struct MatcherArgs {
    /// Images to measure; all by default.
    #[arg(value_parser = shipped())]
    images: Vec<ShippedImages>,

    /// Measure the time of a pair on one thread: Aloe at 0.3, 1.4 and 6 Mpx, the best of five.
    #[arg(long)]
    time: bool,
}

fn shipped() -> impl TypedValueParser<Value = ShippedImages> {
    let names = ShippedImages::ALL.iter().map(ToString::to_string);
    PossibleValuesParser::new(names).try_map(|name| name.parse())
}

/// Sizes of the timed pairs, px.
const SIZES: [[u32; 2]; 3] = [[640, 554], [1282, 1110], [2632, 2280]];

/// Runs `evidence matcher`.
pub(crate) fn matcher(args: &MatcherArgs) -> Result<()> {
    if args.time {
        return time();
    }
    let all =
        if args.images.is_empty() { ShippedImages::ALL.to_vec() } else { args.images.clone() };
    head()?;
    let mut table = Ratios::default();
    for images in all {
        for view in VIEWS {
            let m = measure(images, view, MatcherConfig::default())?;
            let view = view.map_or("none".into(), |view| format!("{view:?}").to_lowercase());
            table.row(&m.name, &view, &m.ours, &m.sift)?;
        }
    }
    table.end()
}

fn head() -> io::Result<()> {
    let group =
        format!("{:>7} {:>6} {:>6} {:>8} {:>8}", "matches", "right", "noise", "e_t", "e_theta");
    let sift = group.replace("matches", "   SIFT");
    let [left, right] = ["e_t", "e_theta"];
    writeln!(io::stdout(), "{:<11}{:<7} {group}  {sift}  {left:>5} {right:>7}", "images", "view")
}

/// Errors of `t` and `R` so far, rad, and their ratios to those of the SIFT matches.
#[derive(Default)]
struct Ratios {
    errors: Vec<[f64; 2]>,
    ratios: Vec<[f64; 2]>,
}

impl Ratios {
    fn row(&mut self, name: &str, view: &str, ours: &Quality, sift: &Quality) -> io::Result<()> {
        let errors = |q: &Quality| [q.error.translation, q.error.rotation];
        self.errors.push(errors(ours));
        let line = format!("{name:<11}{view:<7} {}", quality(ours));
        let ([t, r], [sift_t, sift_r]) = (errors(ours), errors(sift));
        let [t, r] = [t / sift_t, r / sift_r];
        self.ratios.push([t, r]);
        writeln!(io::stdout(), "{line}  {}  {t:>5.2} {r:>7.2}", quality(sift))
    }

    /// Prints the geometric means.
    fn end(&self) -> Result<()> {
        let mean = |all: &[[f64; 2]], i: usize| {
            geometric_mean(all.iter().map(|one| one[i])).unwrap_or(f64::NAN)
        };
        let [t, r] = [0, 1].map(|i| mean(&self.errors, i));
        write!(io::stdout(), "{:<41} {t:>8.5} {r:>8.5}", "geometric mean")?;
        let [t, r] = [0, 1].map(|i| mean(&self.ratios, i));
        write!(io::stdout(), "{:<42}{t:>5.2} {r:>7.2}", "")?;
        writeln!(io::stdout())?;
        Ok(())
    }
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
