//! The page of a run over images: pictures before and after, the verdict, then the pages of any run.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use host_tests::chart::palette::{self, viridis};
use host_tests::data::{Match, Meta};
use host_tests::evidence::pictures::{
    Disparities, Grey, Rectification, Scores, disparity_picture, pair_picture, rectified,
};
use host_tests::evidence::report::{Cell, Csv, Figure, Page, Picture as Drawing, Section, Table};
use host_tests::evidence::run_page::Replayed;
use host_tests::run::SCREEN_PX;
use image::codecs::jpeg::JpegEncoder;
use image::{Rgb, RgbImage};
use nalgebra::Vector3;
use stereo_selfcal::{
    Cameras, Extrinsics, RayPair, RectifiedCamera, RectifyingRotations, row_offset,
};

use crate::matcher::halved;
use crate::picture::Picture;
use crate::session::{BestPair, Session};
use crate::verdict::{Report, Verdict};

/// Pictures are at most this wide, px.
const WIDE: u16 = 720;

/// Largest disparity searched, px of the picture.
const RANGE: f64 = 128.0;

/// Radius of a match's dot, px.
const DOT: i64 = 3;

/// Row offset of the brightest colour, px of the image.
const BRIGHTEST_PX: f64 = 3.0;

/// Where the colours of row offsets begin: the darkest ones are lost on a dim image.
const DARKEST: f64 = 0.3;

const QUALITY: u8 = 85;

/// A pair at the size of pictures.
struct Shown {
    pictures: [Grey; 2],
    cameras: Cameras<f64>,
    matches: Vec<Match>,
    /// Px of the image to a pixel of the picture.
    scale: f64,
}

/// Writes the page of a run into a folder.
///
/// # Errors
/// If a file cannot be written.
pub fn write(session: &Session, report: &Report, command: &str, dir: &Path) -> Result<PathBuf> {
    let replayed = Replayed { set: &session.set, log: &session.log, command };
    let page = replayed.page()?;
    let mut sections = vec![verdict(report, command)];
    sections.extend(pictures(session, command)?);
    sections.extend(page.sections);
    let page = Page { lead: format!("{report}."), sections, ..page };
    replayed.write_page(&page, dir)
}

fn verdict(report: &Report, command: &str) -> Section {
    let mut section = Section::new("Verdict");
    match report.verdict {
        Verdict::Good => section.text("The rig fits its calibration."),
        Verdict::Improvable => {
            section.text("The rig works, and the estimate aligns its rows better.");
        }
        Verdict::Recalibrate => section.alarm("The rig has moved: rows no longer align."),
        Verdict::Unknown => section.alarm("The images do not tell."),
    }
    let mut table = Table::new("verdict", ["quantity", "value"].map(Into::into));
    let mut row = |name: &str, value: Cell| table.push(vec![Cell::text(name), value]);
    row("verdict", Cell::text(report.verdict.to_string()));
    for reason in &report.reasons {
        row("reason", Cell::text(reason));
    }
    for reason in &report.summary.reasons {
        row("arming, or the last pair", Cell::text(reason));
    }
    // As text: a number would move its column to the right.
    row("matches a pair", Cell::text(format!("{:.0}", report.matches_a_pair)));
    if !report.skipped.is_empty() {
        row("skipped", Cell::text(&report.skipped));
    }
    section.table(table.explained(
        "Good: rows within 1 px that the estimate does not improve by a tenth. Improvable: it does. Recalibrate: rows \
         1 px off or more. Row offsets are RMS over the matches that fit the estimate.",
        command,
    ));
    section
}

/// Pictures of the best pair; a sentence where there is nothing to show.
fn pictures(session: &Session, command: &str) -> Result<Option<Section>> {
    let (Some(best), Some(fused)) = (&session.best, session.log.fused()) else { return Ok(None) };
    let BestPair { number, frames, matches } = best;
    let pictures = [frames[0].picture()?, frames[1].picture()?];
    let calibrated = shown(&pictures, &fused.rig(&session.set.meta), matches)?;
    let before = shown(&pictures, &session.set.meta, matches)?;
    let kept = calibrated.in_row(&fused.extrinsics);
    let range = calibrated.range(&fused.extrinsics, &kept);
    let mut section = Section::new("Before and after");
    let mut panels = Panels::new();
    for (rig, extrinsics, shown) in
        [("in use", session.log.factory(), &before), ("estimate", &fused.extrinsics, &calibrated)]
    {
        if !panels.add(rig, extrinsics, shown, &kept, range)? {
            section
                .text(format!("No camera sees what both see after the rectification of: {rig}."));
        }
    }
    let name = format!("pair {number}, {} and {}", frames[0], frames[1]);
    for figure in panels.figures(&name, range, command) {
        section.figure(figure);
    }
    Ok(Some(section))
}

