//! Decoder: finds whole frames in a byte stream.

use super::counters::{Counters, count};
use super::event::Event;
use super::frame::{Disposition, FrameBody};
use super::header::{FrameHeader, HeaderError};
use super::held::Held;
use super::layout::HEADER_BYTES;
use super::sink::{FrameRefusal, FrameSink, Received};
use crate::batch::correspondence::Correspondence;

/// Frame decoder that resynchronises after damage. It takes the stream in pieces of any length. RAM: less than 160
/// bytes.
///
/// It buffers no frame: matches are handed out as they arrive, and [`Event::Finished`] verifies them. A frame takes as
/// many bytes as its header states. If its CRC is wrong, the search for the next header goes on at the 4 bytes that
/// should be the CRC. Damaged bytes therefore cost the frames they touch. A frame that has lost more than 4 bytes takes
/// the start of the next frame, and this frame is lost, too.
///
/// The work is bounded by the length of the stream, whatever its bytes are: each place where the magic is found takes one
/// check of a header. On a Cortex-M4F a repeated magic takes 12 to 16 times the instructions of a frame.
///
/// ```
/// use stereo_selfcal::link::{Decoder, Event};
/// # fn received() -> &'static [u8] { &[] }
/// let mut decoder = Decoder::new();
/// let mut bytes: &[u8] = received();
/// while let Some(event) = decoder.next(&mut bytes) {
///     match event {
///         Event::Started(header) => (),  // clear the buffer
///         Event::Match(m, track) => (),  // store it
///         Event::Finished(header) => (), // use the stored matches
///         Event::Discarded => (),        // drop the stored matches
///     }
/// }
/// ```
#[derive(Debug, Clone)]
pub struct Decoder {
    held: Held,
    frame: Option<FrameBody>,
    /// Sequence number of the last whole frame.
    last: Option<u32>,
    counters: Counters,
}

impl Decoder {
    /// Returns a decoder before its first frame.
    #[must_use]
    pub const fn new() -> Self {
        Self { held: Held::new(), frame: None, last: None, counters: Counters::ZERO }
    }

    /// Decodes up to the next event, returns the event, and removes the used bytes from the front of `bytes`.
    ///
    /// Returns `None` if `bytes` is used up. The work is bounded by the length of `bytes`; a record in one piece is
    /// decoded at once.
    pub fn next(&mut self, bytes: &mut &[u8]) -> Option<Event> {
        let mut event = None;
        self.take_records(bytes, 1, |c, track| event = Some(Event::Match(*c, track)));
        while event.is_none() && self.held.fill(bytes, self.wanted()) {
            event = self.take_held();
        }
        event
    }

    /// Feeds `bytes` into `sink` up to the end of the first whole frame, and removes the used bytes from the front.
    /// This is for a receiver with its own buffers. Returns `None` if `bytes` is used up before a frame is whole.
    ///
    /// # Errors
    /// [`FrameRefusal`], once per frame. Feed the rest of `bytes` next.
    pub fn feed(
        &mut self,
        bytes: &mut &[u8],
        sink: &mut impl FrameSink,
    ) -> Result<Option<Received>, FrameRefusal> {
        loop {
            self.take_records(bytes, usize::MAX, |c, track| sink.take(c, track));
            let Some(event) = self.next(bytes) else { return Ok(None) };
            match event {
                Event::Started(header) => sink.start(&header).inspect_err(|_| self.refuse())?,
                Event::Match(correspondence, track) => sink.take(&correspondence, track),
                Event::Discarded => sink.discard(),
                Event::Finished(header) => {
                    return Ok(Some(Received { header, taken: sink.finish() }));
                }
            }
        }
    }

    /// Drops the rest of the current frame, and counts the frame as refused. Call it when the sink refuses the frame;
    /// [`Self::feed`] does so itself.
    pub fn refuse(&mut self) {
        let accepted = |frame: &&mut FrameBody| frame.disposition == Disposition::Accepted;
        if let Some(frame) = self.frame.as_mut().filter(accepted) {
            frame.disposition = Disposition::Refused;
            count(&mut self.counters.refused);
        }
    }

