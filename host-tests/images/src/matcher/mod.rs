//! The matcher: correspondences of a stereo pair in fractions of a pixel.
//!
//! Software model of the matcher in the FPGA: corners with binary descriptors, a search along the rows of the expected
//! rectification within a band, a ratio and a mutual check, and refinement of column and row. It runs twice: on small
//! images, in a band as wide as the prior allows; then on the images themselves, in a narrow band around the rows that
//! the solver finds from the first matches.

mod alike;
mod keypoints;
mod patch;
mod refine;
mod search;
mod smooth;
mod view;

use anyhow::Result;
use rigs::data::{Match, Meta};
use sim::run::report_alone;
use stereo_selfcal::batch::row_offset;
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::{Cameras, Extrinsics, FactoryCalibration};

use crate::picture::Picture;
use alike::Alike;
use keypoints::Keypoints;
use refine::{Halved, Refiner};
use search::{Band, Search, Tentative};
pub use view::{View, halved};

/// Parameters of the matcher.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatcherConfig {
    /// Number of corners sought in each image.
    pub keypoints: usize,
    /// Largest number of refined matches, spread over the image.
    pub most: usize,
    /// Largest turn of the cameras since the calibration, degrees: half of the band of the first search around a row.
    pub prior_deg: f64,
    /// Largest disparity, as a share of the image's width.
    pub range: f64,
    /// Least correlation of the refined windows.
    pub correlation: f64,
    /// Largest predicted standard deviation of column or row, px.
    pub sd_px: f64,
    /// Largest ratio of the best descriptor distance to the second best.
    pub ratio: f64,
}

impl Default for MatcherConfig {
    fn default() -> Self {
        Self {
            keypoints: 3000,
            most: 1500,
            prior_deg: 6.0,
            range: 0.5,
            correlation: 0.9,
            sd_px: 0.2,
            ratio: 0.8,
        }
    }
}

/// Number of levels of the pyramid of the full images.
const FINE_LEVELS: usize = 3;

/// Half of the narrow band, as a share of the image's width, and its least value, px.
const NARROW: (f64, f64) = (0.005, 3.0);

/// Least number and share of matches of the first search that must fit its rows, for the narrow band to be used.
const TRUSTED: (u32, f64) = (25, 0.4);

/// Number of cells along either side of the image that matches are spread over.
const CELLS: usize = 16;

/// Least number of matches with a clear sign of the disparity, and least share of negative ones, for which left and
/// right count as exchanged.
const EXCHANGED: (usize, f64) = (20, 0.8);

/// Refined matches whose left pixels are closer than this count as one, px.
const APART: f64 = 3.0;

/// Matches of one pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Matched {
    /// Refined matches, the most certain first.
    pub matches: Vec<Match>,
    /// Number of corners in the left and in the right image.
    pub corners: [usize; 2],
    /// Number of refined matches of the first search, in the wide band.
    pub first: usize,
    /// Number of matches of the first search with clearly positive and with clearly negative disparity.
    pub signs: [usize; 2],
    /// Whether the rows of the first search were trusted; if not, the matches come from the wide band.
    pub narrowed: bool,
}

impl Matched {
    /// Whether left and right are exchanged: nearly all disparities are negative.
    pub fn is_exchanged(&self) -> bool {
        let [positive, negative] = self.signs;
        let (least, share) = EXCHANGED;
        positive + negative >= least && negative as f64 >= share * (positive + negative) as f64
    }
}

/// A matcher for one rig.
#[derive(Debug, Clone)]
pub struct Matcher {
    cameras: Cameras<f64>,
    extrinsics: Extrinsics<f64>,
    config: MatcherConfig,
    /// Changes that make the pictures of unlike cameras alike, and the matcher for the changed pictures.
    alike: Option<Box<(Alike, Matcher)>>,
}

impl Matcher {
    /// A matcher for these cameras; the first search follows the rows of these extrinsics.
    pub fn new(cameras: Cameras<f64>, extrinsics: &Extrinsics<f64>, config: MatcherConfig) -> Self {
        Self { cameras, extrinsics: *extrinsics, config, alike: None }
    }

