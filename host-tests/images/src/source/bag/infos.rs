//! The calibration that a bag has: the `camera_info` of its topics.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use rigs::data::Meta;
use rigs::formats::{Files, Unknowns, rig_of, rig_of_rectified};

use super::Bag;
use super::topics::Topic;
use crate::resized::{self, Change};
use crate::source::fields::Encoding;
use crate::source::message::{CameraInfo, camera_info};

/// A message of `camera_info`.
#[derive(Debug, Clone)]
pub(super) struct Message {
    pub(super) topic: String,
    pub(super) bytes: Vec<u8>,
    pub(super) encoding: Encoding,
}

/// The `camera_info` of a bag's topics. It is decoded on demand, so that an invalid one does no harm if the user gives
/// the rig.
#[derive(Debug, Clone)]
pub struct Infos {
    bag: Bag,
    /// The first message of each side.
    messages: [Option<Message>; 2],
}

impl Infos {
    /// The `camera_info` of the topics of a bag.
    ///
    /// * `all`: the first `camera_info` message of every topic that has them.
    pub(super) fn of(bag: &Bag, all: &[Message]) -> Self {
        let find = |topic: &Topic| {
            let mut names = topic.infos().into_iter();
            names.find_map(|name| all.iter().find(|message| message.topic == name).cloned())
        };
        Self { messages: bag.topics.0.each_ref().map(find), bag: bag.clone() }
    }

    /// The rig. For rectified images the camera matrix is in `P`. `None` if a side has no `camera_info`.
    ///
    /// # Errors
    /// Names the topic, the key and the invalid value.
    pub fn rig(&self) -> Result<Option<Meta>> {
        let [Some(left), Some(right)] = &self.messages else { return Ok(None) };
        let read = |message: &Message| -> Result<(PathBuf, CameraInfo)> {
            let Message { topic, bytes, encoding } = message;
            let name = PathBuf::from(format!("{topic} of {}", self.bag.recording.name()));
            let info = camera_info(bytes, *encoding).with_context(|| name.display().to_string())?;
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
