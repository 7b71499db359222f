//! A bag of any kind: its images in pairs, and its calibration.

mod content;
mod infos;
mod mcap;
mod parts;
mod recording;
mod ros1;
#[cfg(feature = "sqlite")]
mod sqlite;
mod topics;

use std::ops::ControlFlow;

use anyhow::{Context, Result};

use super::message::ImageMessage;
use super::partners::{Partner, Partners};
use super::{Frame, Item, Take};
use infos::Message;
use parts::Part;
use topics::{Topic, Topics};

pub use infos::Infos;
pub(super) use recording::Recording;
pub use topics::Wanted;

/// Number of messages that are searched for topics and calibrations before the images are read.
const LOOK: usize = 4000;

/// A bag and its topics of images.
#[derive(Debug, Clone)]
pub(super) struct Bag {
    recording: Recording,
    topics: Topics,
    /// Begin and end of the pairs that are read, s after the first image.
    window: [Option<f64>; 2],
}

impl Bag {
    /// Finds the topics of a bag, and its calibration.
    pub(super) fn open(recording: Recording, wanted: &Wanted) -> Result<(Self, Infos)> {
        let (mut all, mut infos, mut seen) = (Vec::new(), Vec::<Message>::new(), 0);
        let mut damage = None;
        recording.read(&mut |part| {
            match part {
                Part::Message { topic, kind, bytes, encoding } => {
                    let is_info =
                        matches!(kind, "sensor_msgs/msg/CameraInfo" | "sensor_msgs/CameraInfo");
                    if is_info && infos.iter().all(|info| info.topic != topic) {
                        infos.push(Message { topic: topic.into(), bytes: bytes.into(), encoding });
                    }
                    all.extend(Topic::of(topic, kind).filter(|topic| !all.contains(topic)));
                    seen += 1;
                }
                // Reported again when the images are read.
                Part::Damaged(why) => damage = damage.take().or(Some(why)),
            }
            if seen < LOOK { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })?;
        let topics = Topics::choose(&all, wanted).with_context(|| {
            let damage = damage.map(|why| format!(" ({why})"));
            format!("{}{}", recording.name(), damage.unwrap_or_default())
        })?;
        let bag = Self { recording, topics, window: wanted.window };
        let infos = Infos::of(&bag, &infos);
        Ok((bag, infos))
    }

    /// The chosen topics in words.
    pub(super) fn choice(&self) -> String {
        let [left, right] = &self.topics.0;
        if self.topics.is_side_by_side() {
            format!("topic {}: left and right halves", left.name)
        } else {
            format!("topics: left {}, right {}", left.name, right.name)
        }
    }

    /// Hands the pairs to `take` in order, until it breaks or the window ends.
    pub(super) fn read(&self, tolerance_s: f64, take: Take<'_>) -> Result<()> {
        let partners = Partners::new(tolerance_s);
        let mut pairing = Pairing { bag: self, partners, take, first_s: None, is_ended: false };
        self.recording.read(&mut |part| {
            let flow = pairing.part(part);
            pairing.is_ended = flow.is_break();
            flow
        })?;
        if !pairing.is_ended {
            let rest = pairing.partners.finish();
            // These are the last items, so the answer does not matter.
            let _ = pairing.hand_out(rest);
        }
        Ok(())
    }

    /// Whether only a part of the bag is read.
    pub(super) fn has_window(&self) -> bool {
        self.window != [None; 2]
    }
}

/// Pairs the images of a bag as they are read.
struct Pairing<'a> {
    bag: &'a Bag,
    partners: Partners<ImageMessage>,
    take: Take<'a>,
    /// Time stamp of the first image, s.
    first_s: Option<f64>,
    is_ended: bool,
}

impl Pairing<'_> {
    fn part(&mut self, part: Part<'_>) -> ControlFlow<()> {
        let (topic, bytes, encoding) = match part {
            Part::Message { topic, bytes, encoding, .. } => (topic, bytes, encoding),
            Part::Damaged(why) => return (self.take)(Item::Damaged(why)),
        };
        let topics = &self.bag.topics;
        let Some(side) = topics.0.iter().position(|of| of.name == topic) else {
            return ControlFlow::Continue(());
        };
        match ImageMessage::new(topic, encoding, topics.0[side].compressed, bytes.to_vec()) {
            Ok(message) if topics.is_side_by_side() => {
                self.hand_out(vec![Partner::Pair([message.clone(), message])])
            }
            Ok(message) => {
                let (stamp, length) = (message.stamp, bytes.len());
                self.first_s.get_or_insert(stamp);
                let decided = self.partners.push(side, stamp, length, message);
                self.hand_out(decided)
            }
            Err(why) => (self.take)(Item::Damaged(format!("{topic}: {why:#}"))),
        }
    }

    fn hand_out(&mut self, decided: Vec<Partner<ImageMessage>>) -> ControlFlow<()> {
        let [begin, end] = self.bag.window;
        for one in decided {
            let (Partner::Pair([m, _]) | Partner::Alone(_, m)) = &one;
            let at = m.stamp - *self.first_s.get_or_insert(m.stamp);
            if begin.is_some_and(|begin| at < begin) {
                continue;
            }
            if end.is_some_and(|end| at > end) {
                return ControlFlow::Break(());
            }
            (self.take)(match one {
                Partner::Pair(pair) if self.bag.topics.is_side_by_side() => {
                    let [left, right] = pair.map(Frame::message);
                    Item::Pair([left.half(0), right.half(1)])
                }
                Partner::Pair(pair) => Item::Pair(pair.map(Frame::message)),
                Partner::Alone(_, m) => {
                    Item::Skipped(format!("{} at {:.3} s: no partner in time", m.topic, m.stamp))
                }
            })?;
        }
        ControlFlow::Continue(())
    }
}
