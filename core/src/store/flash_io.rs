//! Entries in flash: read, write, verify. At most 256 bytes per access.

use embedded_storage::nor_flash::NorFlash;

use super::entry::{DecodedHeader, EntryHeader, HEADER, TAIL};
use super::pages::{Pages, to_u32, to_usize};
use crate::codec::checksum;

/// Longest write, bytes: a page of common SPI flash.
const WRITE_CHUNK: usize = 256;
/// Longest read, bytes: smaller, because reads are made deeper in the stack.
const READ_CHUNK: usize = 128;
/// Attempts at a read: a bus error may be transient.
const ATTEMPTS: u8 = 3;

/// Content of a probe. It shares no bit with the first byte of a header: onto one it does not read back.
const PROBE: u8 = 0xac;

/// Mark after the last entry of a page: another page has been opened since.
const MARK: [u8; 8] = *b"SSC next";

/// What a page reads as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Look {
    /// Erased, or a line stuck at 1.
    Blank,
    /// Nothing but zeros, or nothing can be read.
    Silent,
    /// Zeros and ones.
    Content,
}

/// Buffer of one access. Aligned: drivers hand it to DMA, or write it word by word.
#[repr(align(8))]
struct Chunk<const N: usize>([u8; N]);

/// Header of an entry and its place in flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EntryLocation {
    pub(super) address: u32,
    pub(super) header: EntryHeader,
}

/// Source of the payload of a new entry.
#[derive(Debug, Clone, Copy)]
pub(super) enum Source<'a> {
    Payload(&'a [u8]),
    /// Address of an entry with the same metadata.
    Entry(u32),
}

/// Flash driver with the geometry of the store.
#[derive(Debug)]
pub(super) struct FlashIo<F> {
    pub(super) flash: F,
    pub(super) pages: Pages,
}

impl<F: NorFlash> FlashIo<F> {
    #[inline(never)]
    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<(), F::Error> {
        for _ in 1..ATTEMPTS {
            if self.flash.read(address, bytes).is_ok() {
                return Ok(());
            }
        }
        self.flash.read(address, bytes)
    }

    /// Header at an address; none if its entry does not end within the page.
    #[inline(never)]
    pub(super) fn header_at(
        &mut self,
        address: u32,
        page_end: u32,
    ) -> Result<DecodedHeader, F::Error> {
        let mut chunk = Chunk([0; 64]);
        let bytes = self.pages.rounded(to_u32(HEADER));
        let left = page_end.saturating_sub(address);
        let (true, Some(part)) = (bytes <= left, chunk.0.get_mut(..to_usize(bytes))) else {
            return Ok(DecodedHeader::None);
        };
        self.read(address, part)?;
        let header: Option<&[u8; HEADER]> = part.first_chunk();
        let found = header.map_or(DecodedHeader::None, |bytes| EntryHeader::decode(bytes, address));
        Ok(match found {
            DecodedHeader::Entry(header) if header.meta.bytes(&self.pages) > left => {
                DecodedHeader::None
            }
            found => found,
        })
    }

    /// End of the written part of a page, in whole words; an unreadable word counts as written.
    #[inline(never)]
    pub(super) fn written_end(&mut self, page: u32) -> u32 {
        let mut chunk = Chunk([0; READ_CHUNK]);
        let size = to_usize(self.pages.size());
        for offset in (0..size).step_by(READ_CHUNK).rev() {
            let bytes = READ_CHUNK.min(size.saturating_sub(offset));
            let Some(part) = chunk.0.get_mut(..bytes) else { continue };
            let address = page.saturating_add(to_u32(offset));
            let written = match self.read(address, part) {
                Ok(()) => part.iter().rposition(|byte| *byte != 0xff),
                Err(_) => part.len().checked_sub(1),
            };
            if let Some(last) = written {
                let bytes = to_u32(last).saturating_add(1);
                return address.saturating_add(self.pages.rounded(bytes));
            }
        }
        page
    }

    /// What a page reads as. Content that differs when read again is none.
    pub(super) fn look(&mut self, page: u32) -> Look {
        let (look, sum) = self.look_once(page);
        if look != Look::Content || self.look_once(page).1 == sum { look } else { Look::Silent }
    }

    /// What a page reads as, and its CRC.
    #[inline(never)]
    fn look_once(&mut self, page: u32) -> (Look, u32) {
        let mut chunk = Chunk([0; READ_CHUNK]);
        let size = to_usize(self.pages.size());
        let mut digest = checksum::begin();
        // Bits that were 0 somewhere, and that were 1.
        let (mut low, mut high) = (0, 0);
        let mut failed = false;
        for offset in (0..size).step_by(READ_CHUNK) {
            let bytes = READ_CHUNK.min(size.saturating_sub(offset));
            let Some(part) = chunk.0.get_mut(..bytes) else { continue };
            if self.read(page.saturating_add(to_u32(offset)), part).is_err() {
                failed = true;
                continue;
            }
            digest.update(part);
            low |= part.iter().fold(0, |low, byte| low | !byte);
            high |= part.iter().fold(0, |high, byte| high | byte);
        }
        let look = match (low, high) {
            (0, 0xff) if !failed => Look::Blank,
            (0, _) | (_, 0) => Look::Silent,
            _ => Look::Content,
        };
        (look, digest.value())
    }

