//! The page of a run over images: the verdict, pictures before and after, then the sections that all runs have.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use image::codecs::jpeg::JpegEncoder;
use image::metadata::Orientation;
use image::{Rgb, RgbImage};
use images::pictures::{Grey, StereoImages, disparity_picture, pair_picture};
use page::chart::palette::{self, viridis};
use page::report::{Cell, Csv, Figure, Page, Picture as Drawing, Section, Table};
use page::run::Replayed;
use rigs::data::{Match, Meta, QuarterTurns};
use stereo_selfcal::{Extrinsics, Reason};

use images::matcher::halved;
use images::picture::Picture;
use images::session::{BestPair, Session};
use images::verdict::Report;
use sim::run::Recommendation;

use crate::commands::called;

/// Largest width of pictures, px.
const WIDE: u16 = 720;

/// Largest disparity searched, px of the picture.
const RANGE: u16 = 128;

/// Radius of a match's dot, px.
const DOT: i64 = 3;

/// Row offset that gets the brightest colour, px of the image.
const BRIGHTEST_PX: f64 = 3.0;

/// Place of a row offset of 0 in the colour map: darker colours do not show on a dimmed image.
const DARKEST: f64 = 0.3;

/// JPEG quality, 1 to 100.
const QUALITY: u8 = 85;

/// Writes the page of a run into a folder.
pub(crate) fn write(session: &Session, report: &Report, dir: &Path) -> Result<PathBuf> {
    let command = &called();
    let replayed = Replayed { set: &session.set, log: &session.log, depth: None, command };
    let page = replayed.page()?;
    let mut sections = vec![verdict(report, command)];
    sections.extend(pictures(session, command)?);
    sections.extend(page.sections);
    let page = Page { sections, ..page };
    replayed.write_page(&page, dir)
}

fn verdict(report: &Report, command: &str) -> Section {
    let mut section = Section::new("Verdict");
    match report.verdict {
        Recommendation::Good => section.text("The rig fits its calibration: keep it."),
        Recommendation::Improvable => {
            section.text(
                "The rig works, and the estimate aligns its rows better: try the files in rig/, and compare them \
                 with `selfcal check --hold-out`.",
            );
        }
        Recommendation::Recalibrate => section.alarm(
            "The rows do not align: the rig has moved, or its calibration was wrong. Use the files in rig/ if they \
             align the rows, and check the mount of the cameras.",
        ),
        Recommendation::Unknown => section.alarm(
            "The images do not tell. The reasons below say why: take more pairs, with texture all over the image \
             and near points.",
        ),
    }
    if report.summary.reasons.contains(&Reason::Yaw.to_string()) {
        section.text(
            "The rows do not confirm the yaw between the cameras. The files in rig/ keep the yaw of the given rig, if \
             one was given. If the yaw is wrong, depth is wrong although the rows align: check one known distance.",
        );
    }
    let mut table = Table::new("verdict", ["quantity", "value"].map(Into::into));
    let mut row = |name: &str, value: Cell| table.push(vec![Cell::text(name), value]);
    row("verdict", Cell::text(report.verdict.to_string()));
    for reason in &report.reasons {
        row("reason", Cell::text(reason));
    }
    if let Some(judged) = &report.summary.verdict {
        let arming = if judged.may_arm {
            "yes".into()
        } else {
            format!("no: {}", judged.reasons.join(", "))
        };
        row("may arm with the given rig", Cell::text(arming));
    }
    // A text, because a number would be aligned to the right of the column.
    row("matches a pair", Cell::text(format!("{:.0}", report.matches_a_pair)));
    if !report.skipped.is_empty() {
        row("skipped", Cell::text(&report.skipped));
    }
    section.table(table.explained(
        "Good: rows within 1 px, and the estimate does not improve them by a tenth. Improvable: it does. \
         Recalibrate: rows 1 px off or more. Row offsets are RMS over the matches that fit the estimate.",
        command,
    ));
    section
}

/// Pictures of the pair with the most matches; `None` without such a pair or without an estimate.
fn pictures(session: &Session, command: &str) -> Result<Option<Section>> {
    let (Some(best), Some(fused)) = (&session.best, session.log.fused()) else { return Ok(None) };
    let BestPair { number, frames, matches } = best;
    // Pictures of cameras that are not side by side are turned by quarters until they are, so that rows are level.
    let turns = QuarterTurns::upright(&fused.rig(&session.set.meta));
    let turned = |side: usize| -> Result<Picture> {
        Ok(frames[side].picture()?.turned(orientation(turns.0[side])))
    };
    let pictures = [turned(0)?, turned(1)?];
    let matches: Vec<Match> =
        matches.iter().map(|m| turns.of_match(&session.set.meta, m)).collect();
    let [calibrated_rig, rig] =
        [fused.rig(&session.set.meta), session.set.meta.clone()].map(|meta| turns.meta(&meta));
    let calibrated = shown(&pictures, &calibrated_rig, &matches)?;
    let before = shown(&pictures, &rig, &matches)?;
    let [estimate, in_use] = [calibrated_rig.extrinsics()?, rig.extrinsics()?];
    let kept = calibrated.in_row(&estimate);
    let range = calibrated.range(&estimate, &kept, RANGE).unwrap_or(RANGE);
    let mut section = Section::new("Before and after");
    let mut panels = Panels::new();
    for (rig, extrinsics, shown) in
        [("before", &in_use, &before), ("after", &estimate, &calibrated)]
    {
        if !panels.add(rig, extrinsics, shown, &kept, range)? {
            section
                .text(format!("No rectified camera sees the view of both cameras after the rectification of: {rig}."));
        }
    }
    let name = format!("pair {number}, {} and {}", frames[0], frames[1]);
    for figure in panels.figures(&name, range, command) {
        section.figure(figure);
    }
    Ok(Some(section))
}

