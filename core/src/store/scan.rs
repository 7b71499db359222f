//! What is in flash: a scan of all pages.
//!
//! A page is *whole* once it has an entry that is no copy: the copies that open a page come first. What
//! a page that is not whole holds is elsewhere too, and counts only if nothing else does.

use embedded_storage::nor_flash::NorFlash;

use super::entry::{DecodedHeader, PerKind};
use super::flash_io::{EntryLocation, FlashIo};
use crate::codec::RecordKind;

/// What a scan found.
#[derive(Debug)]
pub(super) struct Scan<E> {
    /// Newest intact entry of each kind.
    pub(super) live: PerKind<Option<EntryLocation>>,
    /// The newest whole page.
    pub(super) base: Option<u32>,
    /// Where the next entry goes in it.
    pub(super) end: u32,
    /// Highest sequence number of any header.
    pub(super) sequence: u64,
    /// Erasures of pages so far.
    pub(super) erasures: u32,
    /// Stretches that are neither erased nor intact entries.
    pub(super) damaged: u32,
    /// Headers of another layout.
    pub(super) foreign: bool,
    /// Reads that failed, and why the last of them did.
    pub(super) faults: u32,
    pub(super) fault: Option<E>,
}

/// What a scan found in one page.
#[derive(Debug)]
struct PageScan {
    live: PerKind<Option<EntryLocation>>,
    newest: u64,
    whole: bool,
    end: u32,
}

impl<E> Scan<E> {
    const NOTHING: Self = Self {
        live: PerKind { factory: None, state: None },
        base: None,
        end: 0,
        sequence: 0,
        erasures: 0,
        damaged: 0,
        foreign: false,
        faults: 0,
        fault: None,
    };

    /// Reads all pages but `except`. Entries are checked in full.
    #[inline(never)]
    pub(super) fn of<F: NorFlash<Error = E>>(
        flash_io: &mut FlashIo<F>,
        except: Option<u32>,
    ) -> Self {
        let mut scan = Self::NOTHING;
        // Newest entries of pages that are whole, and of those that are not.
        let mut whole = PerKind { factory: None, state: None };
        let mut torn = whole;
        let mut newest_base = 0;
        for page in flash_io.pages.starts() {
            if Some(page) == except {
                continue;
            }
            let found = scan.page(flash_io, page);
            for kind in RecordKind::ALL {
                let best = if found.whole { whole.of_mut(kind) } else { torn.of_mut(kind) };
                *best = newer(*best, *found.live.of(kind));
            }
            if found.whole && (scan.base.is_none() || found.newest > newest_base) {
                scan.base = Some(page);
                scan.end = found.end;
                newest_base = found.newest;
            }
        }
        for kind in RecordKind::ALL {
            *scan.live.of_mut(kind) = whole.of(kind).or(*torn.of(kind));
        }
        scan
    }

    /// Steps from entry to entry, through what is damaged from word to word.
    #[inline(never)]
    fn page<F: NorFlash<Error = E>>(&mut self, flash_io: &mut FlashIo<F>, page: u32) -> PageScan {
        let page_end = flash_io.pages.end_of(page);
        let written = flash_io.written_end(page);
        let nothing = PerKind { factory: None, state: None };
        let mut found = PageScan { live: nothing, newest: 0, whole: false, end: written };
        let mut address = page;
        let mut within_damage = false;
        while address < written {
            let place = self.header(flash_io, address, page_end);
            let intact = place.is_some_and(|place| self.is_intact(flash_io, &place));
            if let Some(place) = place {
                let header = place.header;
                if header.sequence >= self.sequence {
                    self.sequence = header.sequence;
                    self.erasures = header.erasures;
                }
                address = address.saturating_add(header.meta.bytes(&flash_io.pages));
                if intact {
                    let best = found.live.of_mut(header.meta.kind);
                    *best = newer(*best, Some(place));
                    found.whole |= !header.copy;
                    found.newest = found.newest.max(header.sequence);
                }
            } else {
                address = address.saturating_add(flash_io.pages.word());
            }
            if !intact && (!within_damage || place.is_some()) {
                self.damaged = self.damaged.saturating_add(1);
            }
            within_damage = !intact;
        }
        // Of an entry that was cut off, the words after the last that can be told may be written too: up
        // to the length that its header says, or the rest of that header.
        let unseen = if within_damage { flash_io.pages.rounded(24) } else { 0 };
        found.end = written.max(address).saturating_add(unseen);
        found
    }

    fn header<F: NorFlash<Error = E>>(
        &mut self,
        flash_io: &mut FlashIo<F>,
        address: u32,
        page_end: u32,
    ) -> Option<EntryLocation> {
        match flash_io.found_at(address, page_end) {
            Ok(DecodedHeader::Entry(header)) => return Some(EntryLocation { address, header }),
            Ok(DecodedHeader::Unsupported) => self.foreign = true,
            Ok(DecodedHeader::None) => (),
            Err(error) => self.note(error),
        }
        None
    }

    fn is_intact<F: NorFlash<Error = E>>(
        &mut self,
        flash_io: &mut FlashIo<F>,
        place: &EntryLocation,
    ) -> bool {
        match flash_io.read_entry(place, &mut []) {
            Ok(intact) => intact,
            Err(error) => {
                self.note(error);
                false
            }
        }
    }

    fn note(&mut self, error: E) {
        self.faults = self.faults.saturating_add(1);
        self.fault = Some(error);
    }

    /// The newest entry of a kind, unless that kind was removed.
    pub(super) fn record(&self, kind: RecordKind) -> Option<&EntryLocation> {
        self.live.of(kind).as_ref().filter(|place| !place.header.meta.removed)
    }
}

/// The later one, of equals the second.
fn newer(a: Option<EntryLocation>, b: Option<EntryLocation>) -> Option<EntryLocation> {
    match (a, b) {
        (Some(a), Some(b)) if b.header.sequence < a.header.sequence => Some(a),
        (a, b) => b.or(a),
    }
}
