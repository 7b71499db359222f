//! Output of the decoder.

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
    /// The CRC of the frame is wrong: drop every match since [`Event::Started`]. If this is frequent, bytes are being
    /// damaged or lost: check wiring and clock of the bus.
    Discarded,
}