    /// A matcher for a rig. If the right camera is rolled against the left one, or the focal lengths differ, the
    /// pictures are first made alike.
    ///
    /// # Errors
    /// If the rig is not valid.
    pub fn of(meta: &Meta, config: MatcherConfig) -> Result<Self> {
        let new = Self::new(meta.cameras()?, &meta.extrinsics()?, config);
        let Some(alike) = Alike::of(meta) else { return Ok(new) };
        let rig = alike.meta(meta);
        let inner = Self::new(rig.cameras()?, &rig.extrinsics()?, config);
        Ok(Self { alike: Some(Box::new((alike, inner))), ..new })
    }

    /// The matches of a pair.
    ///
    /// # Errors
    /// If an image is too small to hold a corner's window.
    pub fn matches(&self, left: &Picture, right: &Picture) -> Result<Matched> {
        if let Some(inner) = &self.alike {
            let (alike, matcher) = inner.as_ref();
            let [left, right] = alike.pictures([left, right])?;
            let mut matched = matcher.matches(&left, &right)?;
            matched.matches.iter_mut().for_each(|m| *m = alike.back(m));
            return Ok(matched);
        }
        let views = [View::new(left)?, View::new(right)?];
        let views = views.each_ref();
        let (coarse, signs) = self.searched_first(views);
        let rows = self.rows(&coarse);
        let (extrinsics, band) = match rows {
            Some(extrinsics) => {
                let [width, _] = self.cameras.left.intrinsics().size;
                let (share, least) = NARROW;
                (extrinsics, Band { rad: 0.0, px: (f64::from(width) * share).max(least) })
            }
            None => (self.extrinsics, self.wide()),
        };
        let corners =
            |view: &View| Keypoints::of(&view.levels[0], self.config.keypoints, FINE_LEVELS, 1.0);
        let corners = [corners(views[0])?, corners(views[1])?];
        let corners = corners.each_ref();
        let found = Search::new(self.cameras, &extrinsics, band, &self.config).tentative(corners);
        let chosen = self.chosen(corners[0], found.matches);
        let matches = self.refined(views, corners, &chosen, 0);
        Ok(Matched {
            matches: spread(matches),
            corners: corners.map(Keypoints::len),
            first: coarse.len(),
            signs,
            narrowed: rows.is_some(),
        })
    }

    /// Both images of a pair, prepared for [`Matcher::first`].
    ///
    /// # Errors
    /// If an image is too small to hold a corner's window.
    pub fn views(&self, left: &Picture, right: &Picture) -> Result<[View; 2]> {
        let Some(inner) = &self.alike else { return Ok([View::new(left)?, View::new(right)?]) };
        let [left, right] = inner.0.pictures([left, right])?;
        inner.1.views(&left, &right)
    }

    /// Refined matches of the first search alone: fewer and less accurate than those of [`Matcher::matches`].
    pub fn first(&self, views: [&View; 2]) -> Vec<Match> {
        let Some(inner) = &self.alike else { return self.searched_first(views).0 };
        let (alike, matcher) = inner.as_ref();
        matcher.first(views).iter().map(|m| alike.back(m)).collect()
    }

    /// Refined matches of the first search, and the signs of the disparities that it found.
    fn searched_first(&self, views: [&View; 2]) -> (Vec<Match>, [usize; 2]) {
        let config = MatcherConfig { ratio: self.config.ratio.min(0.8), ..self.config };
        let corners = views.map(|view| &view.corners);
        let found =
            Search::new(self.cameras, &self.extrinsics, self.wide(), &config).tentative(corners);
        (self.refined(views, corners, &found.matches, views[0].small), found.signs)
    }

    /// Band of the first search.
    fn wide(&self) -> Band {
        Band { rad: self.config.prior_deg.to_radians(), px: 2.0 }
    }

    /// Number of matches within `px` of their rows under these extrinsics.
    pub fn in_row(&self, matches: &[Match], extrinsics: &Extrinsics<f64>, px: f64) -> usize {
        let rotations = RectifyingRotations::from(extrinsics);
        let offset =
            |m: &Match| row_offset(&rotations, &self.cameras.rays(&m.correspondence()).ok()?);
        let limit = px / self.cameras.mean_focal();
        matches.iter().filter(|m| offset(m).is_some_and(|e: f64| e.abs() <= limit)).count()
    }

