//! ROS 2 bags in MCAP.

use std::fs::File;
use std::io::BufReader;
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result};
use mcap::io::MessageReader;

use super::bag::{End, Message};

/// Hands out all messages. An error if the file cannot be opened.
pub(super) fn messages(
    file: &Path,
    take: &mut dyn FnMut(Message<'_>) -> ControlFlow<()>,
) -> Result<End> {
    let opened = File::open(file).with_context(|| format!("cannot open {}", file.display()))?;
    for message in MessageReader::new(BufReader::new(opened)) {
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
