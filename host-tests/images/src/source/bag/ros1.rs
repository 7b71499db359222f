//! ROS 1 bags (<http://wiki.ros.org/Bags/Format/2.0>), read from the first record to the last, so that a bag without
//! its index gives its messages too.
//!
//! A record is a header of named fields and its data, each after its length. The crate `rosbag` decompresses without a
//! bound, and panics at a bag without index.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use super::content::{exactly, inflated};
use super::parts::Parts;

/// First bytes of a bag; the version follows.
pub(super) const MAGIC: &[u8] = b"#ROSBAG V";

/// The version that is read.
const VERSION: &[u8] = b"2.0\n";

/// Advice for a bag without its index.
const REPAIR: &str = "`rosbag reindex` writes its index again";

/// Operation codes.
const MESSAGE: u8 = 2;
const BAG: u8 = 3;
const INDEX: u8 = 4;
const CHUNK: u8 = 5;
const CHUNK_INFO: u8 = 6;
const CONNECTION: u8 = 7;

/// Hands out all messages, and the damaged parts.
///
/// # Errors
/// If the file cannot be opened, has another version, or is encrypted.
pub(super) fn messages(file: &Path, out: &mut Parts<'_>) -> Result<ControlFlow<()>> {
    let mut input = BufReader::new(File::open(file).context("cannot open")?);
    let start = exactly(&mut input, (MAGIC.len() + VERSION.len()) as u64).unwrap_or_default();
    ensure!(start.starts_with(MAGIC), "has no header of a ROS 1 bag");
    ensure!(
        start.ends_with(VERSION),
        "is a bag of a version before 2.0: `rosbag migrate` writes one of 2.0"
    );
    let mut bag = Records::default();
    while !input.fill_buf().context("cannot be read")?.is_empty() {
        let record = counted(&mut input).and_then(|head| Ok((head, counted(&mut input)?)));
        let (head, data) = match record {
            Ok(record) => record,
            Err(why) => return Ok(out.damaged(format!("the rest is lost: {why:#} ({REPAIR})"))),
        };
        if let Some(encryption) = Header(&head).field("encryptor").filter(|name| !name.is_empty()) {
            bail!("is encrypted ({})", String::from_utf8_lossy(encryption));
        }
        if bag.record(Header(&head), &data, out).is_break() {
            return Ok(ControlFlow::Break(()));
        }
    }
    let advice = format!(": it is cut short, or was not closed ({REPAIR})");
    Ok(out.stated(bag.stated, &advice))
}

/// Bytes after their length.
fn counted(input: &mut impl Read) -> Result<Vec<u8>> {
    let length = exactly(input, 4)?;
    exactly(input, length.first_chunk().map_or(0, |four| u32::from_le_bytes(*four)).into())
}

/// As [`counted`], from bytes in memory.
fn counted_of<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (length, rest) = bytes.split_first_chunk()?;
    let (content, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    *bytes = rest;
    Some(content)
}

/// Named fields.
#[derive(Clone, Copy)]
struct Header<'a>(&'a [u8]);

impl<'a> Header<'a> {
    fn field(self, name: &str) -> Option<&'a [u8]> {
        let mut rest = self.0;
        while let Some(field) = counted_of(&mut rest) {
            let value = field.strip_prefix(name.as_bytes()).and_then(|f| f.strip_prefix(b"="));
            if value.is_some() {
                return value;
            }
        }
        None
    }

    fn u32(self, name: &str) -> Option<u32> {
        Some(u32::from_le_bytes(self.field(name)?.try_into().ok()?))
    }

    fn text(self, name: &str) -> Option<&'a str> {
        std::str::from_utf8(self.field(name)?).ok()
    }
}

/// The records so far.
#[derive(Default)]
struct Records {
    /// Topic and type of each connection.
    connections: HashMap<u32, (String, String)>,
    /// Number of messages that the index states.
    stated: u64,
}

impl Records {
    fn record(&mut self, head: Header<'_>, data: &[u8], out: &mut Parts<'_>) -> ControlFlow<()> {
        let done = match head.field("op") {
            Some([MESSAGE]) => return self.message(head, data, out),
            Some([CHUNK]) => match content(head, data) {
                Ok(records) => return self.chunk(&records, out),
                Err(why) => Err(why),
            },
            Some([CONNECTION]) => self.connection(head, data),
            Some([CHUNK_INFO]) => {
                self.stated += messages_of(data);
                Ok(())
            }
            Some([BAG | INDEX]) => Ok(()),
            _ => Err(anyhow::anyhow!("a record of unknown kind")),
        };
        done.map_or_else(|why| out.damaged(why), ControlFlow::Continue)
    }

    fn connection(&mut self, head: Header<'_>, data: &[u8]) -> Result<()> {
        let found = head.u32("conn").zip(head.text("topic")).zip(Header(data).text("type"));
        let ((id, topic), kind) = found.context("a damaged connection")?;
        let new = (topic.to_owned(), kind.to_owned());
        let first = self.connections.entry(id).or_insert_with(|| new.clone());
        ensure!(*first == new, "the topic {topic} is described in two ways");
        Ok(())
    }

    fn message(&self, head: Header<'_>, bytes: &[u8], out: &mut Parts<'_>) -> ControlFlow<()> {
        let found = head.u32("conn").and_then(|id| self.connections.get(&id));
        match found {
            Some((topic, kind)) => out.message(topic, kind, bytes),
            None => out.damaged("a message of no known topic"),
        }
    }

    fn chunk(&mut self, mut records: &[u8], out: &mut Parts<'_>) -> ControlFlow<()> {
        while !records.is_empty() {
            let record = counted_of(&mut records).zip(counted_of(&mut records));
            // A chunk has no chunks.
            let record = record.filter(|(head, _)| Header(head).field("op") != Some(&[CHUNK]));
            let Some((head, data)) = record else {
                return out.damaged("a chunk with a damaged record");
            };
            self.record(Header(head), data, out)?;
        }
        ControlFlow::Continue(())
    }
}

/// The records of a chunk.
fn content<'a>(head: Header<'_>, data: &'a [u8]) -> Result<Cow<'a, [u8]>> {
    let (compression, length) =
        head.text("compression").zip(head.u32("size")).context("a damaged chunk")?;
    inflated(compression, data, length.into())
}

/// The number of messages of a chunk: its index has pairs of a connection and a number.
fn messages_of(data: &[u8]) -> u64 {
    let counts = data.chunks_exact(8).filter_map(|pair| pair.last_chunk());
    counts.map(|count| u64::from(u32::from_le_bytes(*count))).sum()
}
