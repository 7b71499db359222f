//! Power-fail-safe store of records in NOR flash.
//!
//! The store is a log of entries over two or more pages; each entry has a sequence number and CRCs. Entries are
//! appended to the active page until it is full. Then the next page in turn is erased, opened with two copies of the
//! newest record of each kind, and becomes the active page. Wear is spread evenly. Only erased words are written and no
//! word is written twice: flash with ECC is supported. Each entry is verified by reading it back.
//!
//! After a loss of power at any moment each kind is found as before the interrupted save or as after it. A
//! record damaged by bit rot is replaced by its second copy or by the record before it: a first record, and
//! each of [`RecordKind::Factory`], is written twice.
//!
//! Faults of the flash that stand for a while (reads that fail or return 00 or ff, of all pages or some; writes and
//! erasures without effect) lose no record. Nothing is erased while a record found before is missing. A page has a
//! mark once the next one is open: without that mark nothing is written. If no page of the store is recognised, a page
//! is erased only if its content reads the same twice, or if it is blank and takes a word; and if any page does not
//! answer so, sequence numbers continue from 2^62. From then on no page that does not answer is erased, restarts
//! included, until there is a factory record. An erasure is read back; after one that fails the save ends. Only another
//! factory record replaces a factory record. Pages whose faults have passed are taken back: a factory record that only
//! another page holds is copied to the active one, or the active one, full of states, is erased, where the factory
//! record leaves no other page. A store that cannot save any more is saved by [`Store::format`]: after a loss of power
//! in the very first saves this may be so.
//!
//! Cost of a save; an entry is the payload and 28 bytes, in whole words: one write for each 256 bytes of the entry
//! and one read for each 128. If the page is full: all pages are read, several times, one is erased, and two entries
//! of each kind are written. A load reads one entry, [`Store::open`] all pages. Buffers: the caller's, and 256 bytes
//! of stack.
//!
//! Endurance with 2 sectors of 128 kB, 10,000 cycles, 1 kB of factory data and 2 kB of state: 60 saves for
//! each erasure, 1.2 million in all: 2.3 years at one save a minute, 23 years at one in ten minutes.
//!
//! `sequential-storage` 8.0.2 was measured as an alternative: 28 calls to panics remain at opt-level 3, a record must
//! fit a buffer, and of single damaged bytes in two pages 12 % lose a record and 39 % fail the next save.

mod entry;
mod error;
mod flash_io;
mod pages;
mod persistence;
mod policy;
mod save;
mod scan;

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

pub use crate::codec::RecordKind;
pub use error::{LoadError, OpenError, PolicyError, SaveError};
pub use persistence::{PersistError, Persistence, ResumeError};
pub use policy::{SavePolicy, SaveReason};

use entry::{EntryMeta, PerKind};
use flash_io::{EntryLocation, FlashIo, Look};
use pages::Pages;
use save::NewRecord;
use scan::{Scan, follows};

/// Attempts at a load; each but the first scans all pages again.
const LOAD_ATTEMPTS: u8 = 3;

/// Records in a range of NOR flash.
///
/// RAM: the driver and 128 bytes.
#[derive(Debug)]
pub struct Store<F: NorFlash> {
    flash_io: FlashIo<F>,
    scan: Scan<F>,
}

/// Wear and fill level of the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Wear {
    /// Page erasures so far, of all pages; each page has had `erasures / pages`.
    pub erasures: u32,
    /// Number of pages.
    pub pages: u32,
    /// Free bytes until the next erasure, without those of a mark. An entry takes 28 bytes more than its payload, in
    /// whole words.
    pub free: u32,
    /// Damaged stretches at the last scan: bit rot and torn writes. Pages that are not erased, or erased
    /// in part, count until they are used.
    pub damaged: u32,
}

