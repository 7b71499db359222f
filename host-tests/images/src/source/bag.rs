//! A bag of either kind: its images in pairs, and its calibration.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use rigs::data::Meta;
use rigs::formats::{Files, Unknowns, rig_of, rig_of_rectified};

use super::message::{CameraInfo, Encoding, ImageMessage, camera_info};
use super::partners::{Partner, Partners};
use super::topics::{Topic, Topics, Wanted};
use super::{Frame, Item, Take, mcap, rosbag};
use crate::resized::{self, Change};

/// Number of messages that are searched for topics and calibrations before the images are read.
const LOOK: usize = 4000;

/// A message: topic, type, bytes.
pub(super) type Message<'a> = (&'a str, &'a str, &'a [u8]);

/// End of the messages: `Break` if the receiver ended them, otherwise why the bag ended early, if it did.
pub(super) type End = ControlFlow<(), Option<String>>;

/// A bag and its topics of images.
#[derive(Debug, Clone)]
pub(super) struct Bag {
    file: PathBuf,
    encoding: Encoding,
    pub(super) topics: Topics,
}

impl Bag {
    /// Finds the topics of a bag, and its calibration.
    pub(super) fn open(file: &Path, encoding: Encoding, wanted: &Wanted) -> Result<(Self, Infos)> {
        let (mut all, mut infos, mut seen) = (Vec::new(), Vec::new(), 0);
        let mut note = |(topic, kind, bytes): Message<'_>| {
            let is_info = matches!(kind, "sensor_msgs/msg/CameraInfo" | "sensor_msgs/CameraInfo");
            if is_info && infos.iter().all(|(name, _)| name != topic) {
                infos.push((topic.to_owned(), bytes.to_vec()));
            }
            let images = Topic::of(topic, kind).filter(|topic| !all.contains(topic));
            all.extend(images);
            seen += 1;
            if seen < LOOK { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        // A damaged part is reported when the images are read.
        let _ = messages(file, encoding, &mut note)?;
        let topics = Topics::choose(&all, wanted).with_context(|| file.display().to_string())?;
        let bag = Self { file: file.to_owned(), encoding, topics };
        let infos = Infos::of(&bag, &infos);
        Ok((bag, infos))
    }

    /// Hands the pairs to `take` in order, until it breaks or the file is damaged.
    pub(super) fn read(&self, tolerance_s: f64, take: Take<'_>) -> Result<()> {
        let mut pairing = Pairing { bag: self, partners: Partners::new(tolerance_s), take };
        let push = &mut |(topic, _, bytes): Message<'_>| pairing.push(topic, bytes);
        if let ControlFlow::Continue(early) = messages(&self.file, self.encoding, push)? {
            pairing.finish(early.map(|why| format!("the rest of {}: {why}", self.file.display())));
        }
        Ok(())
    }
}

/// Hands out all messages of a bag. An error if it cannot be opened.
fn messages(
    file: &Path,
    encoding: Encoding,
    take: &mut dyn FnMut(Message<'_>) -> ControlFlow<()>,
) -> Result<End> {
    match encoding {
        Encoding::Cdr => mcap::messages(file, take),
        Encoding::Packed => rosbag::messages(file, take),
    }
}

/// The `camera_info` of a bag's topics. It is decoded on demand, so that an invalid one does no harm if the user gives
/// the rig.
#[derive(Debug, Clone)]
pub struct Infos {
    bag: Bag,
    /// For each side the topic and its first message.
    messages: [Option<(String, Vec<u8>)>; 2],
}

impl Infos {
    /// The `camera_info` of the topics of a bag.
    ///
    /// * `all`: the first `camera_info` message of every topic that has them, with the topic's name.
    fn of(bag: &Bag, all: &[(String, Vec<u8>)]) -> Self {
        let find = |topic: &Topic| {
            let mut names = topic.infos().into_iter();
            names.find_map(|name| all.iter().find(|(topic, _)| *topic == name).cloned())
        };
        Self { messages: bag.topics.0.each_ref().map(find), bag: bag.clone() }
    }

    /// The rig. For rectified images the camera matrix is in `P`. `None` if a side has no `camera_info`.
    ///
    /// # Errors
    /// Names the topic, the key and the invalid value.
    pub fn rig(&self) -> Result<Option<Meta>> {
        let [Some(left), Some(right)] = &self.messages else { return Ok(None) };
        let read = |(topic, bytes): &(String, Vec<u8>)| -> Result<(PathBuf, CameraInfo)> {
            let name = PathBuf::from(format!("{topic} of {}", self.bag.file.display()));
            let info = camera_info(bytes, self.bag.encoding)
                .with_context(|| name.display().to_string())?;
            Ok((name, info))
        };
        let infos = [read(left)?, read(right)?];
        let files = Files::of(
            infos.iter().map(|(name, info)| (name.clone(), info.text.clone())).collect(),
        )?;
        let rectified = self.bag.topics.0.each_ref().map(Topic::is_rectified);
        let meta = match rectified {
            [true, true] => rig_of_rectified(&files)?,
            [false, false] => rig_of(&files, Unknowns::default())?,
            _ => bail!(
                "{} is rectified and {} is not: choose two of a kind with --left-topic and --right-topic",
                self.bag.topics.0[usize::from(rectified[1])].name,
                self.bag.topics.0[usize::from(rectified[0])].name
            ),
        };
        let [a, b] = [0, 1].map(|side| {
            Change::of_info(meta.sizes()[side], infos[side].1.roi, infos[side].1.binning)
        });
        Ok(Some(resized::changed(&meta, [a?, b?])))
    }

    /// Says on which topics `camera_info` is missing.
    pub fn missing(&self) -> String {
        let names = self.bag.topics.0.each_ref().map(|topic| topic.infos().remove(0));
        format!("no camera_info on {} and {}", names[0], names[1])
    }
}

/// Pairs the images of a bag as they are read.
struct Pairing<'a> {
    bag: &'a Bag,
    partners: Partners<ImageMessage>,
    take: Take<'a>,
}

impl Pairing<'_> {
    /// Adds a message of a topic.
    fn push(&mut self, topic: &str, bytes: &[u8]) -> ControlFlow<()> {
        let Bag { topics, encoding, .. } = self.bag;
        let Some(side) = topics.0.iter().position(|of| of.name == topic) else {
            return ControlFlow::Continue(());
        };
        match ImageMessage::new(topic, *encoding, topics.0[side].compressed, bytes.to_vec()) {
            Ok(message) if topics.is_side_by_side() => {
                let half = |side| Frame::message(message.clone()).half(side);
                (self.take)(Item::Pair([half(0), half(1)]))
            }
            Ok(message) => {
                let decided = self.partners.push(side, message.stamp, message);
                self.hand_out(decided)
            }
            Err(why) => (self.take)(Item::Skipped(format!("{topic}: {why:#}"))),
        }
    }

    /// Hands out the rest at the end of the bag.
    ///
    /// * `early`: why the bag ended early, if it did.
    fn finish(&mut self, early: Option<String>) {
        let rest = self.partners.finish();
        if self.hand_out(rest).is_continue() {
            // This is the last item, so the answer does not matter.
            let _ = early.map(|why| (self.take)(Item::Skipped(why)));
        }
    }

    fn hand_out(&mut self, decided: Vec<Partner<ImageMessage>>) -> ControlFlow<()> {
        for one in decided {
            (self.take)(match one {
                Partner::Pair(pair) => Item::Pair(pair.map(Frame::message)),
                Partner::Alone(_, m) => {
                    Item::Skipped(format!("{} at {:.3} s: no partner in time", m.topic, m.stamp))
                }
            })?;
        }
        ControlFlow::Continue(())
    }
}
