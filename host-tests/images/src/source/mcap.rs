//! ROS 2 bags in MCAP.

use std::fs::File;
use std::io::BufReader;
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result};
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;

use super::bag::{End, Message};

/// Largest record or chunk that is read, bytes: a damaged length may ask for more memory than there is.
const MOST_BYTES: usize = 256 << 20;

/// Hands out all messages. A chunk is checked before its messages are handed out. An error if the file cannot be opened.
pub(super) fn messages(
    file: &Path,
    take: &mut dyn FnMut(Message<'_>) -> ControlFlow<()>,
) -> Result<End> {
    let opened = File::open(file).with_context(|| format!("cannot open {}", file.display()))?;
    let options = LinearReaderOptions::default()
        .with_record_length_limit(MOST_BYTES)
        .with_prevalidate_chunk_crcs(true);
    for message in MessageReader::new_with_options(BufReader::new(opened), options) {
        let message = match message {
            Ok(message) => message,
            Err(why) => return Ok(ControlFlow::Continue(Some(why.to_string()))),
        };
        let channel = &message.channel;
        let kind = channel.schema.as_ref().map_or("", |schema| &schema.name);
        if take((&channel.topic, kind, &message.data)).is_break() {
            return Ok(ControlFlow::Break(()));
        }
    }
    Ok(ControlFlow::Continue(None))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;
    use std::io::Cursor;

    use super::*;
    use mcap::records::MessageHeader;
    use mcap::{WriteOptions, Writer};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A bag of 20 messages in some chunks.
    fn bag() -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let options = WriteOptions::new().chunk_size(Some(1 << 12));
        let mut bag = Writer::with_options(&mut bytes, options).unwrap();
        let schema = bag.add_schema("sensor_msgs/msg/Image", "ros2msg", b"uint32 height").unwrap();
        let channel = bag.add_channel(schema, "/left", "cdr", &BTreeMap::new()).unwrap();
        for i in 0..20_u32 {
            let header = MessageHeader {
                channel_id: channel,
                sequence: i,
                log_time: i.into(),
                publish_time: i.into(),
            };
            let data: Vec<u8> = (0..999).map(|k| (k * k + i) as u8).collect();
            bag.write_to_known_channel(&header, &data).unwrap();
        }
        bag.finish().unwrap();
        drop(bag);
        bytes.into_inner()
    }

    /// Bytes with one kind of damage.
    fn damaged(whole: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
        let mut bytes = whole.to_vec();
        let at = rng.random_range(8..bytes.len() - 8);
        match rng.random_range(0..4) {
            0 => bytes[at..at + 8]
                .copy_from_slice(&(1_u64 << rng.random_range(20..63)).to_le_bytes()),
            1 => bytes[at] ^= 1 << rng.random_range(0..8),
            2 => bytes.truncate(at),
            _ => {
                let end = (at + rng.random_range(1..300)).min(bytes.len());
                rng.fill(&mut bytes[at..end]);
            }
        }
        bytes
    }

    #[test]
    fn a_damaged_bag_gives_whole_messages_or_a_named_error() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("flight.mcap");
        let whole = bag();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let read = |bytes: &[u8]| {
            fs::write(&file, bytes).unwrap();
            let mut count = 0;
            let end = messages(&file, &mut |(topic, _, data)| {
                count += u32::from(topic == "/left" && data.len() == 999);
                ControlFlow::Continue(())
            });
            (count, end.unwrap())
        };
        assert_eq!(read(&whole), (20, ControlFlow::Continue(None)));
        let mut named = 0;
        for _ in 0..400 {
            let (count, end) = read(&damaged(&whole, &mut rng));
            assert!(count <= 20);
            named += u32::from(matches!(end, ControlFlow::Continue(Some(why)) if !why.is_empty()));
        }
        // Damage of the index behind the messages is not read.
        assert!(named > 200, "{named}");
    }
}
