//! ROS 2 bags in MCAP (<https://mcap.dev/spec>).
//!
//! A record is an operation code of one byte, a length of eight and its body. Five kinds matter here, so they are read
//! here: the crate `mcap` allocates what a length states, and panics at a short attachment.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::content::{exactly, inflated};
use super::parts::Parts;
use crate::source::fields::Fields;

/// First and last bytes of a file.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Operation codes. Those between [`DATA_END`] and [`PRIVATE`] are not in use.
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const STATISTICS: u8 = 0x0b;
const DATA_END: u8 = 0x0f;
const PRIVATE: u8 = 0x80;

/// Length of the numbers before the content of a message: channel, sequence, two times.
const MESSAGE_HEAD: usize = 22;

/// Hands out all messages, and the damaged parts. A chunk is checked before its messages are handed out.
///
/// # Errors
/// If the file cannot be opened.
pub(super) fn messages(file: &Path, out: &mut Parts<'_>) -> Result<ControlFlow<()>> {
    let mut input = BufReader::new(File::open(file).context("cannot open")?);
    if !is_magic(&mut input) {
        return Ok(out.damaged("does not start as MCAP does"));
    }
    let mut bag = Records::default();
    loop {
        match next(&mut input) {
            Ok(Some((FOOTER, _))) => break,
            Ok(Some((code, body))) => {
                if bag.record(code, &body, out).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
            Ok(None) => {}
            Err(why) => return Ok(out.damaged(format!("the rest is lost: {why:#}"))),
        }
    }
    if !is_magic(&mut input) {
        return Ok(out.damaged("does not end as MCAP does"));
    }
    Ok(bag.stated.map_or(ControlFlow::Continue(()), |stated| out.stated(stated, "")))
}

fn is_magic(input: &mut BufReader<File>) -> bool {
    exactly(input, MAGIC.len() as u64).is_ok_and(|bytes| bytes == MAGIC)
}

/// The next record: code and body. `None` for a record that has no use here, and is not read.
fn next(input: &mut BufReader<File>) -> Result<Option<(u8, Vec<u8>)>> {
    let head = exactly(input, 9)?;
    let mut fields = Fields::packed(&head);
    let (code, length) = (fields.u8()?, fields.u64()?);
    ensure!((1..=DATA_END).contains(&code) || code >= PRIVATE, "a record of unknown kind");
    if matches!(code, FOOTER | SCHEMA | CHANNEL | MESSAGE | CHUNK | STATISTICS) {
        return Ok(Some((code, exactly(input, length)?)));
    }
    let far = i64::try_from(length).ok();
    let far = far.with_context(|| format!("a record states {length} bytes, so it is damaged"))?;
    input.seek_relative(far).context("cannot be read")?;
    Ok(None)
}

/// The records so far.
#[derive(Default)]
struct Records {
    /// Names of the types of messages.
    schemas: HashMap<u16, String>,
    /// Topic and type of each channel.
    channels: HashMap<u16, (String, String)>,
    /// Number of messages that the file states.
    stated: Option<u64>,
}

impl Records {
    fn record(&mut self, code: u8, body: &[u8], out: &mut Parts<'_>) -> ControlFlow<()> {
        let done = match code {
            SCHEMA => self.schema(body),
            CHANNEL => self.channel(body),
            MESSAGE => return self.message(body, out),
            CHUNK => return self.chunk(body, out),
            STATISTICS => Fields::packed(body).u64().map(|count| self.stated = Some(count)),
            _ => Ok(()),
        };
        done.map_or_else(|why| out.damaged(why), ControlFlow::Continue)
    }

    fn schema(&mut self, body: &[u8]) -> Result<()> {
        let mut fields = Fields::packed(body);
        self.schemas.insert(fields.u16()?, fields.text()?.to_owned());
        Ok(())
    }

    fn channel(&mut self, body: &[u8]) -> Result<()> {
        let mut fields = Fields::packed(body);
        let (id, schema, topic) = (fields.u16()?, fields.u16()?, fields.text()?.to_owned());
        let kind = self.schemas.get(&schema).cloned().unwrap_or_default();
        let channel = (topic, kind);
        let first = self.channels.entry(id).or_insert_with(|| channel.clone());
        ensure!(*first == channel, "the topic {} is described in two ways", channel.0);
        Ok(())
    }

    fn message(&self, body: &[u8], out: &mut Parts<'_>) -> ControlFlow<()> {
        let found = body.split_at_checked(MESSAGE_HEAD).and_then(|(head, bytes)| {
            let channel = Fields::packed(head).u16().ok()?;
            Some((self.channels.get(&channel)?, bytes))
        });
        match found {
            Some(((topic, kind), bytes)) => out.message(topic, kind, bytes),
            None => out.damaged("a message of no known topic"),
        }
    }

    fn chunk(&mut self, body: &[u8], out: &mut Parts<'_>) -> ControlFlow<()> {
        let records = match content(body) {
            Ok(records) => records,
            Err(why) => return out.damaged(why),
        };
        let mut rest = &records[..];
        while !rest.is_empty() {
            let Some((code, body, after)) = first_record(rest) else {
                return out.damaged("a chunk with a damaged record");
            };
            self.record(code, body, out)?;
            rest = after;
        }
        ControlFlow::Continue(())
    }
}

/// The records of a chunk.
fn content(body: &[u8]) -> Result<Cow<'_, [u8]>> {
    let mut fields = Fields::packed(body);
    let _times = [fields.u64()?, fields.u64()?];
    let (length, sum, compression) = (fields.u64()?, fields.u32()?, fields.text()?);
    let stored = usize::try_from(fields.u64()?).ok();
    let stored = stored.and_then(|stored| fields.rest().get(..stored));
    let records = inflated(compression, stored.context("a chunk that is cut short")?, length)?;
    // A sum of 0 stands for no sum.
    ensure!(sum == 0 || crc32fast::hash(&records) == sum, "a chunk with a wrong checksum");
    Ok(records)
}

/// The first record of a chunk, which has no chunks: code, body, and the records after it.
fn first_record(records: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let mut fields = Fields::packed(records);
    let (code, length) = (fields.u8().ok()?, fields.u64().ok()?);
    let (body, after) = fields.rest().split_at_checked(usize::try_from(length).ok()?)?;
    (code != CHUNK).then_some((code, body, after))
}
