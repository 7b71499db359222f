//! The common part of both bags: topics, time stamps, calibration.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use selfcal_commands::conventions::{Files, Unknowns, rig_of};

use super::message::{Encoding, ImageMessage, camera_info};
use super::partners::{Partner, Partners};
use super::{Frame, Item, RigOf, Take};

/// Topics of the left and of the right image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topics(pub [Topic; 2]);

/// A topic of images.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// Whether its messages are `CompressedImage`.
    pub compressed: bool,
}

/// Parts of a name that say which side a topic is of.
const LEFT: [&str; 6] = ["left", "cam0", "infra1", "image_0", "camera0", "/0/"];
const RIGHT: [&str; 6] = ["right", "cam1", "infra2", "image_1", "camera1", "/1/"];

impl Topic {
    /// A topic by the type of its messages, if they are images.
    pub(super) fn of(name: &str, message: &str) -> Option<Self> {
        let compressed = match message {
            "sensor_msgs/msg/Image" | "sensor_msgs/Image" => false,
            "sensor_msgs/msg/CompressedImage" | "sensor_msgs/CompressedImage" => true,
            _ => return None,
        };
        Some(Self { name: name.to_owned(), compressed })
    }
}

impl Topics {
    /// The wanted topics, or those whose names say left and right.
    pub(super) fn choose(all: &[Topic], wanted: Option<[String; 2]>) -> Result<Self> {
        let names = || all.iter().map(|topic| topic.name.as_str()).collect::<Vec<_>>().join(", ");
        ensure!(!all.is_empty(), "no topic of images (sensor_msgs Image or CompressedImage)");
        if let Some(wanted) = wanted {
            let find = |name: &String| {
                let found = all.iter().find(|topic| topic.name == *name);
                found
                    .cloned()
                    .with_context(|| format!("no topic {name} of images; there are {}", names()))
            };
            let [left, right] = &wanted;
            return Ok(Self([find(left)?, find(right)?]));
        }
        let of = |words: &[&str]| {
            let mut found = all.iter().filter(|t| words.iter().any(|word| t.name.contains(word)));
            found.next().cloned()
        };
        match of(&LEFT).zip(of(&RIGHT)) {
            Some((left, right)) if left != right => Ok(Self([left, right])),
            _ => bail!("which topics are left and right? give --topics LEFT,RIGHT of {}", names()),
        }
    }

    /// Which side a topic is.
    pub(super) fn side(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|topic| topic.name == name)
    }

    /// The `camera_info` topics beside the images.
    pub(super) fn infos(&self) -> [String; 2] {
        self.0.each_ref().map(|topic| {
            let name = topic.name.strip_suffix("/compressed").unwrap_or(&topic.name);
            let (space, _) = name.rsplit_once('/').unwrap_or(("", name));
            format!("{space}/camera_info")
        })
    }
}

/// The rig of two `camera_info`, if both are there and calibrated.
pub(super) fn rig(file: &Path, infos: [Option<(Vec<u8>, Encoding)>; 2]) -> Result<RigOf> {
    let mut texts = Vec::new();
    for (info, side) in infos.into_iter().zip(["left", "right"]) {
        let Some((bytes, encoding)) = info else { return Ok(RigOf::Nothing) };
        let Some(text) = camera_info(&bytes, encoding)? else { return Ok(RigOf::Nothing) };
        let name = format!("camera_info ({side}) of {}", file.display());
        texts.push((PathBuf::from(name), text));
    }
    Ok(RigOf::Read(Box::new(rig_of(&Files::of(texts)?, Unknowns::default())?)))
}

/// Pairs the images of a bag as they come.
pub(super) struct Pairing<'a> {
    topics: &'a Topics,
    partners: Partners<ImageMessage>,
    take: Take<'a>,
    encoding: Encoding,
}

impl<'a> Pairing<'a> {
    pub(super) fn new(
        topics: &'a Topics,
        tolerance_s: f64,
        encoding: Encoding,
        take: Take<'a>,
    ) -> Self {
        Self { topics, partners: Partners::new(tolerance_s), take, encoding }
    }

    /// One more message of a topic.
    pub(super) fn push(&mut self, topic: &str, bytes: &[u8]) -> ControlFlow<()> {
        let Some(side) = self.topics.side(topic) else { return ControlFlow::Continue(()) };
        let compressed = self.topics.0[side].compressed;
        match ImageMessage::new(topic, self.encoding, compressed, bytes.to_vec()) {
            Ok(message) => {
                let decided = self.partners.push(side, message.stamp, message);
                self.hand_out(decided)
            }
            Err(why) => (self.take)(Item::Skipped(format!("{topic}: {why:#}"))),
        }
    }

    /// The end of the bag, and why it ended early, if it did.
    pub(super) fn finish(&mut self, early: Option<String>) {
        let rest = self.partners.finish();
        if self.hand_out(rest).is_continue() {
            // Nothing follows that a break could end.
            let _ = early.map(|why| (self.take)(Item::Skipped(why)));
        }
    }

    fn hand_out(&mut self, decided: Vec<Partner<ImageMessage>>) -> ControlFlow<()> {
        for one in decided {
            (self.take)(match one {
                Partner::Pair(pair) => Item::Pair(pair.map(Frame::Message)),
                Partner::Alone(_, m) => {
                    Item::Skipped(format!("{} at {:.3} s: no partner in time", m.topic, m.stamp))
                }
            })?;
        }
        ControlFlow::Continue(())
    }
}
