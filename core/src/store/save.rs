//! A save: appended to the page in use, or with all that is live to a page that is erased for it.

use embedded_storage::nor_flash::NorFlash;

use super::Store;
use super::entry::{EntryMeta, Header, PerKind};
use super::error::SaveError;
use super::flash_io::{EntryLocation, FlashIo, Source};
use super::scan::Scan;
use crate::codec::RecordKind;

/// Pages that a save erases, at most.
const TURNOVERS: u32 = 3;
/// Pages that are looked at for one to erase: two may have the only record of a kind.
const CANDIDATES: u32 = TURNOVERS + 2;

/// A record to be written.
#[derive(Debug, Clone, Copy)]
pub(super) struct NewRecord<'a> {
    pub(super) meta: EntryMeta,
    pub(super) payload: &'a [u8],
}

impl<F: NorFlash> Store<F> {
    #[inline(never)]
    pub(super) fn put(&mut self, record: &NewRecord<'_>) -> Result<(), SaveError<F::Error>> {
        if self.scan.faults > 0 {
            // What could not be read may be readable now: nothing of it is to be erased.
            self.read_through();
        }
        self.check_room_for_two_of_each(record.meta)?;
        let mut kept = match self.room() {
            Some((address, bytes)) => self.append(record, address, bytes),
            None => Ok(false),
        };
        // Where a page does not take it, the next may.
        for skip in 0..TURNOVERS.min(self.flash_io.pages.count()) {
            if !matches!(kept, Ok(true)) {
                kept = self.turn_over(record, skip).map(|()| true);
            }
        }
        if !matches!(kept, Ok(true)) {
            self.read_through();
        }
        kept.map(|_| ())
    }

    fn check_room_for_two_of_each(&self, new: EntryMeta) -> Result<(), SaveError<F::Error>> {
        let FlashIo { pages, .. } = &self.flash_io;
        let mut needed = 0_u32;
        for kind in RecordKind::ALL {
            let live = self.scan.live.of(kind).as_ref().map(|place| place.header.meta);
            let meta = if kind == new.kind { Some(new) } else { live };
            let bytes = meta.map_or(0, |meta| meta.bytes(pages).saturating_mul(2));
            needed = needed.saturating_add(bytes);
        }
        let page = pages.size();
        if needed > page { Err(SaveError::TooLarge { needed, page }) } else { Ok(()) }
    }

    /// Puts a record into the page in use; whether there was room.
    #[inline(never)]
    fn append(
        &mut self,
        record: &NewRecord<'_>,
        mut address: u32,
        room: u32,
    ) -> Result<bool, SaveError<F::Error>> {
        let EntryMeta { kind, removed, .. } = record.meta;
        // One that has no other before it to fall back on is written twice.
        let has_one_before = self.scan.record(kind).is_some();
        let copies = if kind == RecordKind::State && has_one_before && !removed { 1 } else { 2 };
        if record.meta.bytes(&self.flash_io.pages).saturating_mul(copies) > room {
            return Ok(false);
        }
        let source = Source::Payload(record.payload);
        let place = self.lay(&mut address, record.meta, source, false, copies)?;
        *self.scan.live.of_mut(kind) = place;
        self.scan.end = address;
        Ok(true)
    }

    /// Erases a page and opens it with the newest records of the other kinds, then with this one.
    #[inline(never)]
    fn turn_over(&mut self, record: &NewRecord<'_>, skip: u32) -> Result<(), SaveError<F::Error>> {
        let kind = record.meta.kind;
        let (page, others) = self.page_to_erase(kind, skip).ok_or(SaveError::NoPageToErase)?;
        let page_end = self.flash_io.pages.end_of(page);
        self.scan.erasures = self.scan.erasures.saturating_add(1);
        self.flash_io.flash.erase(page, page_end).map_err(SaveError::Flash)?;
        let mut address = page;
        let mut live = PerKind { factory: None, state: None };
        for other in RecordKind::ALL.into_iter().filter(|other| *other != kind) {
            if let Some(place) = others.of(other) {
                let source = Source::Entry(place.address);
                *live.of_mut(other) = self.lay(&mut address, place.header.meta, source, true, 2)?;
            }
        }
        let source = Source::Payload(record.payload);
        *live.of_mut(kind) = self.lay(&mut address, record.meta, source, false, 2)?;
        self.scan.live = live;
        self.scan.base = Some(page);
        self.scan.end = address;
        Ok(())
    }

    /// The page after the one in use, or a later one, that has none of the newest records, and what those
    /// are. `skip`: how many such pages have failed.
    ///
    /// Where several faults left no such page: one without which an older record of each kind is left, and
    /// at worst none of `kind`.
    #[inline(never)]
    fn page_to_erase(
        &mut self,
        kind: RecordKind,
        mut skip: u32,
    ) -> Option<(u32, PerKind<Option<EntryLocation>>)> {
        for leniency in 0..3_u8 {
            let mut page = self.scan.base;
            for _ in 0..CANDIDATES.min(self.flash_io.pages.count()) {
                let candidate = self.flash_io.pages.after(page);
                page = Some(candidate);
                if page == self.scan.base {
                    continue;
                }
                let live = Scan::of(&mut self.flash_io, page).live;
                let spared = |other: RecordKind| match (self.scan.live.of(other), live.of(other)) {
                    (None, _) => true,
                    (Some(had), Some(left)) => leniency > 0 || had == left,
                    (Some(_), None) => leniency > 1 && other == kind,
                };
                if RecordKind::ALL.into_iter().all(spared) {
                    if skip == 0 {
                        return Some((candidate, live));
                    }
                    skip = skip.saturating_sub(1);
                }
            }
        }
        None
    }

    /// Writes an entry so many times; where the last of them is.
    fn lay(
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
            let header = Header { sequence, erasures, meta, copy };
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
