//! ROS 2 bags in MCAP.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context, Result};
use mcap::io::MessageReader;

use super::Take;
use super::bag::{Infos, Pairing, Topic, Topics, Wanted};
use super::message::Encoding;

/// Number of messages that are searched for topics and calibrations before the images are read.
const LOOK: usize = 4000;

fn open(file: &Path) -> Result<MessageReader<BufReader<File>>> {
    let opened = File::open(file).with_context(|| format!("cannot open {}", file.display()))?;
    Ok(MessageReader::new(BufReader::new(opened)))
}

/// Topics and calibration.
pub(super) fn look(file: &Path, wanted: &Wanted) -> Result<(Topics, Infos)> {
    let (mut all, mut infos) = (Vec::new(), Vec::new());
    for message in open(file)?.take(LOOK) {
        let Ok(message) = message else { break };
        let topic = &message.channel.topic;
        let schema = message.channel.schema.as_ref().map(|s| s.name.clone()).unwrap_or_default();
        if schema == "sensor_msgs/msg/CameraInfo" && infos.iter().all(|(name, _)| name != topic) {
            infos.push((topic.clone(), message.data.to_vec()));
        }
        let images = Topic::of(topic, &schema).filter(|topic| !all.contains(topic));
        all.extend(images);
    }
    let topics = Topics::choose(&all, wanted).with_context(|| file.display().to_string())?;
    let infos = Infos::of(file, &topics, &infos, Encoding::Cdr);
    Ok((topics, infos))
}

/// Hands the pairs to `take` in order, until it breaks or the file is damaged.
pub(super) fn read(file: &Path, topics: &Topics, tolerance_s: f64, take: Take<'_>) -> Result<()> {
    let mut pairing = Pairing::new(topics, tolerance_s, Encoding::Cdr, take);
    for message in open(file)? {
        match message {
            Ok(message) => {
                if pairing.push(&message.channel.topic, &message.data).is_break() {
                    return Ok(());
                }
            }
            Err(why) => {
                pairing.finish(Some(format!("the rest of {}: {why}", file.display())));
                return Ok(());
            }
        }
    }
    pairing.finish(None);
    Ok(())
}
