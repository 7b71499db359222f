//! What the decoder tells.

use thiserror::Error;

use super::header::FrameHeader;
use crate::correspondence::Correspondence;

/// What the decoder met in the stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A frame begins.
    Started(FrameHeader),
    /// A correspondence of the frame. Not to be believed before [`Event::Finished`].
    Match(Correspondence<f32>),
    /// The frame is whole: all that came since [`Event::Started`] is as it was sent.
    Finished(FrameHeader),
    /// The frame is lost: forget what came since [`Event::Started`].
    Discarded(Damage),
}

/// Why a frame is lost. The next one is found all the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Damage {
    /// Its CRC is wrong. Seen often: look at the wiring and the clock of the bus.
    #[error("the CRC of the frame is wrong")]
    Crc,
    /// The next frame began before this one ended. Seen often: bytes are being lost.
    #[error("the next frame began before this one ended")]
    Cut,
    /// Its CRC is right, but a record is not of version 1. Correct the sender.
    #[error("a record of the frame is not of version 1")]
    Content,
}

codes! { Damage { Crc = 1140, Cut = 1141, Content = 1142 } }
