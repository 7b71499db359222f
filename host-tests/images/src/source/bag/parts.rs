//! Parts of a bag that its reader hands out: messages, and damaged parts.

use std::fmt::Display;
use std::ops::ControlFlow;

use crate::source::fields::Encoding;

/// Number of damaged parts of a file after which the rest counts as lost.
const MOST_DAMAGED: u64 = 1000;

/// A part of a bag.
#[derive(Debug)]
pub(super) enum Part<'a> {
    /// A message.
    Message {
        /// Its topic.
        topic: &'a str,
        /// Its type.
        kind: &'a str,
        /// Its content.
        bytes: &'a [u8],
        /// Layout of its content.
        encoding: Encoding,
    },
    /// A part that cannot be read, in words.
    Damaged(String),
}

/// Receiver of the parts; `Break` ends the reading.
pub(super) type TakePart<'a> = &'a mut dyn FnMut(Part<'_>) -> ControlFlow<()>;

/// The parts of one file, counted.
pub(super) struct Parts<'a> {
    name: String,
    encoding: Encoding,
    take: TakePart<'a>,
    messages: u64,
    damaged: u64,
    is_ended: bool,
}

impl<'a> Parts<'a> {
    /// * `name`: name of the file.
    pub(super) fn new(name: String, encoding: Encoding, take: TakePart<'a>) -> Self {
        Self { name, encoding, take, messages: 0, damaged: 0, is_ended: false }
    }

    /// Hands out a message.
    pub(super) fn message(&mut self, topic: &str, kind: &str, bytes: &[u8]) -> ControlFlow<()> {
        self.messages += 1;
        let flow = (self.take)(Part::Message { topic, kind, bytes, encoding: self.encoding });
        self.is_ended = flow.is_break();
        flow
    }

    /// Hands out a damaged part. `Break` too if the file has so many that the rest counts as lost.
    pub(super) fn damaged(&mut self, why: impl Display) -> ControlFlow<()> {
        self.damaged += 1;
        let is_last = self.damaged == MOST_DAMAGED;
        let lost = if is_last { ", and the rest counts as lost" } else { "" };
        let flow = (self.take)(Part::Damaged(format!("{}: {why:#}{lost}", self.name)));
        self.is_ended = flow.is_break();
        if is_last { ControlFlow::Break(()) } else { flow }
    }

    /// Compares the number of messages with the number that the file states. A difference without a damaged part is one.
    pub(super) fn stated(&mut self, stated: u64, advice: &str) -> ControlFlow<()> {
        let count = self.messages;
        if count == stated || self.damaged > 0 {
            return ControlFlow::Continue(());
        }
        self.damaged(format!("has {count} messages, where its index states {stated}{advice}"))
    }

    /// Whether the receiver ended the reading.
    pub(super) fn is_ended(&self) -> bool {
        self.is_ended
    }

    /// Number of messages handed out; `None` if a part is damaged.
    pub(super) fn whole(&self) -> Option<u64> {
        (self.damaged == 0).then_some(self.messages)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_damaged_parts_ends_and_says_so() {
        let mut said = Vec::new();
        let mut take = |part: Part<'_>| {
            let Part::Damaged(why) = part else { panic!("{part:?}") };
            said.push(why);
            ControlFlow::Continue(())
        };
        let mut parts = Parts::new("a.bag".into(), Encoding::Packed, &mut take);
        while parts.damaged("a wrong checksum").is_continue() {}
        assert!(!parts.is_ended() && parts.whole().is_none());
        assert_eq!(said.len() as u64, MOST_DAMAGED);
        assert_eq!(said[0], "a.bag: a wrong checksum");
        assert!(said.last().unwrap().contains("the rest counts as lost"));
    }
}
