//! Save: appends to the active page, or opens another page with all newest records.
//!
//! Nothing is erased while a record found before is missing, and no page whose loss would lose a factory
//! record.

use embedded_storage::nor_flash::NorFlash;

use super::Store;
use super::entry::{EntryHeader, EntryMeta, PerKind};
use super::error::SaveError;
use super::flash_io::{EntryLocation, Look, Source};
use super::scan::{Scan, follows};
use crate::codec::RecordKind;

/// Largest number of pages that one save erases.
const MAX_ERASURES: u32 = 3;
/// Pages examined for one to erase: two more, which may hold the only record of a kind.
const CANDIDATES: u32 = MAX_ERASURES + 2;
/// Attempts at an erasure: a bit may rot before it is read back.
const ERASE_ATTEMPTS: u8 = 2;
/// Scans of a page for a factory record before the page is erased: reads may be disturbed.
const LOOKS: u8 = 3;

/// Sequence number to begin with where a page may hold records that cannot be read.
const BLIND: u64 = 1 << 62;

/// Record to be written.
#[derive(Debug, Clone, Copy)]
pub(super) struct NewRecord<'a> {
    pub(super) meta: EntryMeta,
    pub(super) payload: &'a [u8],
}

impl<F: NorFlash> Store<F> {
    #[inline(never)]
    pub(super) fn put(&mut self, record: &NewRecord<'_>) -> Result<(), SaveError<F::Error>> {
        let scan = &self.scan;
        if scan.unread || scan.missing || scan.active.is_none() {
            // Data that was unreadable may be readable now and must not be erased.
            self.rescan();
        }
        self.check_not_missing()?;
        self.check_fits_page(record.meta)?;
        self.heal(record);
        let appended = match self.free() {
            Some((address, bytes)) => self.append(record, address, bytes),
            None => Ok(false),
        };
        let saved = match appended {
            Ok(true) => return Ok(()),
            Ok(false) => self.turn_over(record),
            Err(first) => self.turn_over(record).map_err(|error| match error {
                SaveError::NoPageToErase => first,
                error => error,
            }),
        };
        if saved.is_err() {
            self.rescan();
        }
        saved
    }

    /// Copies newest records of other kinds to the active page, where a fault kept them elsewhere: the page that
    /// holds the only one can never be erased. Without room, or if it fails, they stay where they are.
    #[inline(never)]
    fn heal(&mut self, record: &NewRecord<'_>) {
        let Some((active, (mut address, free))) = self.scan.active.zip(self.free()) else { return };
        for kind in RecordKind::ALL.into_iter().filter(|kind| *kind != record.meta.kind) {
            let Some(place) = self.scan.newest.of(kind).copied() else { continue };
            let bytes = place.header.meta.bytes(&self.flash_io.pages).saturating_mul(2);
            if self.flash_io.pages.page_of(place.address) == active || bytes > free {
                continue;
            }
            // A record that reads badly for a moment is not replaced by an older one.
            if (0..LOOKS).any(|_| Scan::in_page(&mut self.flash_io, active, kind).is_some()) {
                continue;
            }
            self.scan.end = address.saturating_add(bytes);
            let source = Source::Entry(place.address);
            if let Ok(copy) = self.write_copies(&mut address, place.header.meta, source, true, 2) {
                *self.scan.newest.of_mut(kind) = copy;
            }
            return;
        }
    }

    /// Refuses while a record found before is missing, or the page opened last.
    fn check_not_missing(&mut self) -> Result<(), SaveError<F::Error>> {
        if !self.scan.missing {
            return Ok(());
        }
        Err(self.scan.last_error.take().map_or(SaveError::NoPageToErase, SaveError::Flash))
    }