    /// Returns the number of bytes to the end of the current frame, or between frames to the end of the next header; at
    /// least 1. A driver that reads no more than this reads no byte of the next frame, unless bytes were damaged or
    /// lost.
    #[must_use]
    pub fn bytes_wanted(&self) -> usize {
        let to_end = self.frame.as_ref().map_or(HEADER_BYTES, FrameBody::bytes_left);
        to_end.saturating_sub(self.held.len()).max(1)
    }

    /// Returns the statistics since the decoder was created.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Counts an overrun of the receiver, such as a DMA ring that wrapped or an overrun that a UART reports.
    pub fn note_overrun(&mut self) {
        count(&mut self.counters.overruns);
    }

    /// Returns the number of held bytes that can be decoded: a header, a record or the CRC of a frame.
    fn wanted(&self) -> usize {
        self.frame.as_ref().map_or(HEADER_BYTES, FrameBody::wanted)
    }

    /// Takes whole records of a frame where they are, without a copy of each match into an event.
    ///
    /// * `most`: largest number of records.
    #[inline(always)]
    fn take_records(
        &mut self,
        bytes: &mut &[u8],
        most: usize,
        take: impl FnMut(&Correspondence<f32>, u16),
    ) {
        if let Some(frame) = self.frame.as_mut().filter(|_| self.held.len() == 0) {
            frame.take_records(bytes, most, take);
        }
    }

    /// Takes the held bytes: a header, a record or the CRC of a frame.
    #[inline(never)]
    fn take_held(&mut self) -> Option<Event> {
        match &mut self.frame {
            None => self.take_header(),
            Some(frame) if frame.is_at_crc() => self.finish(),
            Some(frame) => {
                let mut event = None;
                let take = |c: &_, track| event = Some(Event::Match(*c, track));
                frame.take_records(&mut self.held.bytes(), 1, take);
                self.held.clear();
                event
            }
        }
    }

    /// Takes a header, or skips to the next place that may start one.
    fn take_header(&mut self) -> Option<Event> {
        let bytes = self.held.bytes().first_chunk()?;
        match FrameHeader::decode(bytes) {
            Ok(header) => {
                let repeated = self.last == Some(header.sequence);
                let disposition =
                    if repeated { Disposition::Repeated } else { Disposition::Accepted };
                self.frame = Some(FrameBody::new(header, bytes, disposition));
                self.held.clear();
                return (!repeated).then_some(Event::Started(header));
            }
            Err(HeaderError::Magic) => (),
            Err(HeaderError::Crc) => count(&mut self.counters.bad_header),
            Err(_) => count(&mut self.counters.unsupported),
        }
        let skipped = self.held.seek(1).try_into().unwrap_or(u32::MAX);
        self.counters.skipped_bytes = self.counters.skipped_bytes.saturating_add(skipped);
        None
    }

    /// Ends a frame whose CRC is held.
    fn finish(&mut self) -> Option<Event> {
        let frame = self.frame.take()?;
        if !frame.is_crc(self.held.bytes()) {
            count(&mut self.counters.bad_crc);
            // If the frame has lost up to 4 bytes, the next one starts within the held bytes.
            self.held.seek(0);
            let handed_out = frame.disposition == Disposition::Accepted;
            return handed_out.then_some(Event::Discarded);
        }
        self.held.clear();
        if frame.disposition == Disposition::Repeated {
            count(&mut self.counters.repeats);
            return None;
        }
        self.count_missing(&frame.header);
        if frame.disposition == Disposition::Refused {
            return None;
        }
        count(&mut self.counters.good);
        Some(Event::Finished(frame.header))
    }

    /// Stores the sequence number of a whole frame, and counts the overrun, the missing frames or the restart that the
    /// header shows.
    fn count_missing(&mut self, header: &FrameHeader) {
        if header.dropped_before {
            count(&mut self.counters.overruns);
        }
        let Some(last) = self.last.replace(header.sequence) else {
            return;
        };
        let ahead = header.sequence.wrapping_sub(last);
        if ahead > u32::MAX / 2 {
            count(&mut self.counters.restarts);
        } else {
            self.counters.gaps = self.counters.gaps.saturating_add(ahead.saturating_sub(1));
        }
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}
