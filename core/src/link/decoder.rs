//! Whole frames out of any stream of bytes.

use super::counters::{Counters, count};
use super::event::{Damage, Event};
use super::frame::{Disposition, Frame, Step};
use super::header::{FrameHeader, HeaderError, MAGIC};
use super::record::MatchRecord;
use super::window::Window;

/// Finds frames in bytes that come in pieces of any length; below 256 bytes of RAM.
///
/// No buffer of a frame: matches are handed out as they come, and [`Event::Finished`] says that they
/// were as sent. After damage of any kind at most the frames that it touched are lost: every byte, also
/// of a frame's body, is looked at as the start of a header, and a header with its CRC right ends what
/// came before.
///
/// ```
/// use stereo_selfcal::link::{Decoder, Event};
/// # fn received() -> &'static [u8] { &[] }
/// let mut decoder = Decoder::new();
/// let mut bytes: &[u8] = received();
/// while let Some(event) = decoder.next(&mut bytes) {
///     match event {
///         Event::Started(header) => (),    // make room
///         Event::Match(m) => (),           // keep it, do not use it
///         Event::Finished(header) => (),   // now use them
///         Event::Discarded(why) => (),     // forget them
///     }
/// }
/// ```
#[derive(Debug, Clone)]
pub struct Decoder {
    window: Window,
    frame: Option<Frame>,
    /// Bytes in the window that were of a whole frame.
    claimed: usize,
    /// Sequence number of the last whole frame.
    last: Option<u32>,
    counters: Counters,
}

