//! Campaign of the matcher against the truth, on the shipped images, unchanged and with the left image turned.

use anyhow::{Context, Result};
use images::pictures::{Grey, turned};
use rayon::prelude::*;
use rigs::data::{Dataset, Match, TurnedView};
use sim::run::{LensTracking, Start, replay, row_offsets_px};
use sim::stats::{geometric_mean, rms};
use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Config, Extrinsics};

use images::matcher::{Matcher, MatcherConfig};
use images::picture::Picture;
use images::shipped::ShippedImages;

use super::chance::Chance;
use super::figures::{Figure, count};
use super::{Campaign, Measure, Request, Row};

/// Largest row offset of a correct match under the truth, px.
const RIGHT_PX: f64 = 1.5;

/// Angle of the turned left view, degrees.
const DEGREES: f64 = 5.0;

/// Matches against the truth, and the estimate from them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Quality {
    /// Number of matches of a pair, mean.
    matches: f64,
    /// Share within [`RIGHT_PX`] of their true row.
    right: f64,
    /// RMS row offset of these correct matches, px.
    noise_px: f64,
    /// Error of the fused estimate, rad.
    error: Deviation<f64>,
}

/// The measured views, without and with a turn.
const VIEWS: [(Option<TurnedView>, &str); 5] = [
    (None, ""),
    (Some(TurnedView::Top), ", turned up"),
    (Some(TurnedView::Bottom), ", turned down"),
    (Some(TurnedView::Left), ", turned left"),
    (Some(TurnedView::Right), ", turned right"),
];

const COLUMNS: &str = "matches, right, noise px, e_t, e_R, SIFT right, SIFT noise px, e_t over SIFT, \
    e_R over SIFT";

pub(super) fn campaigns() -> Vec<Campaign> {
    let (lens, measure) = (LensTracking::Report, Measure::Rows(rows));
    vec![Campaign {
        name: "images",
        trials: 1,
        seeds: &[0],
        lens,
        columns: COLUMNS,
        quick: None,
        worst_first: None,
        measure,
        chart: None,
    }]
}

fn rows(request: &Request) -> Result<Vec<Row>> {
    let all = ShippedImages::ALL
        .iter()
        .flat_map(|images| VIEWS.map(|(view, words)| (*images, view, format!("{images}{words}"))));
    let chosen = all.filter(|(.., case)| request.takes(case));
    chosen.map(|(images, view, case)| Ok(Row { figures: figures(images, view)?, case })).collect()
}

fn figures(images: ShippedImages, view: Option<TurnedView>) -> Result<Vec<Figure>> {
    let nominal = images.sift()?.truth::<f64>()?;
    let [ours, sift] = matches(images, view)?;
    let [ours, sift] = [quality(&ours, &nominal)?, quality(&sift, &nominal)?];
    let values = [
        ours.matches,
        ours.right,
        ours.noise_px,
        ours.error.translation,
        ours.error.rotation,
        sift.right,
        sift.noise_px,
        ours.error.translation / sift.error.translation,
        ours.error.rotation / sift.error.rotation,
    ];
    let figure = |(name, value): (&'static str, f64)| Figure { name, value, chance: Chance::Exact };
    Ok(COLUMNS.split(", ").zip(values).map(figure).collect())
}

/// Geometric means over the rows: `e_t`, `e_R`, and both over those of SIFT.
pub(crate) fn means(rows: &[Row]) -> [f64; 4] {
    ["e_t", "e_R", "e_t over SIFT", "e_R over SIFT"].map(|name| {
        let all = rows.iter().flat_map(|row| &row.figures).filter(|figure| figure.name == name);
        geometric_mean(all.map(|figure| figure.value)).unwrap_or(f64::NAN)
    })
}

/// The matches in one view: of this matcher, and of SIFT.
///
/// # Errors
/// If the shipped files are damaged.
fn matches(images: ShippedImages, view: Option<TurnedView>) -> Result<[Dataset; 2]> {
    let sift = images.sift()?;
    let nominal = sift.truth::<f64>()?;
    let sift = view.map_or_else(|| Ok(sift.clone()), |view| view.turn(&sift, DEGREES))?;
    let cameras = sift.cameras::<f64>()?;
    let matcher = Matcher::new(cameras, &nominal, MatcherConfig::default());
    let pair = |[left, right]: &[std::path::PathBuf; 2]| -> Result<Vec<Match>> {
        let right = Picture::read(right)?;
        let Some(view) = view else {
            return Ok(matcher.matches(&Picture::read(left)?, &right)?.matches);
        };
        let left = turned(&Grey::read(left)?, &cameras.left, &view.rotation(DEGREES));
        let (left, unseen) = filled(&left)?;
        let mut matches = matcher.matches(&left, &right)?.matches;
        matches.retain(|m| !unseen.near([m.ul, m.vl]));
        Ok(matches)
    };
    let pairs = images.files().par_iter().map(pair).collect::<Result<_>>()?;
    Ok([Dataset { pairs, ..sift.clone() }, sift])
}

fn quality(set: &Dataset, start: &Extrinsics<f64>) -> Result<Quality> {
    let truth = set.truth::<f64>()?;
    let calibration = set.meta.calibration(&truth, &LensCorrection::NONE)?;
    let offsets: Vec<f64> =
        row_offsets_px(set, &calibration).into_iter().flatten().flatten().collect();
    let right: Vec<f64> = offsets.iter().copied().filter(|px| px.abs() <= RIGHT_PX).collect();
    let matches: usize = set.pairs.iter().map(Vec::len).sum();
    let start = Extrinsics::<f32>::try_new(
        &start.rotation().matrix().cast(),
        &start.translation().into_inner().cast(),
    )?;
    let log = replay(set, Config::robust(), Start::Calibration(start), |_| ())?;
    let fused = log.fused().context("no pair could be fused")?;
    Ok(Quality {
        matches: count(matches) / count(set.pairs.len()),
        right: count(right.len()) / count(matches),
        noise_px: rms(right.iter().copied()).unwrap_or(f64::NAN),
        error: Deviation::between(&fused.extrinsics, &truth),
    })
}

/// Pixels that a turned view does not show.
struct Unseen {
    picture: Grey,
}

/// Half of the side of the window around a match that must be visible, px.
const WINDOW: i32 = 12;

impl Unseen {
    /// Whether the view does not show some pixel of the window around this one. Every fourth column and row is tested.
    #[expect(clippy::cast_possible_truncation, reason = "a pixel of an image")]
    fn near(&self, [u, v]: [f64; 2]) -> bool {
        let mut window = (-WINDOW..=WINDOW).step_by(4).flat_map(|dv| {
            (-WINDOW..=WINDOW).step_by(4).map(move |du| [u as i32 + du, v as i32 + dv])
        });
        window.any(|[u, v]| {
            let place = usize::try_from(u).ok().zip(usize::try_from(v).ok());
            place.and_then(|(u, v)| self.picture.at(u, v)).is_none()
        })
    }
}

/// A turned view with black instead of the pixels that it does not show, and these pixels.
fn filled(picture: &Grey) -> Result<(Picture, Unseen)> {
    let pixels = picture.pixels().iter().map(|pixel| pixel.unwrap_or(0)).collect();
    let filled = Picture::try_new(picture.size().map(usize::from), pixels)?;
    Ok((filled, Unseen { picture: picture.clone() }))
}
