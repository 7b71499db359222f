//! Output of the decoder.

use thiserror::Error;

use super::header::FrameHeader;
use crate::batch::correspondence::Correspondence;

/// One step of the decoder through the stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A frame starts.
    Started(FrameHeader),
    /// Correspondence of the frame, in px, and its track; 0 stands for a match without a track. Unverified until
    /// [`Event::Finished`].
    Match(Correspondence<f32>, u16),
    /// The frame is whole and its CRC correct: every match since [`Event::Started`] is as sent.
    Finished(FrameHeader),
    /// The frame is lost: drop every match since [`Event::Started`].
    Discarded(Damage),
}

/// Why a frame is lost. The decoder goes on with the next frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Damage {
    /// The CRC is wrong. If this is frequent, check wiring and clock of the bus.
    #[error("the CRC of the frame is wrong")]
    Crc,
    /// The next frame starts inside this one. If this is frequent, bytes are being lost.
    #[error("the next frame starts inside this one")]
    Truncated,
}

codes! { Damage { Crc = 1140, Truncated = 1141 } }
