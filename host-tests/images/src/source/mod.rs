//! Sources of image pairs: folders, data sets, bags.
//!
//! A new kind of bag: a module in `bag` with a function `messages`, and a case of `Kind` in `bag::recording`. A new
//! layout of folders: a row in `layout`.

mod bag;
mod fields;
mod folders;
mod layout;
mod message;
mod names;
mod partners;

use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use image::metadata::Orientation;
use rigs::data::Meta;

use crate::picture::Picture;
use crate::shipped::ShippedImages;

use bag::{Bag, Recording};
use partners::PairedFiles;

pub use bag::{Infos, Wanted};
pub use message::ImageMessage;

/// An image that is not decoded yet.
#[derive(Debug, Clone)]
pub struct Frame {
    from: From,
    /// The left (0) or the right (1) half, of a picture of both cameras.
    half: Option<usize>,
    /// Whether the image is turned by its EXIF orientation.
    upright: bool,
}

#[derive(Debug, Clone)]
enum From {
    File(PathBuf),
    Message(ImageMessage),
}

impl Frame {
    /// An image file as stored.
    pub fn file(path: PathBuf) -> Self {
        Self { from: From::File(path), half: None, upright: false }
    }

    /// A message of a bag.
    pub fn message(message: ImageMessage) -> Self {
        Self { from: From::Message(message), half: None, upright: false }
    }

    /// The left (0) or the right (1) half of the image.
    pub fn half(self, side: usize) -> Self {
        Self { half: Some(side), ..self }
    }

    /// Path of the image; `None` for a message.
    pub fn path(&self) -> Option<&Path> {
        match &self.from {
            From::File(path) => Some(path),
            From::Message(_) => None,
        }
    }

    /// Reads and decodes the image.
    ///
    /// # Errors
    /// Names the file or the message.
    pub fn picture(&self) -> Result<Picture> {
        Ok(self.picture_and_turn()?.0)
    }

    /// Reads and decodes the image, and returns its EXIF orientation, whether it was applied or not.
    pub fn picture_and_turn(&self) -> Result<(Picture, Orientation)> {
        let (picture, orientation) = match &self.from {
            From::File(path) => Picture::read_with_orientation(path)?,
            From::Message(message) => (message.picture()?, Orientation::NoTransforms),
        };
        let picture = if self.upright { picture.turned(orientation) } else { picture };
        let picture = self.half.map_or_else(|| Ok(picture.clone()), |side| picture.half(side));
        Ok((picture.with_context(|| self.to_string())?, orientation))
    }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(side) = self.half {
            write!(f, "{} half of ", ["left", "right"][side])?;
        }
        match &self.from {
            From::File(path) => {
                write!(f, "{}", Path::new(path.file_name().unwrap_or_default()).display())
            }
            From::Message(message) => write!(f, "{} at {:.3} s", message.topic, message.stamp),
        }
    }
}

/// Items of a source, in order.
#[derive(Debug, Clone)]
pub enum Item {
    /// A pair, left first.
    Pair([Frame; 2]),
    /// Why an image has no partner, with its name.
    Skipped(String),
    /// Part of a bag that is damaged, and why.
    Damaged(String),
}

/// Receiver of the items; `Break` ends the reading.
pub type Take<'a> = &'a mut dyn FnMut(Item) -> ControlFlow<()>;

/// A source of pairs.
#[derive(Debug)]
pub struct Source {
    /// Name for people.
    pub name: String,
    /// The rig of the source.
    pub rig: RigOf,
    /// Numbers of the two cameras in a calibration of several, if the names of the folders tell.
    pub cameras: Option<[u8; 2]>,
    /// Number of pairs, if known before they are read.
    pub count: Option<usize>,
    /// Whether left files, and right files, are turned by their EXIF orientation.
    pub upright: [bool; 2],
    /// Largest difference of the time stamps of a pair, s.
    tolerance_s: f64,
    kind: Kind,
}

/// The rig of a source.
#[derive(Debug)]
pub enum RigOf {
    /// No rig.
    Nothing,
    /// Files of a calibration.
    Files(Vec<PathBuf>),
    /// A rig already read.
    Read(Box<Meta>),
    /// The `camera_info` of a bag.
    Infos(Box<Infos>),
}

#[derive(Debug)]
enum Kind {
    Files { found: PairedFiles, side_by_side: bool },
    Bag(Bag),
}

/// Ratio of width to height from which on a picture counts as two side by side: above cinema formats, and below two
/// pictures of 5 : 4.
const WIDE: f64 = 2.45;

