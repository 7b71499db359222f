//! ROS 1 bags.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use rosbag::{ChunkRecord, MessageRecord, RosBag};

use super::Take;
use super::bag::{Infos, Pairing, Topic, Topics, Wanted};
use super::message::Encoding;

/// Number of messages that are searched for topics and calibrations before the images are read.
const LOOK: usize = 4000;

/// Length of the padded header of a bag after the version, bytes.
const HEAD: u64 = 4096;

/// A message: topic, type, bytes.
type Message<'a> = (&'a str, &'a str, &'a [u8]);

/// Hands out all messages.
///
/// # Errors
/// At the first damaged part of the bag; the messages before it are handed out.
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
    whole(file).with_context(|| format!("the bag {}", file.display()))?;
    RosBag::new(file).with_context(|| format!("cannot open the bag {}", file.display()))
}

/// Refuses a bag without its end (cut short, or never closed), because the reader would panic.
fn whole(file: &Path) -> Result<()> {
    const NAME: &[u8] = b"index_pos=";
    let mut bag = File::open(file)?;
    let length = bag.metadata()?.len();
    let mut head = Vec::new();
    bag.by_ref().take(HEAD).read_to_end(&mut head)?;
    let at = head.windows(NAME.len()).position(|field| field == NAME);
    let index = at.and_then(|at| head.get(at + NAME.len()..)?.first_chunk());
    let index = u64::from_le_bytes(*index.context("has no header of a ROS 1 bag")?);
    ensure!(
        (HEAD..=length).contains(&index),
        "is cut short or was not closed: its index would begin at byte {index} of {length}. Repair it with `rosbag \
         reindex`"
    );
    Ok(())
}

/// Topics and calibration.
pub(super) fn look(file: &Path, wanted: &Wanted) -> Result<(Topics, Infos)> {
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
    // A damaged part is reported when the images are read.
    let _ = messages(&open(file)?, &mut note);
    let topics = Topics::choose(&all, wanted).with_context(|| file.display().to_string())?;
    let infos = Infos::of(file, &topics, &infos, Encoding::Packed);
    Ok((topics, infos))
}

/// Hands the pairs to `take` in order, until it breaks or the file is damaged.
pub(super) fn read(file: &Path, topics: &Topics, tolerance_s: f64, take: Take<'_>) -> Result<()> {
    let bag = open(file)?;
    let mut pairing = Pairing::new(topics, tolerance_s, Encoding::Packed, take);
    let outcome = messages(&bag, &mut |(topic, _, bytes)| pairing.push(topic, bytes));
    pairing.finish(outcome.err().map(|why| format!("the rest of {}: {why}", file.display())));
    Ok(())
}
