//! Decoder: finds whole frames in a byte stream.

use super::counters::{Counters, count};
use super::event::{Damage, Event};
use super::frame::{Disposition, FrameBody, Step};
use super::header::FrameHeader;
#[cfg(test)]
use super::layout::RECORD_BYTES;
use super::layout::{HEADER_BYTES, MAGIC};
use super::sink::{FrameRefusal, FrameSink, Received};
use super::window::{Taken, Window};
use crate::batch::correspondence::Correspondence;

/// Frame decoder that resynchronises after damage. It takes the stream in pieces of any length. RAM: less than 256
/// bytes.
///
/// It buffers no frame: matches are handed out as they arrive, and [`Event::Finished`] verifies them. Every byte, also
/// inside a frame, is tested as the start of a header; a header with a correct CRC ends the frame before it. Damage
/// therefore costs only the frames it touches.
///
/// The work is bounded by the length of the stream, whatever its bytes are. Each byte is read at most once as part of a
/// header and once as part of a frame; a byte of a whole header is read twice more. A test counts these reads. A byte
/// where a header may start takes more instructions than a byte of a frame. On a Cortex-M4F the factor is 4 to 8 for a
/// repeated magic, and 10 to 12 for repeated headers.
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
///         Event::Discarded(why) => (),   // drop the stored matches
///     }
/// }
/// ```
#[derive(Debug, Clone)]
pub struct Decoder {
    window: Window,
    frame: Option<FrameBody>,
    /// Number of leading bytes of the window that belong to a whole frame and do not count as skipped.
    received: usize,
    /// Sequence number of the last whole frame.
    last: Option<u32>,
    counters: Counters,
    /// Number of reads of single bytes; a byte that is read twice counts twice.
    #[cfg(test)]
    work: usize,
}

/// Counts the bytes that are read; in tests only.
macro_rules! work {
    ($decoder:ident, $bytes:expr) => {
        #[cfg(test)]
        {
            $decoder.work += $bytes;
        }
    };
}

impl Decoder {
    /// Returns a decoder before its first frame.
    #[must_use]
    pub const fn new() -> Self {
        let (window, counters) = (Window::new(), Counters::ZERO);
        Self {
            window,
            frame: None,
            received: 0,
            last: None,
            counters,
            #[cfg(test)]
            work: 0,
        }
    }