/// A picture and the line under it, for each rig.
type Row = Vec<(Drawing, String)>;

/// The pictures of the rigs, side by side.
struct Panels {
    pairs: Row,
    disparities: Row,
    offsets: Row,
    numbers: Csv,
}

impl Panels {
    fn new() -> Self {
        let columns = ["rig", "row offset, median, px", "disparities found, share"];
        let numbers = Csv::new("before_after", &columns);
        Self { pairs: Row::new(), disparities: Row::new(), offsets: Row::new(), numbers }
    }

    /// The pictures of one rig; `false` if only its matches can be shown, since no rectified camera sees both.
    fn add(
        &mut self,
        rig: &str,
        extrinsics: &Extrinsics<f64>,
        shown: &Shown,
        kept: &[usize],
        range: u16,
    ) -> Result<bool> {
        let median = shown.median(extrinsics, kept);
        let rows = format!("{rig}: median row offset {median:.2} px");
        self.offsets.push((shown.coloured(extrinsics)?, rows.clone()));
        let Some(one) = shown.rectification(extrinsics, kept, range, median) else {
            return Ok(false);
        };
        let found = 100.0 * one.scores.valid;
        self.pairs.push((pair_picture(&one)?, rows));
        self.disparities.push((disparity_picture(&one)?, format!("{rig}: {found:.1} % found")));
        self.numbers.push([rig.to_owned(), median.to_string(), one.scores.valid.to_string()]);
        Ok(true)
    }

    /// One below the other, with what they show of the pair of that name.
    fn figures(self, name: &str, range: u16, command: &str) -> [Figure; 3] {
        let figure = |panels, caption, csv: &str| Figure {
            panels,
            legend: Vec::new(),
            caption,
            command: command.to_owned(),
            numbers: Csv { name: csv.to_owned(), ..self.numbers.clone() },
        };
        let pairs = format!(
            "Left and right image of {name}, rectified, side by side. Blue lines are level; an orange line leads \
             level from a match's end in the left image, and its end in the right image should lie on it."
        );
        let disparities = format!(
            "Dense disparities of {name}, from yellow (near, {range} px) to dark blue (far, 0 px); grey where left and \
             right do not agree within 1 px. Semi-global matching, nothing filled in."
        );
        let offsets = format!(
            "All matches of {name} in the left image as it is, coloured by their row offset: blue 0, yellow \
             {BRIGHTEST_PX} px or more."
        );
        [
            figure(self.pairs, pairs, "before_after"),
            figure(self.disparities, disparities, "disparities"),
            figure(self.offsets, offsets, "offsets"),
        ]
    }
}

/// A pair halved until it is no wider than pictures are.
fn shown(pictures: &[Picture; 2], meta: &Meta, matches: &[Match]) -> Result<Shown> {
    let [left, right] = [halved(&pictures[0])?, halved(&pictures[1])?];
    let narrow = |picture: &Picture| picture.size()[0] <= WIDE;
    let level = left.iter().position(narrow).unwrap_or(left.len() - 1);
    let scale = f64::from(1_u32 << level);
    let grey = |picture: &Picture| {
        Grey::try_new(picture.size(), picture.pixels().iter().copied().map(Some).collect())
    };
    let small = |m: &Match| Match {
        ul: m.ul / scale,
        vl: m.vl / scale,
        ur: m.ur / scale,
        vr: m.vr / scale,
        ..*m
    };
    Ok(Shown {
        pictures: [grey(&left[level])?, grey(&right[level])?],
        cameras: halved_meta(meta, scale).cameras()?,
        matches: matches.iter().map(small).collect(),
        scale,
    })
}

/// The rig of images halved as the pyramid does it: the first pixel stays where it is.
fn halved_meta(meta: &Meta, scale: f64) -> Meta {
    let mut small = meta.clone();
    for k in [&mut small.k_l, &mut small.k_r] {
        k.iter_mut().take(2).flatten().for_each(|x| *x /= scale);
    }
    let length = |n: u16| (f64::from(n) / scale).ceil() as u16;
    (small.width, small.height) = (length(meta.width), length(meta.height));
    small
}

impl Shown {
    /// Row offset of a match, px of the image.
    fn offset(&self, extrinsics: &Extrinsics<f64>, i: usize) -> Option<f64> {
        let rays: RayPair<f64> = self.cameras.rays(&self.matches[i].correspondence()).ok()?;
        let offset = row_offset(&RectifyingRotations::from(extrinsics), &rays)?;
        Some(offset * self.cameras.mean_focal() * self.scale)
    }

    /// The matches that fit their rows.
    fn in_row(&self, extrinsics: &Extrinsics<f64>) -> Vec<usize> {
        let fits = |i: &usize| self.offset(extrinsics, *i).is_some_and(|px| px.abs() <= SCREEN_PX);
        (0..self.matches.len()).filter(fits).collect()
    }

