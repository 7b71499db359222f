//! Where pairs of images come from: folders, data sets, bags.

mod bag;
mod folders;
mod layout;
mod mcap;
mod message;
mod partners;
mod rosbag;

use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use host_tests::data::Meta;

use crate::picture::Picture;
use crate::shipped::ShippedImages;

pub use bag::Topics;
pub use message::ImageMessage;

/// An image that is not decoded yet.
#[derive(Debug, Clone)]
pub enum Frame {
    /// A file.
    File(PathBuf),
    /// A message of a bag.
    Message(ImageMessage),
}

impl Frame {
    /// Reads and decodes it.
    ///
    /// # Errors
    /// Names the file or the message.
    pub fn picture(&self) -> Result<Picture> {
        match self {
            Self::File(path) => Picture::read(path),
            Self::Message(message) => message.picture(),
        }
    }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => {
                write!(f, "{}", Path::new(path.file_name().unwrap_or_default()).display())
            }
            Self::Message(message) => write!(f, "{} at {:.3} s", message.topic, message.stamp),
        }
    }
}

/// What a source gives, in order.
#[derive(Debug, Clone)]
pub enum Item {
    /// A pair, left first.
    Pair([Frame; 2]),
    /// Something that is no pair, and why.
    Skipped(String),
}

/// Who takes the items; `Break` ends the reading.
pub type Take<'a> = &'a mut dyn FnMut(Item) -> ControlFlow<()>;

/// A source of pairs.
#[derive(Debug)]
pub struct Source {
    /// Name for people.
    pub name: String,
    /// The rig that came with it.
    pub rig: RigOf,
    /// How many pairs it has, where that is known before they are read.
    pub count: Option<usize>,
    kind: Kind,
}

/// The rig that comes with a source.
#[derive(Debug)]
pub enum RigOf {
    /// None.
    Nothing,
    /// Files of a calibration.
    Files(Vec<PathBuf>),
    /// Read already.
    Read(Box<Meta>),
}

#[derive(Debug)]
enum Kind {
    Files { pairs: Vec<[PathBuf; 2]>, skipped: Vec<String> },
    Mcap { file: PathBuf, topics: Topics, tolerance_s: f64 },
    Rosbag { file: PathBuf, topics: Topics, tolerance_s: f64 },
}

impl Source {
    /// Opens a source: one place, or a left and a right one.
    ///
    /// * `tolerance_s`: by how much the time stamps of a pair may differ.
    ///
    /// # Errors
    /// If nothing is there, or it is nothing that is known.
    pub fn open(places: &[PathBuf], topics: Option<[String; 2]>, tolerance_s: f64) -> Result<Self> {
        ensure!(tolerance_s >= 0.0 && tolerance_s.is_finite(), "the tolerance must be 0 s or more");
        match places {
            [one] => Self::one(one, topics, tolerance_s),
            [left, right] => {
                let sides = [folders::images(left)?, folders::images(right)?];
                Ok(Self::of_files(left.display().to_string(), RigOf::Nothing, sides, tolerance_s))
            }
            _ => anyhow::bail!("one source, or a left and a right one, not {}", places.len()),
        }
    }

    fn one(place: &Path, topics: Option<[String; 2]>, tolerance_s: f64) -> Result<Self> {
        if let Some(images) = ShippedImages::named(place) {
            let pairs = images.files();
            return Ok(Self {
                name: images.name().into(),
                rig: RigOf::Read(Box::new(images.sift()?.meta)),
                count: Some(pairs.len()),
                kind: Kind::Files { pairs, skipped: Vec::new() },
            });
        }
        let extension = place.extension().and_then(|e| e.to_str()).unwrap_or_default();
        ensure!(
            place.exists(),
            "{} does not exist, and is none of the shipped images ({})",
            place.display(),
            ShippedImages::ALL.map(ShippedImages::name).join(", ")
        );
        let file = place.to_path_buf();
        let name = place.display().to_string();
        match extension {
            _ if place.is_dir() => {
                let layout = layout::Layout::of(place)?;
                Ok(Self::of_files(name, RigOf::Files(layout.rig), layout.sides, tolerance_s))
            }
            "mcap" => {
                let (topics, rig) = mcap::look(place, topics)?;
                Ok(Self { name, rig, count: None, kind: Kind::Mcap { file, topics, tolerance_s } })
            }
            "bag" => {
                let (topics, rig) = rosbag::look(place, topics)?;
                Ok(Self {
                    name,
                    rig,
                    count: None,
                    kind: Kind::Rosbag { file, topics, tolerance_s },
                })
            }
            _ => anyhow::bail!(
                "{name}: a folder, an MCAP file (*.mcap) or a ROS 1 bag (*.bag) is expected; of two folders or \
                 patterns, give both"
            ),
        }
    }

    fn of_files(name: String, rig: RigOf, sides: [Vec<PathBuf>; 2], tolerance_s: f64) -> Self {
        let (pairs, skipped) = partners::of_files(sides, tolerance_s);
        Self { name, rig, count: Some(pairs.len()), kind: Kind::Files { pairs, skipped } }
    }

    /// Hands out all items, one at a time.
    ///
    /// # Errors
    /// If a bag cannot be opened. A damaged rest of it is an item that is skipped.
    pub fn read(&self, take: Take<'_>) -> Result<()> {
        match &self.kind {
            Kind::Files { pairs, skipped } => {
                let skipped = skipped.iter().cloned().map(Item::Skipped);
                let pairs = pairs.iter().map(|pair| Item::Pair(pair.clone().map(Frame::File)));
                for item in skipped.chain(pairs) {
                    if take(item).is_break() {
                        break;
                    }
                }
                Ok(())
            }
            Kind::Mcap { file, topics, tolerance_s } => {
                mcap::read(file, topics, *tolerance_s, take)
            }
            Kind::Rosbag { file, topics, tolerance_s } => {
                rosbag::read(file, topics, *tolerance_s, take)
            }
        }
    }
}