    /// Whether a page has content that reads the same twice, or is erased and takes a word.
    pub(super) fn answers(&mut self, page: u32) -> bool {
        match self.look(page) {
            Look::Content => true,
            Look::Blank => self.probe(page),
            Look::Silent => false,
        }
    }

    /// Writes a word to the start of a page that reads as erased; whether it reads back, or is refused as a
    /// torn word is.
    ///
    /// If the page holds entries after all, the word damages the first one, which has a second copy.
    #[inline(never)]
    fn probe(&mut self, page: u32) -> bool {
        let mut chunk = Chunk([PROBE; 64]);
        let Some(word) = chunk.0.get_mut(..to_usize(self.pages.word())) else { return false };
        if self.flash.write(page, word).is_err() {
            return true;
        }
        word.fill(0);
        self.read(page, word).is_ok() && word.iter().all(|byte| *byte == PROBE)
    }

    /// Length of a mark, bytes.
    pub(super) fn mark_bytes(&self) -> u32 {
        self.pages.rounded(to_u32(MARK.len()))
    }

    /// Writes a mark, if there is room. Without it the next page is only less protected: errors are ignored.
    #[inline(never)]
    pub(super) fn write_mark(&mut self, address: u32, page_end: u32) {
        let mut chunk = Chunk([0xff; 64]);
        overlay(&mut chunk.0, 0, &MARK, 0);
        let bytes = self.mark_bytes();
        let fits = bytes <= page_end.saturating_sub(address);
        if let Some(part) = chunk.0.get(..to_usize(bytes)).filter(|_| fits) {
            let _ = self.flash.write(address, part);
        }
    }

    /// Whether a mark is at an address. An unreadable word is none.
    #[inline(never)]
    pub(super) fn is_mark(&mut self, address: u32, page_end: u32) -> bool {
        let mut chunk = Chunk([0; 64]);
        let bytes = self.mark_bytes();
        let part = chunk.0.get_mut(..to_usize(bytes)).unwrap_or_default();
        let fits = bytes <= page_end.saturating_sub(address);
        fits && self.read(address, part).is_ok() && part.starts_with(&MARK)
    }

    /// Reads the payload, as much as the buffer holds; whether the entry is intact.
    #[inline(never)]
    pub(super) fn read_entry(
        &mut self,
        place: &EntryLocation,
        payload: &mut [u8],
    ) -> Result<bool, F::Error> {
        let meta = place.header.meta;
        let total = to_usize(meta.bytes(&self.pages));
        let length = usize::from(meta.length);
        let mut digest = meta.digest();
        let mut tail = [0; TAIL];
        let mut chunk = Chunk([0; READ_CHUNK]);
        for offset in (0..total).step_by(READ_CHUNK) {
            let bytes = READ_CHUNK.min(total.saturating_sub(offset));
            let Some(part) = chunk.0.get_mut(..bytes) else { continue };
            self.read(place.address.saturating_add(to_u32(offset)), part)?;
            let within = |at: usize| at.saturating_sub(offset).min(bytes);
            let span = within(HEADER)..within(HEADER.saturating_add(length));
            digest.update(part.get(span).unwrap_or_default());
            overlay(payload, HEADER, part, offset);
            overlay(&mut tail, total.saturating_sub(TAIL), part, offset);
        }
        Ok(digest.value().to_le_bytes() == tail)
    }

    /// Writes an entry onto erased words and reads it back; whether it is intact.
    #[inline(never)]
    pub(super) fn write_entry(
        &mut self,
        place: &EntryLocation,
        source: Source<'_>,
    ) -> Result<bool, F::Error> {
        let EntryLocation { address, header } = *place;
        let total = to_usize(header.meta.bytes(&self.pages));
        let first = header.encode(address);
        let mut tail = [0; TAIL];
        if let Source::Payload(payload) = source {
            let mut digest = header.meta.digest();
            digest.update(payload);
            tail = digest.value().to_le_bytes();
        }
        let mut chunk = Chunk([0; WRITE_CHUNK]);
        for offset in (0..total).step_by(WRITE_CHUNK) {
            let Some(part) = chunk.0.get_mut(..WRITE_CHUNK.min(total.saturating_sub(offset)))
            else {
                continue;
            };
            match source {
                Source::Payload(payload) => {
                    part.fill(0xff);
                    overlay(part, offset, payload, HEADER);
                    overlay(part, offset, &tail, total.saturating_sub(TAIL));
                }
                // Copied with its CRC: a misread payload fails the verification.
                Source::Entry(from) => self.read(from.saturating_add(to_u32(offset)), part)?,
            }
            overlay(part, offset, &first, 0);
            self.flash.write(address.saturating_add(to_u32(offset)), part)?;
        }
        let page_end = address.saturating_add(to_u32(total));
        let found = self.header_at(address, page_end)? == DecodedHeader::Entry(header);
        Ok(found && self.read_entry(place, &mut [])?)
    }
}

/// Copies the overlap of two parts of one stream; `at`: offset of each part in the stream.
fn overlay(to: &mut [u8], to_at: usize, from: &[u8], from_at: usize) {
    let to = to.iter_mut().skip(from_at.saturating_sub(to_at));
    let from = from.iter().skip(to_at.saturating_sub(from_at));
    to.zip(from).for_each(|(to, from)| *to = *from);
}
