//! Save: appends to the active page, or opens another page with all newest records.

use embedded_storage::nor_flash::NorFlash;

use super::Store;
use super::entry::{EntryHeader, EntryMeta, PerKind};
use super::error::SaveError;
use super::flash_io::{EntryLocation, Source};
use super::scan::Scan;
use crate::codec::RecordKind;

/// Largest number of pages that one save erases.
const MAX_ERASURES: u32 = 3;
/// Pages examined for one to erase: two more, which may hold the only record of a kind.
const CANDIDATES: u32 = MAX_ERASURES + 2;

/// Record to be written.
#[derive(Debug, Clone, Copy)]
pub(super) struct NewRecord<'a> {
    pub(super) meta: EntryMeta,
    pub(super) payload: &'a [u8],
}

impl<F: NorFlash> Store<F> {
    #[inline(never)]
    pub(super) fn put(&mut self, record: &NewRecord<'_>) -> Result<(), SaveError<F::Error>> {
        if self.scan.read_errors > 0 {
            // Data that was unreadable may be readable now and must not be erased.
            self.rescan();
        }
        self.check_fits_page(record.meta)?;
        let mut saved = match self.free() {
            Some((address, bytes)) => self.append(record, address, bytes),
            None => Ok(false),
        };
        // If one page fails, the next may work.
        for skip in 0..MAX_ERASURES.min(self.flash_io.pages.count()) {
            if !matches!(saved, Ok(true)) {
                saved = self.open_page(record, skip).map(|()| true);
            }
        }
        if !matches!(saved, Ok(true)) {
            self.rescan();
        }
        saved.map(|_| ())
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
        if record.meta.bytes(&self.flash_io.pages).saturating_mul(copies) > free {
            return Ok(false);
        }
        let source = Source::Payload(record.payload);
        let place = self.write_copies(&mut address, record.meta, source, false, copies)?;
        *self.scan.newest.of_mut(kind) = place;
        self.scan.end = address;
        Ok(true)
    }

    /// Erases a page, copies the newest records of the other kinds to it, and adds this record.
    #[inline(never)]
    fn open_page(&mut self, record: &NewRecord<'_>, skip: u32) -> Result<(), SaveError<F::Error>> {
        let kind = record.meta.kind;
        let (page, others) = self.page_to_erase(kind, skip).ok_or(SaveError::NoPageToErase)?;
        let page_end = self.flash_io.pages.end_of(page);
        self.scan.erasures = self.scan.erasures.saturating_add(1);
        self.flash_io.flash.erase(page, page_end).map_err(SaveError::Flash)?;
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
        self.scan.newest = newest;
        self.scan.active = Some(page);
        self.scan.end = address;
        Ok(())
    }

    /// Next page after the active one that holds none of the newest records, and the newest records without it.
    ///
    /// If faults left no such page: a page without which an older record of each kind remains; at worst
    /// one without which no record of `kind` remains.
    ///
    /// * `skip`: number of such pages that have failed.
    #[inline(never)]
    fn page_to_erase(
        &mut self,
        kind: RecordKind,
        mut skip: u32,
    ) -> Option<(u32, PerKind<EntryLocation>)> {
        for leniency in 0..3_u8 {
            let mut page = self.scan.active;
            for _ in 0..CANDIDATES.min(self.flash_io.pages.count()) {
                let candidate = self.flash_io.pages.after(page);
                page = Some(candidate);
                if page == self.scan.active {
                    continue;
                }
                let remaining = Scan::of(&mut self.flash_io, page).newest;
                let spared = |other| match (self.scan.newest.of(other), remaining.of(other)) {
                    (None, _) => true,
                    (Some(newest), Some(left)) => leniency > 0 || newest == left,
                    (Some(_), None) => leniency > 1 && other == kind,
                };
                if RecordKind::ALL.into_iter().all(spared) {
                    if skip == 0 {
                        return Some((candidate, remaining));
                    }
                    skip = skip.saturating_sub(1);
                }
            }
        }
        None
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
            self.scan.sequence = self.scan.sequence.saturating_add(1);
            let Scan { sequence, erasures, .. } = self.scan;
            let header = EntryHeader { sequence, erasures, meta, copy };
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
