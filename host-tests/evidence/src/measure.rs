//! Measures the matcher against the truth, on the shipped images, unchanged and with the left image turned.

use anyhow::{Context, Result};
use images::pictures::{Grey, turned};
use rayon::prelude::*;
use rigs::data::{Dataset, Match, TurnedView};
use sim::run::{replay, row_offsets_px};
use sim::stats::rms;
use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Config, Extrinsics};

use images::matcher::{Matcher, MatcherConfig};
use images::picture::Picture;
use images::shipped::ShippedImages;

/// Largest row offset of a correct match under the truth, px.
pub(crate) const RIGHT_PX: f64 = 1.5;

/// Angle of the turned left view, degrees.
pub(crate) const DEGREES: f64 = 5.0;

/// Matches against the truth, and the estimate from them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quality {
    /// Number of matches of a pair, mean.
    pub matches: f64,
    /// Share within [`RIGHT_PX`] of their true row.
    pub right: f64,
    /// RMS row offset of these correct matches, px.
    pub noise_px: f64,
    /// Error of the fused estimate, rad.
    pub error: Deviation<f64>,
}

/// Quality of this matcher and of the project's SIFT matches in one view of one set.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    /// Name of the images.
    pub name: String,
    /// Quality of this matcher.
    pub ours: Quality,
    /// Quality of the recorded SIFT matches, with their left points turned.
    pub sift: Quality,
}

/// The measured views.
pub(crate) const VIEWS: [Option<TurnedView>; 5] = [
    None,
    Some(TurnedView::Top),
    Some(TurnedView::Bottom),
    Some(TurnedView::Left),
    Some(TurnedView::Right),
];

/// Measures one view.
///
/// # Errors
/// If the shipped files are damaged, or no pair can be fused.
pub(crate) fn measure(
    images: ShippedImages,
    view: Option<TurnedView>,
    config: MatcherConfig,
) -> Result<Measured> {
    let nominal = images.sift()?.truth::<f64>()?;
    let [ours, sift] = matches(images, view, config)?;
    Ok(Measured {
        name: images.to_string(),
        ours: quality(&ours, &nominal)?,
        sift: quality(&sift, &nominal)?,
    })
}

/// The matches in one view: of this matcher, and of SIFT.
///
/// # Errors
/// If the shipped files are damaged.
pub(crate) fn matches(
    images: ShippedImages,
    view: Option<TurnedView>,
    config: MatcherConfig,
) -> Result<[Dataset; 2]> {
    let sift = images.sift()?;
    let nominal = sift.truth::<f64>()?;
    let sift = view.map_or_else(|| Ok(sift.clone()), |view| view.turn(&sift, DEGREES))?;
    let cameras = sift.cameras::<f64>()?;
    let matcher = Matcher::new(cameras, &nominal, config);
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
    let log = replay(set, Config::robust(), start, |_| ())?;
    let fused = log.fused().context("no pair could be fused")?;
    Ok(Quality {
        matches: matches as f64 / set.pairs.len() as f64,
        right: right.len() as f64 / matches as f64,
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