    /// Checks that a page holds two entries of each kind.
    fn check_fits_page(&self, new: EntryMeta) -> Result<(), SaveError<F::Error>> {
        let pages = &self.flash_io.pages;
        let mut needed = 0_u32;
        for kind in RecordKind::ALL {
            let newest = self.scan.newest.of(kind).map(|place| place.header.meta);
            let meta = if kind == new.kind { Some(new) } else { newest };
            let bytes = meta.map_or(0, |meta| meta.bytes(pages).saturating_mul(2));
            needed = needed.saturating_add(bytes);
        }
        let page = pages.size();
        if needed > page { Err(SaveError::TooLarge { needed, page }) } else { Ok(()) }
    }

    /// Appends a record to the active page, which has `free` bytes; whether it fits.
    #[inline(never)]
    fn append(
        &mut self,
        record: &NewRecord<'_>,
        mut address: u32,
        free: u32,
    ) -> Result<bool, SaveError<F::Error>> {
        let EntryMeta { kind, removed, .. } = record.meta;
        // Two copies where no older record could replace a damaged one.
        let has_older = self.scan.record(kind).is_some();
        let copies = if kind == RecordKind::State && has_older && !removed { 1 } else { 2 };
        let bytes = record.meta.bytes(&self.flash_io.pages).saturating_mul(copies);
        if bytes > free {
            return Ok(false);
        }
        // Ahead of the write: its words are not written again, even if it fails.
        self.scan.end = address.saturating_add(bytes);
        let source = Source::Payload(record.payload);
        let place = self.write_copies(&mut address, record.meta, source, false, copies)?;
        *self.scan.newest.of_mut(kind) = place;
        Ok(true)
    }

    /// Opens the next page that can be erased. If one page fails, the next may work.
    #[inline(never)]
    fn turn_over(&mut self, record: &NewRecord<'_>) -> Result<(), SaveError<F::Error>> {
        let mut result = Err(SaveError::NoPageToErase);
        let mut tried = 0;
        for leniency in 0..3_u8 {
            self.rescan();
            self.check_not_missing()?;
            self.note_silent_pages();
            let mut page = self.scan.active;
            for _ in 0..CANDIDATES.min(self.flash_io.pages.count()) {
                let candidate = self.flash_io.pages.after(page);
                page = Some(candidate);
                if page == self.scan.stuck || tried == MAX_ERASURES {
                    continue;
                }
                let kind = record.meta.kind;
                // After a failure no records are given up: the same pages again.
                let leniency = if tried == 0 { leniency } else { 0 };
                let is_active = page == self.scan.active;
                if is_active && (leniency < 2 || kind == RecordKind::Factory) {
                    continue;
                }
                let Some(others) = self.without(candidate, kind, leniency) else { continue };
                // The active page, full of states, only where the other pages are taken by the factory record.
                if is_active && others.of(RecordKind::Factory).is_none() {
                    continue;
                }
                tried = tried.saturating_add(1);
                result = self.open_page(record, candidate, &others);
                if result.is_ok() || page == self.scan.stuck {
                    return result;
                }
            }
        }
        result
    }

    /// Erases a page, copies the newest records of the other kinds to it, and adds this record.
    #[inline(never)]
    fn open_page(
        &mut self,
        record: &NewRecord<'_>,
        page: u32,
        others: &PerKind<EntryLocation>,
    ) -> Result<(), SaveError<F::Error>> {
        let kind = record.meta.kind;
        self.erase(page)?;
        let mut address = page;
        let mut newest = PerKind::NONE;
        for other in RecordKind::ALL.into_iter().filter(|other| *other != kind) {
            if let Some(place) = others.of(other) {
                let source = Source::Entry(place.address);
                *newest.of_mut(other) =
                    self.write_copies(&mut address, place.header.meta, source, true, 2)?;
            }
        }
        let source = Source::Payload(record.payload);
        *newest.of_mut(kind) = self.write_copies(&mut address, record.meta, source, false, 2)?;
        if let Some(last) = self.scan.active.filter(|last| *last != page) {
            let end = self.scan.end;
            self.flash_io.write_mark(end, self.flash_io.pages.end_of(last));
        }
        self.scan.newest = newest;
        self.scan.active = Some(page);
        self.scan.end = address;
        Ok(())
    }

