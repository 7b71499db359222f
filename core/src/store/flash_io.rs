//! Entries in and out of flash, at most 256 bytes at a time.

use embedded_storage::nor_flash::NorFlash;

use super::entry::{DecodedHeader, HEADER, Header, TAIL};
use super::pages::Pages;

/// Most bytes that are written at a time: a page of common SPI flash.
const WRITTEN: usize = 256;
/// Most bytes that are read at a time: at the depth of the stack where it is read, less is more.
const READ: usize = 128;
/// Attempts at a read: a bus may fail once.
const ATTEMPTS: u8 = 3;

/// Bytes on their way. Aligned: drivers hand them to DMA, or write word by word.
#[repr(align(8))]
struct Chunk<const N: usize>([u8; N]);

/// An intact entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EntryLocation {
    pub(super) address: u32,
    pub(super) header: Header,
}

/// Where the payload of a new entry comes from.
#[derive(Debug, Clone, Copy)]
pub(super) enum Source<'a> {
    Payload(&'a [u8]),
    /// An entry of the same meta.
    Entry(u32),
}

/// Flash, as pages.
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

    /// What begins at an address; `Nothing` too if it does not end within its page.
    #[inline(never)]
    pub(super) fn found_at(
        &mut self,
        address: u32,
        page_end: u32,
    ) -> Result<DecodedHeader, F::Error> {
        let mut chunk = Chunk([0; 64]);
        let bytes = self.pages.rounded(24);
        let room = page_end.saturating_sub(address);
        let (true, Some(part)) = (bytes <= room, chunk.0.get_mut(..index(bytes))) else {
            return Ok(DecodedHeader::None);
        };
        self.read(address, part)?;
        let header: Option<&[u8; HEADER]> = part.first_chunk();
        let found = header.map_or(DecodedHeader::None, |bytes| Header::decode(bytes, address));
        Ok(match found {
            DecodedHeader::Entry(header) if header.meta.bytes(&self.pages) > room => {
                DecodedHeader::None
            }
            found => found,
        })
    }

    /// End of what is written in a page, in whole words: what cannot be read counts as written.
    #[inline(never)]
    pub(super) fn written_end(&mut self, page: u32) -> u32 {
        let mut chunk = Chunk([0; READ]);
        let size = index(self.pages.size());
        for offset in (0..size).step_by(READ).rev() {
            let bytes = READ.min(size.saturating_sub(offset));
            let Some(part) = chunk.0.get_mut(..bytes) else { continue };
            let address = page.saturating_add(offset32(offset));
            let written = match self.read(address, part) {
                Ok(()) => part.iter().rposition(|byte| *byte != 0xff),
                Err(_) => part.len().checked_sub(1),
            };
            if let Some(last) = written {
                let bytes = offset32(last).saturating_add(1);
                return address.saturating_add(self.pages.rounded(bytes));
            }
        }
        page
    }

    /// Copies the payload as far as it fits; whether the entry is intact.
    #[inline(never)]
    pub(super) fn read_entry(
        &mut self,
        place: &EntryLocation,
        payload: &mut [u8],
    ) -> Result<bool, F::Error> {
        let meta = place.header.meta;
        let total = index(meta.bytes(&self.pages));
        let length = usize::from(meta.length);
        let mut digest = meta.digest();
        let mut tail = [0; TAIL];
        let mut chunk = Chunk([0; READ]);
        for offset in (0..total).step_by(READ) {
            let bytes = READ.min(total.saturating_sub(offset));
            let Some(part) = chunk.0.get_mut(..bytes) else { continue };
            self.read(place.address.saturating_add(offset32(offset)), part)?;
            let within = |at: usize| at.saturating_sub(offset).min(bytes);
            let span = within(HEADER)..within(HEADER.saturating_add(length));
            digest.update(part.get(span).unwrap_or_default());
            overlay(payload, HEADER, part, offset);
            overlay(&mut tail, total.saturating_sub(TAIL), part, offset);
        }
        Ok(digest.finalize().to_le_bytes() == tail)
    }

    /// Writes an entry and reads it back; whether it is there. The words must be erased.
    #[inline(never)]
    pub(super) fn write_entry(
        &mut self,
        place: &EntryLocation,
        source: Source<'_>,
    ) -> Result<bool, F::Error> {
        let EntryLocation { address, header } = *place;
        let total = index(header.meta.bytes(&self.pages));
        let first = header.encoded(address);
        let mut tail = [0; TAIL];
        if let Source::Payload(payload) = source {
            let mut digest = header.meta.digest();
            digest.update(payload);
            tail = digest.finalize().to_le_bytes();
        }
        let mut chunk = Chunk([0; WRITTEN]);
        for offset in (0..total).step_by(WRITTEN) {
            let Some(part) = chunk.0.get_mut(..WRITTEN.min(total.saturating_sub(offset))) else {
                continue;
            };
            match source {
                Source::Payload(payload) => {
                    part.fill(0xff);
                    overlay(part, offset, payload, HEADER);
                    overlay(part, offset, &tail, total.saturating_sub(TAIL));
                }
                // With its CRC: a payload misread here does not pass for right.
                Source::Entry(from) => self.read(from.saturating_add(offset32(offset)), part)?,
            }
            overlay(part, offset, &first, 0);
            self.flash.write(address.saturating_add(offset32(offset)), part)?;
        }
        let page_end = address.saturating_add(offset32(total));
        let kept = self.found_at(address, page_end)? == DecodedHeader::Entry(header);
        Ok(kept && self.read_entry(place, &mut [])?)
    }
}

/// Copies what two parts of one stream have in common; `at` is where each begins in it.
fn overlay(to: &mut [u8], to_at: usize, from: &[u8], from_at: usize) {
    let to = to.iter_mut().skip(from_at.saturating_sub(to_at));
    let from = from.iter().skip(to_at.saturating_sub(from_at));
    to.zip(from).for_each(|(to, from)| *to = *from);
}

fn index(bytes: u32) -> usize {
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

/// An offset in a page.
fn offset32(offset: usize) -> u32 {
    u32::try_from(offset).unwrap_or(u32::MAX)
}
