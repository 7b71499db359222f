//! Scan of all pages: what the flash holds.
//!
//! A page is *complete* once it holds an entry that is no copy: the copies that open a page come first.
//! Entries of an incomplete page are copies of entries elsewhere and count only if no other is intact.

use embedded_storage::nor_flash::NorFlash;

use super::entry::{DecodedHeader, HEADER, PerKind};
use super::flash_io::{EntryLocation, FlashIo};
use super::pages::to_u32;
use crate::codec::RecordKind;

/// Step of the sequence number where a page has no header: beyond all numbers in pages unreadable now.
const UNSEEN: u64 = 1 << 32;

/// Result of a scan; kept up to date by saves.
#[derive(Debug)]
pub(super) struct Scan<F: NorFlash> {
    /// Newest intact entry of each kind, tombstones included.
    pub(super) newest: PerKind<EntryLocation>,
    /// Start of the active page: the newest complete one.
    pub(super) active: Option<u32>,
    /// Address of the next entry in the active page.
    pub(super) end: u32,
    /// Newest sequence number of any header. Numbers wrap.
    pub(super) sequence: Option<u64>,
    /// Page erasures so far.
    pub(super) erasures: u32,
    /// Stretches that are neither erased nor an intact entry.
    pub(super) damaged: u32,
    /// Whether a header of another layout was found.
    pub(super) unsupported: bool,
    /// Whether a record found before is missing, or the page after the active one, which has a mark: nothing is
    /// written.
    pub(super) missing: bool,
    /// Page whose erasure did not read back: not tried again until the next start.
    pub(super) stuck: Option<u32>,
    /// Whether a read failed, and the last error.
    pub(super) unread: bool,
    pub(super) last_error: Option<F::Error>,
}

/// Result of the scan of one page.
#[derive(Debug)]
struct PageScan {
    newest: PerKind<EntryLocation>,
    /// Newest sequence number of an intact entry.
    sequence: Option<u64>,
    complete: bool,
    /// Whether there is any header.
    seen: bool,
    /// Whether there is a mark.
    succeeded: bool,
    /// Address of the next entry.
    end: u32,
}

impl<F: NorFlash> Scan<F> {
    const EMPTY: Self = Self {
        newest: PerKind::NONE,
        active: None,
        end: 0,
        sequence: None,
        erasures: 0,
        damaged: 0,
        unsupported: false,
        missing: false,
        stuck: None,
        unread: false,
        last_error: None,
    };

    /// Scans all pages but `except`. Entries are verified in full.
    #[inline(never)]
    pub(super) fn of(flash_io: &mut FlashIo<F>, except: Option<u32>) -> Self {
        let mut scan = Self::EMPTY;
        let mut in_complete = PerKind::NONE;
        let mut in_incomplete = PerKind::NONE;
        let mut active_sequence = None;
        let mut unseen = false;
        for page in flash_io.pages.starts().filter(|page| Some(*page) != except) {
            let found = scan.scan_page(flash_io, page);
            let newest = if found.complete { &mut in_complete } else { &mut in_incomplete };
            for kind in RecordKind::ALL {
                keep_newer(newest.of_mut(kind), found.newest.of(kind));
            }
            if found.complete && follows(found.sequence, active_sequence) {
                scan.active = Some(page);
                scan.end = found.end;
                scan.missing = found.succeeded;
                active_sequence = found.sequence;
            }
            unseen |= !found.seen;
        }
        if unseen {
            // A page may be unreadable for a while: records saved meanwhile are newer than all in it.
            scan.sequence = scan.sequence.map(|number| number.wrapping_add(UNSEEN));
        }
        for kind in RecordKind::ALL {
            *scan.newest.of_mut(kind) = in_complete.of(kind).or(in_incomplete.of(kind)).copied();
        }
        scan
    }

    /// Newest intact entry of a kind in one page; none in an incomplete page.
    #[inline(never)]
    pub(super) fn in_page(
        flash_io: &mut FlashIo<F>,
        page: u32,
        kind: RecordKind,
    ) -> Option<EntryLocation> {
        let mut scan = Self::EMPTY;
        let found = scan.scan_page(flash_io, page);
        found.newest.of(kind).filter(|_| found.complete).copied()
    }

    /// Steps from entry to entry; through damage from word to word.
    #[inline(never)]
    fn scan_page(&mut self, flash_io: &mut FlashIo<F>, page: u32) -> PageScan {
        let page_end = flash_io.pages.end_of(page);
        let written = flash_io.written_end(page);
        let mut found = PageScan {
            newest: PerKind::NONE,
            sequence: None,
            complete: false,
            seen: false,
            succeeded: false,
            end: written,
        };
        let mut address = page;
        let mut in_damage = false;
        while address < written {
            let place = self.header_at(flash_io, address, page_end);
            let intact = place.is_some_and(|place| self.is_intact(flash_io, &place));
            if let Some(place) = place {
                let header = place.header;
                let sequence = Some(header.sequence);
                found.seen = true;
                if follows(sequence, self.sequence) {
                    self.sequence = sequence;
                    self.erasures = header.erasures;
                }
                address = address.saturating_add(header.meta.bytes(&flash_io.pages));
                if intact {
                    keep_newer(found.newest.of_mut(header.meta.kind), Some(&place));
                    found.complete |= !header.copy;
                    if follows(sequence, found.sequence) {
                        found.sequence = sequence;
                    }
                }
            } else if flash_io.is_mark(address, page_end) {
                found.succeeded = true;
                in_damage = false;
                address = address.saturating_add(flash_io.mark_bytes());
                continue;
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
        self.unread = true;
        self.last_error = Some(error);
    }

    /// Newest entry of a kind, unless it is a tombstone.
    pub(super) fn record(&self, kind: RecordKind) -> Option<&EntryLocation> {
        self.newest.of(kind).filter(|place| !place.header.meta.removed)
    }
}

/// Keeps the entry with the newer sequence number, of equals the second.
fn keep_newer(kept: &mut Option<EntryLocation>, other: Option<&EntryLocation>) {
    let sequence = |place: &EntryLocation| place.header.sequence;
    if other.is_some() && follows(other.map(sequence), kept.as_ref().map(sequence)) {
        *kept = other.copied();
    }
}

/// Whether a sequence number is as new as another one, or newer. Numbers wrap; none is the oldest.
pub(super) fn follows(number: Option<u64>, other: Option<u64>) -> bool {
    match (number, other) {
        (Some(number), Some(other)) => number.wrapping_sub(other) <= u64::MAX / 2,
        (number, None) => number.is_some(),
        (None, Some(_)) => false,
    }
}