    /// At most `config.most` matches, spread over the cells of the image: the most distinct of each cell come first.
    fn chosen(&self, left: &Keypoints, mut all: Vec<Tentative>) -> Vec<Tentative> {
        if all.len() <= self.config.most {
            return all;
        }
        all.sort_by(|a, b| b.margin.total_cmp(&a.margin));
        let size = self.cameras.left.intrinsics().size.map(f64::from);
        let mut counts = [[0_usize; CELLS]; CELLS];
        let mut ranked: Vec<(usize, Tentative)> = Vec::with_capacity(all.len());
        for one in all {
            let [column, row] = std::array::from_fn(|i| {
                let cell = left.places[one.left][i] / size[i] * CELLS as f64;
                (cell as usize).min(CELLS - 1)
            });
            ranked.push((counts[row][column], one));
            counts[row][column] += 1;
        }
        ranked.sort_by_key(|(rank, _)| *rank);
        ranked.truncate(self.config.most);
        ranked.into_iter().map(|(_, one)| one).collect()
    }

    /// Extrinsics estimated from the matches of one pair; `None` unless enough of them fit.
    pub fn rows(&self, matches: &[Match]) -> Option<Extrinsics<f64>> {
        let factory = FactoryCalibration::new(self.cameras, self.extrinsics);
        let report = report_alone(&factory, matches)?;
        let (fit, share) = TRUSTED;
        let trusted = report.screened >= fit
            && f64::from(report.screened) >= share * f64::from(report.usable);
        trusted.then_some(report.extrinsics)
    }

    fn refined(
        &self,
        views: [&View; 2],
        corners: [&Keypoints; 2],
        tentative: &[Tentative],
        finest: usize,
    ) -> Vec<Match> {
        let refiner = Refiner::new();
        let smooth = views.map(|view| &view.smooth);
        let refined = |one| self.refined_one(&refiner, smooth, corners, one, finest);
        tentative.iter().filter_map(refined).collect()
    }

    fn refined_one(
        &self,
        refiner: &Refiner,
        smooth: [&Halved; 2],
        [l, r]: [&Keypoints; 2],
        tentative: &Tentative,
        finest: usize,
    ) -> Option<Match> {
        let config = &self.config;
        let unit = f64::from(1_u32 << finest);
        // At whole pixels of the finest level the left window needs no interpolation.
        let left = l.places[tentative.left].map(|x| (x / unit).round() * unit);
        let right = r.places[tentative.right];
        let pixel = l.pixel(tentative.left).max(r.pixel(tentative.right));
        let coarsest = (pixel.log2() as usize).clamp(finest, smooth[0].len() - 1);
        let refined = refiner.refine(smooth, left, right, [coarsest, finest])?;
        let moved = (refined.place[0] - right[0]).hypot(refined.place[1] - right[1]);
        let sure = refined.correlation >= config.correlation
            && refined.sd.iter().all(|sd| *sd <= config.sd_px * unit)
            && moved <= 2.0 * (unit + pixel);
        let [ul, vl] = left;
        let [ur, vr] = refined.place;
        let score = tentative.margin.min(1.0) * refined.correlation.clamp(0.0, 1.0);
        sure.then_some(Match { ul, vl, ur, vr, score, step: 0.0 })
    }
}

/// Keeps only the most certain of matches whose left pixels are closer than [`APART`]; the most certain come first.
fn spread(mut all: Vec<Match>) -> Vec<Match> {
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    let cell = |m: &Match| [m.ul, m.vl].map(|x| (x / APART).floor() as i32);
    let mut taken = std::collections::HashMap::<[i32; 2], Vec<[f64; 2]>>::new();
    all.retain(|m| {
        let [column, row] = cell(m);
        let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [column + dx, row + dy]));
        let mut neighbours = near.filter_map(|cell| taken.get(&cell)).flatten();
        if neighbours.any(|[u, v]| (u - m.ul).hypot(v - m.vl) < APART) {
            return false;
        }
        taken.entry([column, row]).or_default().push([m.ul, m.vl]);
        true
    });
    all
}