/// Largest difference of time stamps, s, for which the error text suggests a larger tolerance.
const FAR_S: f64 = 0.5;

impl Source {
    /// Opens a source: one place, or a left and a right place.
    ///
    /// * `tolerance_s`: largest difference of the time stamps of a pair.
    ///
    /// # Errors
    /// If the tolerance is negative or not finite, there are not one or two places, two places are wanted side by side,
    /// a place cannot be read or has no images, or its layout or format is unknown or not supported.
    pub fn open(places: &[PathBuf], wanted: &Wanted, tolerance_s: f64) -> Result<Self> {
        ensure!(tolerance_s >= 0.0 && tolerance_s.is_finite(), "the tolerance must be 0 s or more");
        match places {
            [one] => Self::one(one, wanted, tolerance_s),
            [left, right] => {
                ensure!(
                    !wanted.side_by_side,
                    "--side-by-side is for one place with pictures of both cameras, not for two"
                );
                let sides = [folders::images(left)?, folders::images(right)?];
                let cameras = layout::cameras([&sides[0], &sides[1]]);
                let new =
                    Self::of_files(left.display().to_string(), RigOf::Nothing, sides, tolerance_s);
                Ok(Self { cameras, ..new })
            }
            _ => bail!("one source, or a left and a right one, not {}", places.len()),
        }
    }

    fn new(name: String, rig: RigOf, kind: Kind, tolerance_s: f64) -> Self {
        let count = match &kind {
            Kind::Files { found, .. } => Some(found.pairs.len()),
            Kind::Bag(_) => None,
        };
        Self { name, rig, cameras: None, count, upright: [false; 2], tolerance_s, kind }
    }

    fn one(place: &Path, wanted: &Wanted, tolerance_s: f64) -> Result<Self> {
        if let Some(images) = ShippedImages::named(place) {
            let found = PairedFiles { pairs: images.files(), ..PairedFiles::default() };
            let rig = RigOf::Read(Box::new(images.sift()?.meta));
            let kind = Kind::Files { found, side_by_side: false };
            return Ok(Self::new(images.to_string(), rig, kind, tolerance_s));
        }
        let is_pattern = place.to_str().is_some_and(|text| text.contains('*'));
        ensure!(
            place.exists() || is_pattern,
            "{} does not exist, and is not one of the shipped images ({})",
            place.display(),
            ShippedImages::ALL.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
        );
        let name = place.display().to_string();
        let bag = |recording| -> Result<Self> {
            let (bag, infos) = Bag::open(recording, wanted)?;
            let rig = RigOf::Infos(Box::new(infos));
            Ok(Self::new(name.clone(), rig, Kind::Bag(bag), tolerance_s))
        };
        if let Some(recording) = Recording::at(place)? {
            return bag(recording);
        }
        let images = Self::of_images(place, wanted, tolerance_s);
        if images.is_err()
            && place.is_dir()
            && let Some(recording) = Recording::in_folder(place)?
        {
            return bag(recording);
        }
        ensure!(
            images.is_err() || wanted.window == [None; 2],
            "--start and --end are for bags: of images in a folder, give those to be read"
        );
        images
    }

    /// A source of image files.
    fn of_images(place: &Path, wanted: &Wanted, tolerance_s: f64) -> Result<Self> {
        let is_pattern = place.to_str().is_some_and(|text| text.contains('*'));
        let name = place.display().to_string();
        match place.extension().and_then(|e| e.to_str()).unwrap_or_default() {
            "svo" | "svo2" => bail!(
                "{name}: a recording of ZED: export its left and right images (ZED_SVO_Editor, or the SDK's svo_export), and give the folders"
            ),
            "mp4" | "avi" | "mkv" | "mov" | "webm" => bail!(
                "{name}: a video: extract its images, `ffmpeg -i FILE left/%06d.png`, and give the folders of both cameras"
            ),
            _ if place.is_dir() && !wanted.side_by_side => match layout::Layout::of(place) {
                Ok(layout) => {
                    let new =
                        Self::of_files(name, RigOf::Files(layout.rig), layout.sides, tolerance_s);
                    Ok(Self { cameras: layout.cameras, ..new })
                }
                Err(why) => match folders::images(place) {
                    Ok(images) if is_wide(&images) => {
                        Ok(Self::side_by_side(name, images, tolerance_s))
                    }
                    _ => Err(why),
                },
            },
            _ if wanted.side_by_side
                || is_pattern
                || place.is_dir()
                || folders::is_image(place) =>
            {
                let images = folders::images(place)?;
                ensure!(
                    wanted.side_by_side || is_wide(&images),
                    "{name}: images of one side, or are they pictures of both cameras (--side-by-side)? If there are two folders or \
                     patterns, give both"
                );
                Ok(Self::side_by_side(name, images, tolerance_s))
            }
            _ => bail!(
                "{name}: a folder, or a bag (*.mcap, *.db3, *.bag, or its folder) is expected; if there are two folders or \
                 patterns, give both"
            ),
        }
    }