impl Decoder {
    /// A decoder in search of its first frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            window: Window::new(),
            frame: None,
            claimed: 0,
            last: None,
            counters: Counters::NONE,
        }
    }

    /// Goes on to the next event, and takes what was used off the front of `bytes`.
    ///
    /// `None`: all of `bytes` is used. Work is bounded by their number; a record that lies in one piece
    /// is taken at once.
    pub fn next(&mut self, bytes: &mut &[u8]) -> Option<Event> {
        while self.window.full().is_some() || !bytes.is_empty() {
            let event = if let Some(header) = self.window.full() {
                let header = *header;
                self.meet(&header)
            } else if self.frame.is_some() {
                self.read(bytes)
            } else {
                self.search(bytes);
                None
            };
            if event.is_some() {
                return event;
            }
        }
        None
    }

    /// Hands out nothing more of the frame at hand: what it was to go into refuses it.
    pub fn refuse(&mut self) {
        if let Some(frame) =
            self.frame.as_mut().filter(|frame| frame.disposition == Disposition::Accepted)
        {
            frame.disposition = Disposition::Refused;
            count(&mut self.counters.refused);
        }
    }

    /// Bytes to the end of the frame at hand or, between frames, of the next header. A driver that asks
    /// for no more never holds bytes of another frame.
    #[must_use]
    pub fn bytes_wanted(&self) -> usize {
        let to_header = FrameHeader::BYTES.saturating_sub(self.window.held());
        self.frame.as_ref().map_or(to_header, Frame::bytes_left).max(1)
    }

    /// What the link has been through.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Counts an overrun on this side of the wire: a ring that was lapped, a UART that says so.
    pub fn note_overrun(&mut self) {
        count(&mut self.counters.overruns);
    }

    /// Between frames: on to where one may start.
    fn search(&mut self, bytes: &mut &[u8]) {
        if self.window.is_empty() {
            let start = bytes.iter().position(|&byte| byte == MAGIC[0]).unwrap_or(bytes.len());
            *bytes = bytes.get(start..).unwrap_or_default();
            self.skip(start);
        }
        if let Some(byte) = take_first(bytes) {
            let dropped = self.window.push(byte);
            self.skip(dropped.into());
        }
    }

    fn skip(&mut self, bytes: usize) {
        let of_a_frame = bytes.min(self.claimed);
        self.claimed = self.claimed.saturating_sub(bytes);
        let bytes = u32::try_from(bytes.saturating_sub(of_a_frame)).unwrap_or(u32::MAX);
        self.counters.skipped_bytes = self.counters.skipped_bytes.saturating_add(bytes);
    }

    /// Something starts as a header does.
    #[inline(never)]
    fn meet(&mut self, bytes: &[u8; FrameHeader::BYTES]) -> Option<Event> {
        match FrameHeader::decode(bytes) {
            Err(HeaderError::Crc | HeaderError::Magic) => {
                count(&mut self.counters.bad_header);
                let dropped = self.window.slide();
                if self.frame.is_none() {
                    self.skip(dropped.into());
                }
                None
            }
            // The window stays, and is met again without a frame.
            _ if self.frame.is_some() => {
                count(&mut self.counters.truncated);
                let known = self.frame.take().is_some_and(|frame| frame.is_known());
                known.then_some(Event::Discarded(Damage::Truncated))
            }
            Err(_) => {
                count(&mut self.counters.unsupported);
                let dropped = self.window.slide();
                self.skip(dropped.into());
                None
            }
            Ok(header) => {
                // The next frame may begin with the last byte, where this one is cut off right there.
                self.window.slide();
                self.claimed = 0;
                let seen = self.last == Some(header.sequence);
                let disposition = if seen { Disposition::Repeated } else { Disposition::Accepted };
                self.frame = Some(Frame::new(header, bytes, disposition));
                (!seen).then_some(Event::Started(header))
            }
        }
    }

    /// Inside a frame: one record, or one byte.
    #[inline(always)]
    fn read(&mut self, bytes: &mut &[u8]) -> Option<Event> {
        let frame = self.frame.as_mut()?;
        if self.window.is_empty()
            && frame.is_at_record()
            && let Some((record, rest)) = bytes.split_first_chunk::<{ MatchRecord::BYTES }>()
            && !may_start_header(record, rest)
        {
            *bytes = rest;
            return match frame.record(record) {
                Step::Match(c) => Some(Event::Match(c)),
                _ => None,
            };
        }
        self.read_byte(bytes)
    }

    #[inline(never)]
    fn read_byte(&mut self, bytes: &mut &[u8]) -> Option<Event> {
        let byte = take_first(bytes)?;
        self.window.push(byte);
        match self.frame.as_mut()?.push(byte) {
            Step::None => None,
            Step::Match(c) => Some(Event::Match(c)),
            Step::End(whole) => self.finish(whole),
        }
    }

    fn finish(&mut self, whole: bool) -> Option<Event> {
        let frame = self.frame.take()?;
        // The window stays: the next frame may have begun within the last bytes, also of one that is whole
        // because it was cut off where the next begins with the same.
        self.claimed = if whole { self.window.held() } else { 0 };
        if !whole {
            count(&mut self.counters.bad_crc);
            return frame.is_known().then_some(Event::Discarded(Damage::Crc));
        }
        if frame.disposition == Disposition::Repeated {
            count(&mut self.counters.repeats);
            return None;
        }
        self.note(&frame.header);
        match frame.disposition {
            Disposition::Accepted => {
                count(&mut self.counters.good);
                Some(Event::Finished(frame.header))
            }
            Disposition::Unsupported => {
                count(&mut self.counters.unsupported);
                Some(Event::Discarded(Damage::Unsupported))
            }
            Disposition::Repeated | Disposition::Refused => None,
        }
    }

    /// What a whole frame says of those before it.
    fn note(&mut self, header: &FrameHeader) {
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

fn take_first(bytes: &mut &[u8]) -> Option<u8> {
    let (&first, rest) = bytes.split_first()?;
    *bytes = rest;
    Some(first)
}

/// Whether a header may start within a record, as far as two of its bytes say.
///
/// * `rest`: what follows the record, as far as it has come.
#[inline(always)]
fn may_start_header(record: &[u8; MatchRecord::BYTES], rest: &[u8]) -> bool {
    // One record in twenty has the magic's first byte.
    has_first_byte(record) && has_first_two_bytes(record, rest)
}

/// Whether the magic's first byte is among them, four at a time.
#[inline(always)]
fn has_first_byte(record: &[u8; MatchRecord::BYTES]) -> bool {
    const ONES: u32 = u32::from_ne_bytes([1; 4]);
    const TOPS: u32 = u32::from_ne_bytes([0x80; 4]);
    const FIRST: u32 = u32::from_ne_bytes([MAGIC[0]; 4]);
    let (words, _) = record.as_chunks::<4>();
    let zero_byte = |word: u32| word.wrapping_sub(ONES) & !word & TOPS;
    words.iter().fold(0, |any, &word| any | zero_byte(u32::from_ne_bytes(word) ^ FIRST)) != 0
}

#[inline(never)]
fn has_first_two_bytes(record: &[u8; MatchRecord::BYTES], rest: &[u8]) -> bool {
    let next = record.iter().skip(1).map(Some).chain([rest.first()]);
    // What has not come yet may be anything.
    let second = |byte: Option<&u8>| byte.is_none_or(|&byte| byte == MAGIC[1]);
    record.iter().zip(next).any(|(&byte, next)| byte == MAGIC[0] && second(next))
}