    /// Without an active page, any page that does not answer may hold the records: the sequence number, which is
    /// stored with the next record, says so from then on.
    #[inline(never)]
    fn note_silent_pages(&mut self) {
        let Self { flash_io, scan } = self;
        if scan.active.is_none() && flash_io.pages.starts().any(|page| !flash_io.answers(page)) {
            scan.sequence = Some(scan.sequence.unwrap_or(0).max(BLIND));
        }
    }

    /// Erases a page and reads it back. Where it may hold the only records, a page without content is erased
    /// only if it takes a word: it may be unreadable for a while.
    #[inline(never)]
    fn erase(&mut self, page: u32) -> Result<(), SaveError<F::Error>> {
        let Self { flash_io, scan } = self;
        let is_blind = scan.sequence.is_some_and(|number| number >= BLIND);
        let no_factory = scan.newest.of(RecordKind::Factory).is_none();
        if (scan.active.is_none() || is_blind && no_factory) && !flash_io.answers(page) {
            return Err(SaveError::VerifyFailed);
        }
        for _ in 0..ERASE_ATTEMPTS {
            self.scan.erasures = self.scan.erasures.saturating_add(1);
            let erased = flash_io.flash.erase(page, flash_io.pages.end_of(page));
            self.scan.stuck = Some(page);
            erased.map_err(SaveError::Flash)?;
            if flash_io.look(page) == Look::Blank {
                self.scan.stuck = None;
                return Ok(());
            }
        }
        Err(SaveError::VerifyFailed)
    }

    /// Newest records without a page; `None` if the page must not be erased, because it holds a newest record.
    ///
    /// * `leniency`: 1: an older record of the state may take its place; 2: the state may be lost if a new
    ///   one is saved. For faults that left no other page. A factory record is replaced only by another one.
    #[inline(never)]
    fn without(
        &mut self,
        page: u32,
        kind: RecordKind,
        leniency: u8,
    ) -> Option<PerKind<EntryLocation>> {
        let remaining = Scan::of(&mut self.flash_io, Some(page)).newest;
        let is_spared = |other| match (self.scan.newest.of(other), remaining.of(other)) {
            (None, _) => true,
            (newest, left) if newest == left => true,
            _ if other == RecordKind::Factory => false,
            (_, Some(_)) => leniency > 0,
            (_, None) => leniency > 1 && other == kind,
        };
        if !RecordKind::ALL.into_iter().all(is_spared) {
            return None;
        }
        let sequence = |place: &EntryLocation| place.header.sequence;
        let left = remaining.of(RecordKind::Factory).map(sequence);
        for _ in 0..LOOKS {
            let here = Scan::in_page(&mut self.flash_io, page, RecordKind::Factory);
            if here.is_some() && !follows(left, here.as_ref().map(sequence)) {
                return None;
            }
        }
        Some(remaining)
    }

    /// Writes `copies` of an entry from `address` on; place of the last.
    fn write_copies(
        &mut self,
        address: &mut u32,
        meta: EntryMeta,
        source: Source<'_>,
        copy: bool,
        copies: u32,
    ) -> Result<Option<EntryLocation>, SaveError<F::Error>> {
        let mut last = None;
        for _ in 0..copies {
            let sequence = self.scan.sequence.map_or(1, |sequence| sequence.wrapping_add(1));
            self.scan.sequence = Some(sequence);
            let header = EntryHeader { sequence, erasures: self.scan.erasures, meta, copy };
            let place = EntryLocation { address: *address, header };
            if !self.flash_io.write_entry(&place, source).map_err(SaveError::Flash)? {
                return Err(SaveError::VerifyFailed);
            }
            *address = address.saturating_add(meta.bytes(&self.flash_io.pages));
            last = Some(place);
        }
        Ok(last)
    }
}