    fn of_files(name: String, rig: RigOf, sides: [Vec<PathBuf>; 2], tolerance_s: f64) -> Self {
        let found = partners::of_files(sides, tolerance_s);
        Self::new(name, rig, Kind::Files { found, side_by_side: false }, tolerance_s)
    }

    /// A source of pictures that show both cameras side by side.
    fn side_by_side(name: String, images: Vec<PathBuf>, tolerance_s: f64) -> Self {
        let pairs = images.into_iter().map(|path| [path.clone(), path]).collect();
        let found = PairedFiles { pairs, ..PairedFiles::default() };
        Self::new(name, RigOf::Nothing, Kind::Files { found, side_by_side: true }, tolerance_s)
    }

    /// The chosen topics, or that pictures are halved, in words; `None` for plain left and right files.
    pub fn choice(&self) -> Option<String> {
        match &self.kind {
            Kind::Bag(bag) => Some(bag.choice()),
            Kind::Files { side_by_side: true, .. } => {
                Some("pictures of both cameras: left and right halves".into())
            }
            Kind::Files { .. } => None,
        }
    }

    /// Why the source has no pairs, in words, with the difference of the nearest time stamps.
    pub fn without_pairs(&self) -> String {
        if matches!(&self.kind, Kind::Bag(bag) if bag.has_window()) {
            return format!(
                "no pairs of images in {} between --start and --end, which count from its first image",
                self.name
            );
        }
        let nearest = match &self.kind {
            Kind::Files { found, .. } => found.nearest_s.filter(|s| *s < FAR_S),
            Kind::Bag(_) => self.nearest_stamps(),
        };
        let Some(seconds) = nearest else {
            return format!(
                "no pairs of images in {}: no left and right image has the same time or number",
                self.name
            );
        };
        let [gap, most] = [seconds, self.tolerance_s].map(|s| s * 1000.0);
        format!(
            "no pairs of images in {}: the nearest left and right images are {gap:.1} ms apart, and --tolerance is {most:.1} ms. If they \
             show one moment, give --tolerance {:.3}",
            self.name,
            seconds * 1.25
        )
    }

    /// Least difference of the time stamps of a left and a right image of a bag, s; `None` above [`FAR_S`].
    fn nearest_stamps(&self) -> Option<f64> {
        let mut nearest: Option<f64> = None;
        let mut take = |item: Item| {
            if let Item::Pair(
                [Frame { from: From::Message(l), .. }, Frame { from: From::Message(r), .. }],
            ) = item
            {
                let gap = (l.stamp - r.stamp).abs();
                nearest = Some(nearest.map_or(gap, |nearest| nearest.min(gap)));
            }
            ControlFlow::Continue(())
        };
        self.read_within(FAR_S, &mut take).ok()?;
        nearest
    }

    /// Hands out all items, one at a time.
    ///
    /// # Errors
    /// If a bag cannot be opened. A damaged part of a bag is reported as a skipped item.
    pub fn read(&self, take: Take<'_>) -> Result<()> {
        self.read_within(self.tolerance_s, take)
    }

    fn read_within(&self, tolerance_s: f64, take: Take<'_>) -> Result<()> {
        match &self.kind {
            Kind::Files { found, side_by_side } => {
                let frame = |side: usize, path: &PathBuf| {
                    let frame = Frame { upright: self.upright[side], ..Frame::file(path.clone()) };
                    if *side_by_side { frame.half(side) } else { frame }
                };
                let skipped = found.skipped.iter().cloned().map(Item::Skipped);
                let pairs = found.pairs.iter().map(|[l, r]| Item::Pair([frame(0, l), frame(1, r)]));
                for item in skipped.chain(pairs) {
                    if take(item).is_break() {
                        break;
                    }
                }
                Ok(())
            }
            Kind::Bag(bag) => bag.read(tolerance_s, take),
        }
    }
}

/// Whether the first picture is as wide as two side by side.
fn is_wide(images: &[PathBuf]) -> bool {
    let size = images.first().and_then(|path| image::image_dimensions(path).ok());
    size.is_some_and(|(width, height)| f64::from(width) >= WIDE * f64::from(height))
}
