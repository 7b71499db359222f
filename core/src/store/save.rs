//! A save: appended to the page in use, or with all that is live to a page that is erased for it.

use embedded_storage::nor_flash::NorFlash;

use super::Store;
use super::entry::{Header, KINDS, Kind, PerKind, Subject};
use super::error::SaveError;
use super::medium::{Medium, Place, Source};
use super::survey::Survey;

/// Pages that a save erases, at most.
const TURNOVERS: u32 = 3;
/// Pages that are looked at for one to erase: two may have the only record of a kind.
const CANDIDATES: u32 = TURNOVERS + 2;

/// A record to be written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Record<'a> {
    pub(super) subject: Subject,
    pub(super) payload: &'a [u8],
}

impl<F: NorFlash> Store<F> {
    #[inline(never)]
    pub(super) fn put(&mut self, record: &Record<'_>) -> Result<(), SaveError<F::Error>> {
        if self.survey.faults > 0 {
            // What could not be read may be readable now: nothing of it is to be erased.
            self.read_through();
        }
        self.check_room_for_two_of_each(record.subject)?;
        let mut kept = match self.room() {
            Some((address, bytes)) => self.append(record, address, bytes),
            None => Ok(false),
        };
        // Where a page does not take it, the next may.
        for skip in 0..TURNOVERS.min(self.medium.pages.count()) {
            if !matches!(kept, Ok(true)) {
                kept = self.turn_over(record, skip).map(|()| true);
            }
        }
        if !matches!(kept, Ok(true)) {
            self.read_through();
        }
        kept.map(|_| ())
    }

    fn check_room_for_two_of_each(&self, new: Subject) -> Result<(), SaveError<F::Error>> {
        let Medium { pages, .. } = &self.medium;
        let mut needed = 0_u32;
        for kind in KINDS {
            let live = self.survey.live.of(kind).as_ref().map(|place| place.header.subject);
            let subject = if kind == new.kind { Some(new) } else { live };
            let bytes = subject.map_or(0, |subject| subject.bytes(pages).saturating_mul(2));
            needed = needed.saturating_add(bytes);
        }
        let page = pages.size();
        if needed > page { Err(SaveError::TooLarge { needed, page }) } else { Ok(()) }
    }

    /// Puts a record into the page in use; whether there was room.
    #[inline(never)]
    fn append(
        &mut self,
        record: &Record<'_>,
        mut address: u32,
        room: u32,
    ) -> Result<bool, SaveError<F::Error>> {
        let Subject { kind, forgotten, .. } = record.subject;
        // One that has no other before it to fall back on is written twice.
        let has_one_before = self.survey.record(kind).is_some();
        let copies = if kind == Kind::State && has_one_before && !forgotten { 1 } else { 2 };
        if record.subject.bytes(&self.medium.pages).saturating_mul(copies) > room {
            return Ok(false);
        }
        let source = Source::Payload(record.payload);
        let place = self.lay(&mut address, record.subject, source, false, copies)?;
        *self.survey.live.of_mut(kind) = place;
        self.survey.end = address;
        Ok(true)
    }

    /// Erases a page and opens it with the newest records of the other kinds, then with this one.
    #[inline(never)]
    fn turn_over(&mut self, record: &Record<'_>, skip: u32) -> Result<(), SaveError<F::Error>> {
        let kind = record.subject.kind;
        let (page, others) = self.page_to_erase(kind, skip).ok_or(SaveError::NoPageToErase)?;
        let page_end = self.medium.pages.end_of(page);
        self.survey.erasures = self.survey.erasures.saturating_add(1);
        self.medium.flash.erase(page, page_end).map_err(SaveError::Flash)?;
        let mut address = page;
        let mut live = PerKind { factory: None, state: None };
        for other in KINDS.into_iter().filter(|other| *other != kind) {
            if let Some(place) = others.of(other) {
                let source = Source::Entry(place.address);
                *live.of_mut(other) =
                    self.lay(&mut address, place.header.subject, source, true, 2)?;
            }
        }
        let source = Source::Payload(record.payload);
        *live.of_mut(kind) = self.lay(&mut address, record.subject, source, false, 2)?;
        self.survey.live = live;
        self.survey.base = Some(page);
        self.survey.end = address;
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
        kind: Kind,
        mut skip: u32,
    ) -> Option<(u32, PerKind<Option<Place>>)> {
        for leniency in 0..3_u8 {
            let mut page = self.survey.base;
            for _ in 0..CANDIDATES.min(self.medium.pages.count()) {
                let candidate = self.medium.pages.after(page);
                page = Some(candidate);
                if page == self.survey.base {
                    continue;
                }
                let live = Survey::of(&mut self.medium, page).live;
                let spared = |other: Kind| match (self.survey.live.of(other), live.of(other)) {
                    (None, _) => true,
                    (Some(had), Some(left)) => leniency > 0 || had == left,
                    (Some(_), None) => leniency > 1 && other == kind,
                };
                if KINDS.into_iter().all(spared) {
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
        subject: Subject,
        source: Source<'_>,
        copy: bool,
        copies: u32,
    ) -> Result<Option<Place>, SaveError<F::Error>> {
        let mut last = None;
        for _ in 0..copies {
            self.survey.sequence = self.survey.sequence.saturating_add(1);
            let Survey { sequence, erasures, .. } = self.survey;
            let header = Header { sequence, erasures, subject, copy };
            let place = Place { address: *address, header };
            if !self.medium.write_entry(&place, source).map_err(SaveError::Flash)? {
                return Err(SaveError::NotKept);
            }
            *address = address.saturating_add(subject.bytes(&self.medium.pages));
            last = Some(place);
        }
        Ok(last)
    }
}