    fn median(&self, extrinsics: &Extrinsics<f64>, kept: &[usize]) -> f64 {
        let offsets = kept.iter().filter_map(|i| self.offset(extrinsics, *i).map(f64::abs));
        let mut offsets: Vec<f64> = offsets.collect();
        offsets.sort_by(f64::total_cmp);
        offsets.get(offsets.len() / 2).copied().unwrap_or(f64::NAN)
    }

    fn ends(&self, extrinsics: &Extrinsics<f64>, kept: &[usize]) -> Option<Vec<[[f64; 2]; 2]>> {
        let rotations = RectifyingRotations::from(extrinsics);
        let target = RectifiedCamera::try_choose(&self.cameras, &rotations, 0.0).ok()?;
        let [cx, cy] = target.principal;
        let pixel =
            |p: Vector3<f64>| [cx + target.focal * p.x / p.z, cy + target.focal * p.y / p.z];
        let end = |i: &usize| {
            let m = &self.matches[*i];
            let left = self.cameras.left.ray([m.ul, m.vl]).ok()?.push(1.0);
            let right = self.cameras.right.ray([m.ur, m.vr]).ok()?.push(1.0);
            Some([pixel(rotations.left() * left), pixel(rotations.right() * right)])
        };
        Some(kept.iter().filter_map(end).collect())
    }

    /// Range of the disparities of nearly all matches, px of the picture, a multiple of 16.
    fn range(&self, extrinsics: &Extrinsics<f64>, kept: &[usize]) -> u16 {
        let ends = self.ends(extrinsics, kept).unwrap_or_default();
        let mut disparities: Vec<f64> = ends.iter().map(|[l, r]| l[0] - r[0]).collect();
        disparities.sort_by(f64::total_cmp);
        let high = disparities.get(disparities.len() * 19 / 20).copied().unwrap_or(RANGE);
        ((high * 1.125).clamp(1.0, RANGE) / 16.0).ceil() as u16 * 16
    }

    fn rectification(
        &self,
        extrinsics: &Extrinsics<f64>,
        kept: &[usize],
        range: u16,
        row_offset_px: f64,
    ) -> Option<Rectification> {
        let rotations = RectifyingRotations::from(extrinsics);
        let target = RectifiedCamera::try_choose(&self.cameras, &rotations, 0.0).ok()?;
        let images = [
            rectified(&self.pictures[0], &self.cameras.left, rotations.left(), &target),
            rectified(&self.pictures[1], &self.cameras.right, rotations.right(), &target),
        ];
        let disparities = Disparities::of(&images[0], &images[1], range);
        let valid = disparities.valid_share(&images[0]);
        let matches = self.ends(extrinsics, kept)?;
        let scores = Scores { valid, right: None, row_offset_px };
        Some(Rectification { images, disparities, range, matches, scores })
    }

    /// The left image with all matches, coloured by their row offsets.
    fn coloured(&self, extrinsics: &Extrinsics<f64>) -> Result<Drawing> {
        let [width, height] = self.pictures[0].size().map(u32::from);
        let mut image = RgbImage::new(width, height);
        let pixels = image.pixels_mut().zip(self.pictures[0].pixels());
        // Dimmed, so that the dots stand out.
        pixels.for_each(|(pixel, grey)| *pixel = Rgb([grey.unwrap_or(0) / 2 + 30; 3]));
        for (i, m) in self.matches.iter().enumerate() {
            let Some(offset) = self.offset(extrinsics, i) else { continue };
            let palette::Rgb(r, g, b) =
                viridis(DARKEST + (1.0 - DARKEST) * (offset.abs() / BRIGHTEST_PX).min(1.0));
            dot(&mut image, [m.ul, m.vl].map(|x| x.round() as i64), Rgb([r, g, b]));
        }
        let mut bytes = Cursor::new(Vec::new());
        JpegEncoder::new_with_quality(&mut bytes, QUALITY)
            .encode_image(&image)
            .context("cannot encode the matches")?;
        Ok(Drawing::Jpeg(bytes.into_inner()))
    }
}

fn dot(image: &mut RgbImage, [x, y]: [i64; 2], color: Rgb<u8>) {
    let inside = |d: i64| -d..=d;
    for (dx, dy) in inside(DOT).flat_map(|dx| inside(DOT).map(move |dy| (dx, dy))) {
        let place = u32::try_from(x + dx).ok().zip(u32::try_from(y + dy).ok());
        if dx * dx + dy * dy > DOT * DOT {
            continue;
        }
        if let Some(pixel) = place.and_then(|(x, y)| image.get_pixel_mut_checked(x, y)) {
            *pixel = color;
        }
    }
}