    /// Decodes up to the next event, returns the event, and removes the used bytes from the front of `bytes`.
    ///
    /// Returns `None` if `bytes` is used up. The work is bounded by the length of `bytes`; a record in one piece is
    /// decoded at once.
    pub fn next(&mut self, bytes: &mut &[u8]) -> Option<Event> {
        while self.window.is_header() || !bytes.is_empty() {
            let event = match self.take_record(bytes) {
                Some(Step::Match(c, track)) => Some(Event::Match(c, track)),
                Some(_) => None,
                None => self.take_some(bytes),
            };
            if event.is_some() {
                return event;
            }
        }
        None
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
        while self.window.is_header() || !bytes.is_empty() {
            self.take_records(bytes, usize::MAX, |c, track| sink.take(c, track));
            let Some(event) = self.take_some(bytes) else {
                continue;
            };
            match event {
                Event::Started(header) => sink.start(&header).inspect_err(|_| self.refuse())?,
                Event::Match(correspondence, track) => sink.take(&correspondence, track),
                Event::Discarded(_) => sink.discard(),
                Event::Finished(header) => {
                    return Ok(Some(Received { header, taken: sink.finish() }));
                }
            }
        }
        Ok(None)
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
        let to_header = HEADER_BYTES.saturating_sub(self.window.held());
        self.frame.as_ref().map_or(to_header, FrameBody::bytes_left).max(1)
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

    /// Skips to the next possible header between frames, and takes bytes until they complete a header or no begun
    /// header remains.
    fn search(&mut self, bytes: &mut &[u8]) {
        if self.window.is_empty() {
            let start = bytes.iter().position(|&byte| byte == MAGIC[0]).unwrap_or(bytes.len());
            *bytes = bytes.get(start..).unwrap_or_default();
            self.skip(start);
        }
        let before = self.window.held();
        let taken = self.window.take(bytes.iter().copied(), false);
        work!(self, taken.bytes);
        self.count_bad(taken);
        *bytes = bytes.get(taken.bytes..).unwrap_or_default();
        self.skip((before + taken.bytes).saturating_sub(self.window.held()));
    }

    fn count_bad(&mut self, taken: Taken) {
        let bad = &mut self.counters.bad_header;
        *bad = bad.saturating_add(taken.bad_headers);
    }

    /// Moves the window on from a header, and counts the bytes that leave the window.
    fn slide(&mut self) {
        self.window.slide();
        self.skip(HEADER_BYTES.saturating_sub(self.window.held()));
    }

    /// Counts bytes that left the window or never entered it.
    fn skip(&mut self, bytes: usize) {
        let skipped = bytes.saturating_sub(self.received);
        self.received = self.received.saturating_sub(bytes);
        let bytes = u32::try_from(skipped).unwrap_or(u32::MAX);
        self.counters.skipped_bytes = self.counters.skipped_bytes.saturating_add(bytes);
    }

    /// Takes the header that the window holds.
    #[inline(never)]
    fn take_header(&mut self) -> Option<Event> {
        // The header starts inside a frame: this call ends the frame, and the window keeps the header.
        if let Some(frame) = self.frame.take() {
            count(&mut self.counters.truncated);
            return frame.was_handed_out().then_some(Event::Discarded(Damage::Truncated));
        }
        // Two reads of each byte: the header is copied, and its bytes begin the CRC of the frame.
        work!(self, 2 * HEADER_BYTES);
        let bytes = self.window.bytes();
        match FrameHeader::decode_fields(&bytes) {
            Err(_) => {
                count(&mut self.counters.unsupported);
                self.slide();
                None
            }
            Ok(header) => {
                // The window keeps the last bytes of the header: if this frame is cut off, they may start the next one.
                self.window.slide();
                self.received = 0;
                let repeated = self.last == Some(header.sequence);
                let disposition =
                    if repeated { Disposition::Repeated } else { Disposition::Accepted };
                self.frame = Some(FrameBody::new(header, &bytes, disposition));
                (!repeated).then_some(Event::Started(header))
            }
        }
    }

    /// Takes the next record of a frame, if it is in one piece and holds no start of a header.
    #[inline(always)]
    fn take_record(&mut self, bytes: &mut &[u8]) -> Option<Step> {
        let (before, mut step) = (bytes.len(), Step::None);
        self.take_records(bytes, 1, |c, track| step = Step::Match(*c, track));
        (bytes.len() < before).then_some(step)
    }

    /// Takes records of a frame in one piece, up to the last record or to a record that may hold the start of a header.
    /// The loop avoids a copy of each match into an event.
    ///
    /// * `most`: largest number of records.
    #[inline(always)]
    fn take_records(
        &mut self,
        bytes: &mut &[u8],
        most: usize,
        take: impl FnMut(&Correspondence<f32>, u16),
    ) {
        let Some(frame) = self.frame.as_mut().filter(|_| self.window.is_empty()) else { return };
        #[cfg(test)]
        let before = bytes.len();
        frame.take_records(bytes, most, take);
        work!(self, before - bytes.len());
    }

    /// Takes a header, bytes of a frame, or bytes between frames.
    #[inline(never)]
    fn take_some(&mut self, bytes: &mut &[u8]) -> Option<Event> {
        if self.window.is_header() {
            return self.take_header();
        }
        if self.frame.is_some() {
            return self.take_bytes(bytes);
        }
        self.search(bytes);
        None
    }

    /// Takes bytes of a frame up to the end of the record or of the CRC, or until they complete a header.
    #[inline(never)]
    fn take_bytes(&mut self, bytes: &mut &[u8]) -> Option<Event> {
        let frame = self.frame.as_mut()?;
        let filled = frame.room().iter_mut().zip(*bytes).map(|(place, byte)| {
            *place = *byte;
            *byte
        });
        let taken = self.window.take(filled, true);
        *bytes = bytes.get(taken.bytes..).unwrap_or_default();
        let step = frame.take_filled(taken.bytes);
        work!(self, 2 * taken.bytes);
        self.count_bad(taken);
        match step {
            Step::None => None,
            Step::Match(c, track) => Some(Event::Match(c, track)),
            Step::End(whole) => self.finish(whole),
        }
    }

    fn finish(&mut self, whole: bool) -> Option<Event> {
        let frame = self.frame.take()?;
        // The window keeps the last bytes of this frame, because the next frame may start within them. This may happen
        // even if this frame is whole: its end may have been lost, and the next frame may begin with the same bytes.
        self.received = if whole { self.window.held() } else { 0 };
        if !whole {
            count(&mut self.counters.bad_crc);
            return frame.was_handed_out().then_some(Event::Discarded(Damage::Crc));
        }
        if frame.disposition == Disposition::Repeated {
            count(&mut self.counters.repeats);
            return None;
        }
        self.count_missing(&frame.header);
        match frame.disposition {
            Disposition::Accepted => {
                count(&mut self.counters.good);
                Some(Event::Finished(frame.header))
            }
            Disposition::Repeated | Disposition::Refused => None,
        }
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

#[cfg(test)]
mod tests {
    extern crate std;

    use super::super::crc::FrameCrc;
    use super::*;
    use std::vec::Vec;

    fn frame(sequence: u32, record: [u8; RECORD_BYTES], count: u16) -> Vec<u8> {
        let header = FrameHeader {
            timestamp_us: 0,
            sequence,
            count,
            image_size: [1920, 1200],
            grid_step: 256,
            fraction_bits: 8,
            pyramid_ratio: 77,
            dropped_before: false,
            more_found: false,
        };
        let header = header.encode().unwrap();
        let mut crc = FrameCrc::new(&header);
        (0..count).for_each(|_| crc.add(&record));
        let records = [record].repeat(count.into());
        [&header[..], records.as_flattened(), &crc.value().to_le_bytes()].concat()
    }

    /// Returns the number of bytes read per byte of a stream.
    fn work_per_byte(stream: &[u8]) -> f64 {
        let (mut decoder, mut bytes) = (Decoder::new(), stream);
        while decoder.next(&mut bytes).is_some() {}
        let [work, bytes] =
            [decoder.work, stream.len()].map(|n| f64::from(u32::try_from(n).unwrap()));
        work / bytes
    }

    #[test]
    fn no_stream_takes_more_than_four_times_the_work_of_frames() {
        let record = [7, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 0, 0];
        let frames: Vec<u8> = (0..20).flat_map(|k| frame(k, record, 250)).collect();
        let usual = work_per_byte(&frames);
        assert!(usual < 1.05, "{usual}");
        let magics = MAGIC.repeat(5000);
        let header = &frame(1, record, u16::MAX)[..HEADER_BYTES];
        let headers: Vec<u8> =
            (0..500).flat_map(|k| frame(k, record, 9)[..HEADER_BYTES].to_vec()).collect();
        let empty: Vec<u8> = (0..500).flat_map(|k| frame(k, record, 0)).collect();
        let nearly = [&MAGIC[..], &[1, 0, 8, 77]].concat().repeat(2000);
        let streams: [&[u8]; 9] = [
            &magics,
            &[header, &magics].concat(),
            &b"S".repeat(9000),
            &b"SC".repeat(9000),
            &[header, &b"SC".repeat(9000)].concat(),
            &nearly,
            &[header, &nearly].concat(),
            &headers,
            &empty,
        ];
        for (k, stream) in streams.iter().enumerate() {
            let work = work_per_byte(stream);
            assert!(work <= 4.0 * usual, "{k}: {work}");
        }
    }
}
