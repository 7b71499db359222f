//! ROS 1 bags.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use rosbag::{ChunkRecord, MessageRecord, RosBag};

use super::bag::{End, Message};

/// Length of the padded header of a bag after the version, bytes.
const HEAD: u64 = 4096;

/// Hands out all messages. An error if the file is no whole bag.
pub(super) fn messages(
    file: &Path,
    take: &mut dyn FnMut(Message<'_>) -> ControlFlow<()>,
) -> Result<End> {
    let bag = open(file)?;
    Ok(match each(&bag, take) {
        Ok(end) => end.map_continue(|()| None),
        Err(why) => ControlFlow::Continue(Some(why.to_string())),
    })
}

/// An error at the first damaged part of the bag; the messages before it are handed out.
fn each(
    bag: &RosBag,
    take: &mut dyn FnMut(Message<'_>) -> ControlFlow<()>,
) -> Result<ControlFlow<()>, rosbag::Error> {
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
                        return Ok(ControlFlow::Break(()));
                    }
                }
            }
        }
    }
    Ok(ControlFlow::Continue(()))
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