/// Pictures with the lines under them, one for each rig.
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

    /// Adds the pictures of one rig. `false` if only its matches can be shown, because no rectified camera sees the
    /// views of both cameras.
    fn add(
        &mut self,
        rig: &str,
        extrinsics: &Extrinsics<f64>,
        shown: &StereoImages,
        kept: &[usize],
        range: u16,
    ) -> Result<bool> {
        let median = shown.median_px(extrinsics, kept).unwrap_or(f64::NAN);
        let rows = format!("{rig}: median row offset {median:.2} px");
        self.offsets.push((coloured(shown, extrinsics)?, rows.clone()));
        let Ok(one) = shown.rectification(extrinsics, kept, range) else {
            return Ok(false);
        };
        let share = one.found();
        let found = 100.0 * share;
        self.pairs.push((pair_picture(&one)?, rows));
        self.disparities
            .push((disparity_picture(&one)?, format!("{rig}: {found:.1} % of the pixels found")));
        self.numbers.push([rig.to_owned(), median.to_string(), share.to_string()]);
        Ok(true)
    }

    /// The rows of pictures with captions.
    ///
    /// * `name`: name of the pair.
    fn figures(self, name: &str, range: u16, command: &str) -> [Figure; 3] {
        let figure = |panels, caption, csv: &str| Figure {
            panels,
            legend: Vec::new(),
            caption,
            command: command.to_owned(),
            numbers: Csv { name: csv.to_owned(), ..self.numbers.clone() },
        };
        let pairs = format!(
            "Left and right image of {name}, rectified, side by side; before: with the given rig, after: with the \
             estimate. Blue lines are level; an orange line leads level from a match's end in the left image, and \
             a bar from this line to its end in the right image."
        );
        let disparities = format!(
            "Dense disparities of {name}, from yellow (near, {range} px) to dark blue (far, 0 px); grey if \
             left and right do not agree within 1 px. Some pixels agree by chance. Semi-global matching, without \
             filling holes."
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

fn orientation(quarters: u8) -> Orientation {
    match quarters {
        1 => Orientation::Rotate90,
        2 => Orientation::Rotate180,
        3 => Orientation::Rotate270,
        _ => Orientation::NoTransforms,
    }
}

/// A pair with its rig and matches, halved until it fits the width of the pictures.
fn shown(pictures: &[Picture; 2], meta: &Meta, matches: &[Match]) -> Result<StereoImages> {
    let [left, right] = [halved(&pictures[0])?, halved(&pictures[1])?];
    let narrow = |picture: &Picture| picture.size()[0] <= WIDE;
    let level = left.iter().position(narrow).unwrap_or(left.len() - 1);
    let halved = 1_u16 << level;
    let scale = f64::from(halved);
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
    Ok(StereoImages {
        images: [grey(&left[level])?, grey(&right[level])?],
        cameras: halved_meta(meta, halved).cameras()?,
        matches: matches.iter().map(small).collect(),
        scale,
    })
}

/// The rig of images halved as in the pyramid, in which the centre of the first pixel stays at 0.
fn halved_meta(meta: &Meta, scale: u16) -> Meta {
    let mut small = meta.clone();
    for k in [&mut small.k_l, &mut small.k_r] {
        k.iter_mut().take(2).flatten().for_each(|x| *x /= f64::from(scale));
    }
    let [left, right] = meta.sizes().map(|size| size.map(|n| n.div_ceil(scale)));
    [small.width, small.height] = left;
    small.set_right(meta.lenses()[1], right);
    small
}

/// The left image with all matches, coloured by their row offsets.
#[allow(clippy::cast_possible_truncation, reason = "pixels of an image")]
fn coloured(shown: &StereoImages, extrinsics: &Extrinsics<f64>) -> Result<Drawing> {
    let [width, height] = shown.images[0].size().map(u32::from);
    let mut image = RgbImage::new(width, height);
    let pixels = image.pixels_mut().zip(shown.images[0].pixels());
    // Dimmed, so that the dots stand out.
    pixels.for_each(|(pixel, grey)| *pixel = Rgb([grey.unwrap_or(0) / 2 + 30; 3]));
    for m in &shown.matches {
        let Some(offset) = shown.offset_px(extrinsics, m) else { continue };
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
