//! ROS 1 bags.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result};
use rosbag::{ChunkRecord, MessageRecord, RosBag};

use super::bag::{Pairing, Topic, Topics, rig};
use super::message::Encoding;
use super::{RigOf, Take};

/// Messages that are looked at for topics and calibrations before the images are read.
const LOOK: usize = 4000;

/// A message: topic, type, bytes.
type Message<'a> = (&'a str, &'a str, &'a [u8]);

/// Hands out all messages; the error where the bag is damaged from there on.
fn messages(
    bag: &RosBag,
    take: &mut dyn FnMut(Message<'_>) -> ControlFlow<()>,
) -> Result<(), rosbag::Error> {
    let mut connections: HashMap<u32, (String, String)> = HashMap::new();
    for record in bag.chunk_records() {
        let ChunkRecord::Chunk(chunk) = record? else { continue };
        for message in chunk.messages() {
            match message? {
                MessageRecord::Connection(c) => {
                    connections.insert(c.id, (c.topic.to_owned(), c.tp.to_owned()));
                }
                MessageRecord::MessageData(m) => {
                    let Some((topic, kind)) = connections.get(&m.conn_id) else { continue };
                    if take((topic, kind, m.data)).is_break() {
                        return Ok(());
                    }
                }
            }
        }
    }
    Ok(())
}

fn open(file: &Path) -> Result<RosBag> {
    RosBag::new(file).with_context(|| format!("cannot open the bag {}", file.display()))
}

/// Topics and calibration.
pub(super) fn look(file: &Path, wanted: Option<[String; 2]>) -> Result<(Topics, RigOf)> {
    let (mut all, mut infos, mut seen) = (Vec::new(), Vec::new(), 0);
    let mut note = |(topic, kind, bytes): Message<'_>| {
        if kind == "sensor_msgs/CameraInfo" && infos.iter().all(|(name, _)| name != topic) {
            infos.push((topic.to_owned(), bytes.to_vec()));
        }
        let images = Topic::of(topic, kind).filter(|topic| !all.contains(topic));
        all.extend(images);
        seen += 1;
        if seen < LOOK { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    // A damaged rest is said when it is read.
    let _ = messages(&open(file)?, &mut note);
    let topics = Topics::choose(&all, wanted).with_context(|| file.display().to_string())?;
    let info = |name: String| {
        let found = infos.iter().find(|(topic, _)| *topic == name);
        found.map(|(_, bytes)| (bytes.clone(), Encoding::Packed))
    };
    let rig = rig(file, topics.infos().map(info))?;
    Ok((topics, rig))
}

/// Hands out all pairs.
pub(super) fn read(file: &Path, topics: &Topics, tolerance_s: f64, take: Take<'_>) -> Result<()> {
    let bag = open(file)?;
    let mut pairing = Pairing::new(topics, tolerance_s, Encoding::Packed, take);
    let outcome = messages(&bag, &mut |(topic, _, bytes)| pairing.push(topic, bytes));
    pairing.finish(outcome.err().map(|why| format!("the rest of {}: {why}", file.display())));
    Ok(())
}
