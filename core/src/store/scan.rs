//! Scan of all pages: what the flash holds.
//!
//! A page is *complete* once it holds an entry that is no copy: the copies that open a page come first.
//! Entries of an incomplete page are copies of entries elsewhere and count only if no other is intact.

use embedded_storage::nor_flash::NorFlash;

use super::entry::{DecodedHeader, HEADER, PerKind};
use super::flash_io::{EntryLocation, FlashIo};
use super::pages::to_u32;
use crate::codec::RecordKind;

/// Result of a scan; kept up to date by saves.
#[derive(Debug)]
pub(super) struct Scan<F: NorFlash> {
    /// Newest intact entry of each kind, tombstones included.
    pub(super) newest: PerKind<EntryLocation>,
    /// Start of the active page: the newest complete one.
    pub(super) active: Option<u32>,
    /// Address of the next entry in the active page.
    pub(super) end: u32,
    /// Highest sequence number of any header.
    pub(super) sequence: u64,
    /// Page erasures so far.
    pub(super) erasures: u32,
    /// Stretches that are neither erased nor an intact entry.
    pub(super) damaged: u32,
    /// Whether a header of another layout was found.
    pub(super) unsupported: bool,
    /// Number of reads that failed, and the last error.
    pub(super) read_errors: u32,
    pub(super) last_error: Option<F::Error>,
}

/// Result of the scan of one page.
#[derive(Debug)]
struct PageScan {
    newest: PerKind<EntryLocation>,
    /// Highest sequence number of an intact entry.
    sequence: u64,
    complete: bool,
    /// Address of the next entry.
    end: u32,
}

impl<F: NorFlash> Scan<F> {
    const EMPTY: Self = Self {
        newest: PerKind::NONE,
        active: None,
        end: 0,
        sequence: 0,
        erasures: 0,
        damaged: 0,
        unsupported: false,
        read_errors: 0,
        last_error: None,
    };

    /// Scans all pages but `except`. Entries are verified in full.
    #[inline(never)]
    pub(super) fn of(flash_io: &mut FlashIo<F>, except: Option<u32>) -> Self {
        let mut scan = Self::EMPTY;
        let mut in_complete = PerKind::NONE;
        let mut in_incomplete = PerKind::NONE;
        let mut active_sequence = 0;
        for page in flash_io.pages.starts().filter(|page| Some(*page) != except) {
            let found = scan.scan_page(flash_io, page);
            let newest = if found.complete { &mut in_complete } else { &mut in_incomplete };
            for kind in RecordKind::ALL {
                keep_newer(newest.of_mut(kind), found.newest.of(kind));
            }
            if found.complete && (scan.active.is_none() || found.sequence > active_sequence) {
                scan.active = Some(page);
                scan.end = found.end;
                active_sequence = found.sequence;
            }
        }
        for kind in RecordKind::ALL {
            *scan.newest.of_mut(kind) = in_complete.of(kind).or(in_incomplete.of(kind)).copied();
        }
        scan
    }

    /// Steps from entry to entry; through damage from word to word.
    #[inline(never)]
    fn scan_page(&mut self, flash_io: &mut FlashIo<F>, page: u32) -> PageScan {
        let page_end = flash_io.pages.end_of(page);
        let written = flash_io.written_end(page);
        let mut found =
            PageScan { newest: PerKind::NONE, sequence: 0, complete: false, end: written };
        let mut address = page;
        let mut in_damage = false;
        while address < written {
            let place = self.header_at(flash_io, address, page_end);
            let intact = place.is_some_and(|place| self.is_intact(flash_io, &place));
            if let Some(place) = place {
                let header = place.header;
                if header.sequence >= self.sequence {
                    self.sequence = header.sequence;
                    self.erasures = header.erasures;
                }
                address = address.saturating_add(header.meta.bytes(&flash_io.pages));
                if intact {
                    keep_newer(found.newest.of_mut(header.meta.kind), Some(&place));
                    found.complete |= !header.copy;
                    found.sequence = found.sequence.max(header.sequence);
                }
            } else {
                address = address.saturating_add(flash_io.pages.word());
            }
            if !intact && (!in_damage || place.is_some()) {
                self.damaged = self.damaged.saturating_add(1);
            }
            in_damage = !intact;
        }
        // A write cut off at the end may have left words that look erased: the rest of a header, or of the
        // entry up to the length in its header.
        let unseen = if in_damage { flash_io.pages.rounded(to_u32(HEADER)) } else { 0 };
        found.end = written.max(address).saturating_add(unseen);
        found
    }

    fn header_at(
        &mut self,
        flash_io: &mut FlashIo<F>,
        address: u32,
        page_end: u32,
    ) -> Option<EntryLocation> {
        match flash_io.header_at(address, page_end) {
            Ok(DecodedHeader::Entry(header)) => return Some(EntryLocation { address, header }),
            Ok(DecodedHeader::Unsupported) => self.unsupported = true,
            Ok(DecodedHeader::None) => (),
            Err(error) => self.count_error(error),
        }
        None
    }

    fn is_intact(&mut self, flash_io: &mut FlashIo<F>, place: &EntryLocation) -> bool {
        flash_io.read_entry(place, &mut []).unwrap_or_else(|error| {
            self.count_error(error);
            false
        })
    }

    fn count_error(&mut self, error: F::Error) {
        self.read_errors = self.read_errors.saturating_add(1);
        self.last_error = Some(error);
    }

    /// Newest entry of a kind, unless it is a tombstone.
    pub(super) fn record(&self, kind: RecordKind) -> Option<&EntryLocation> {
        self.newest.of(kind).filter(|place| !place.header.meta.removed)
    }
}

/// Keeps the entry with the higher sequence number, of equals the second.
fn keep_newer(kept: &mut Option<EntryLocation>, other: Option<&EntryLocation>) {
    let sequence = |place: &EntryLocation| place.header.sequence;
    if other.is_some() && other.map(sequence) >= kept.as_ref().map(sequence) {
        *kept = other.copied();
    }
}