impl<F: NorFlash> Store<F> {
    /// Opens a store and scans its range; writes nothing. Flash without records, or unreadable, is an empty store.
    ///
    /// * `range`: addresses of at least two whole pages. The store accesses nothing else.
    /// * `page`: page size in bytes, a multiple of the erase block; constant over the life of the store.
    ///   It must hold two of each record.
    ///
    /// Read and write sizes of the flash must be powers of two up to 64; others fail to compile.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn open(flash: F, range: Range<u32>, page: u32) -> Result<Self, OpenError<F::Error>> {
        let pages = Pages::try_new(&flash, range, page)?;
        let mut flash_io = FlashIo { flash, pages };
        let scan = Scan::of(&mut flash_io, None);
        let unsupported = scan.unsupported;
        if unsupported { Err(OpenError::UnsupportedLayout) } else { Ok(Self { flash_io, scan }) }
    }

    /// Erases all pages, [`RecordKind::Factory`] too, and opens the store; arguments as in [`Store::open`].
    ///
    /// After a loss of power during the call old records may be found: call it again.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn format(flash: F, range: Range<u32>, page: u32) -> Result<Self, OpenError<F::Error>> {
        let pages = Pages::try_new(&flash, range.clone(), page)?;
        let mut flash_io = FlashIo { flash, pages };
        for page in flash_io.pages.starts() {
            let end = flash_io.pages.end_of(page);
            flash_io.flash.erase(page, end).map_err(OpenError::Flash)?;
        }
        Self::open(flash_io.flash, range, page)
    }

    /// Loads the newest intact record of a kind; `None` if none was saved, or it was removed. A bus stuck at
    /// ff reads as flash without records.
    ///
    /// * `buffer`: at least the length of the record; its content is undefined after an error.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn load<'b>(
        &mut self,
        kind: RecordKind,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, LoadError<F::Error>> {
        for attempt in 0..LOAD_ATTEMPTS {
            if attempt > 0 {
                self.rescan();
            }
            let Some(place) = self.scan.record(kind).copied() else {
                if !self.scan.unread {
                    // Zeros throughout: the bus is stuck.
                    let Self { flash_io, .. } = self;
                    let silent = flash_io.pages.starts().all(|p| flash_io.look(p) == Look::Silent);
                    return if silent { Err(LoadError::Unstable) } else { Ok(None) };
                }
                match self.scan.last_error.take() {
                    Some(error) if attempt > 0 => return Err(LoadError::Flash(error)),
                    _ => continue,
                }
            };
            let needed = usize::from(place.header.meta.length);
            let part = buffer.get_mut(..needed).ok_or(LoadError::BufferTooSmall { needed })?;
            if matches!(self.flash_io.read_entry(&place, part), Ok(true)) {
                return Ok(buffer.get(..needed));
            }
        }
        Err(self.scan.last_error.take().map_or(LoadError::Unstable, LoadError::Flash))
    }

    /// Saves a record in place of the previous one of its kind. At most one erasure; three if the flash fails.
    ///
    /// * `payload`: at most 65,535 bytes.
    ///
    /// # Errors
    /// [`SaveError`].
    pub fn save(&mut self, kind: RecordKind, payload: &[u8]) -> Result<(), SaveError<F::Error>> {
        let page = self.flash_io.pages.size();
        let needed = u32::try_from(payload.len()).unwrap_or(u32::MAX);
        let length = u16::try_from(needed).map_err(|_| SaveError::TooLarge { needed, page })?;
        self.put(&NewRecord { meta: EntryMeta { kind, removed: false, length }, payload })
    }

    /// Removes the record of a kind: nothing is found until the next save. Its bytes stay in flash until
    /// their page is erased.
    ///
    /// # Errors
    /// [`SaveError`].
    pub fn remove(&mut self, kind: RecordKind) -> Result<(), SaveError<F::Error>> {
        if self.scan.record(kind).is_none() {
            return Ok(());
        }
        self.put(&NewRecord { meta: EntryMeta { kind, removed: true, length: 0 }, payload: &[] })
    }

    /// Wear and fill level as of the last scan and the saves since.
    pub fn wear(&self) -> Wear {
        let Scan { erasures, damaged, .. } = self.scan;
        let pages = self.flash_io.pages.count();
        Wear { erasures, pages, free: self.free().map_or(0, |(_, bytes)| bytes), damaged }
    }

    /// Returns the driver.
    pub fn close(self) -> F {
        self.flash_io.flash
    }

    /// Whether there is a state, even a removed one, or a part that cannot be read.
    const fn may_hold_state(&self) -> bool {
        self.scan.unread || self.scan.newest.has_state()
    }

    /// Address and length of the free part of the active page.
    fn free(&self) -> Option<(u32, u32)> {
        let page_end = self.flash_io.pages.end_of(self.scan.active?);
        // Room for a mark remains.
        let end = page_end.saturating_sub(self.flash_io.mark_bytes());
        Some((self.scan.end, end.saturating_sub(self.scan.end)))
    }

    /// Scans all pages again; sequence number and erasures never decrease. If a record found before is
    /// missing, all that was known stays, and nothing is written until it is found.
    #[inline(never)]
    fn rescan(&mut self) {
        let mut scan = Scan::of(&mut self.flash_io, None);
        if self.is_missing(&scan.newest) {
            self.scan.missing = true;
            self.scan.unread = scan.unread;
            self.scan.last_error = scan.last_error;
            return;
        }
        if !follows(scan.sequence, self.scan.sequence) {
            scan.sequence = self.scan.sequence;
        }
        scan.erasures = scan.erasures.max(self.scan.erasures);
        scan.stuck = self.scan.stuck;
        self.scan = scan;
    }

    /// Whether a newest record is not found where its page reads as nothing, or none of its kind is.
    #[inline(never)]
    fn is_missing(&mut self, found: &PerKind<EntryLocation>) -> bool {
        let Self { flash_io, scan } = self;
        RecordKind::ALL.into_iter().any(|kind| match (scan.newest.of(kind), found.of(kind)) {
            (None, _) => false,
            (Some(_), None) => true,
            (Some(known), Some(found)) => {
                let [found, newest] = [found, known].map(|place| Some(place.header.sequence));
                let page = flash_io.pages.page_of(known.address);
                !follows(found, newest) && flash_io.look(page) != Look::Content
            }
        })
    }
}
