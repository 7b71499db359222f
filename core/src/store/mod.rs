//! Records in NOR flash that survive a loss of power at any moment, torn writes and bit rot.
//!
//! A log of entries, each with a sequence number and CRCs, over two or more pages. A page is erased
//! right before it is used and opens with two copies of the newest record of each kind, so the pages
//! before it are spare and wear goes round all of them. Entries are appended until the page is full,
//! never onto anything that is not erased, and no word is written twice: flash with ECC will do. Each
//! entry is read back.
//!
//! After a cut every kind is found as it was before the save or as it is after. A record that rots is
//! replaced by its other copy, or by the one before it: a first record, and each of [`RecordKind::Factory`],
//! is written twice.
//!
//! Cost of a save, an entry being the payload and 28 bytes in whole words: a write for each 256 bytes of
//! it and a read for each 128. If the page is full: all pages are read, one is erased, and two entries
//! of each kind written. A load reads one entry, [`Store::open`] all pages. Buffers: the caller's, and
//! 256 bytes of stack.
//!
//! Endurance: 2 sectors of 128 kB, 10,000 cycles, 1 kB of factory data and 2 kB of state: 61 saves to an
//! erasure, 1.2 million in all. One a minute lasts 2.3 years, one in ten minutes 23 years.
//!
//! Why not `sequential-storage` 8.0.2: 28 of its calls to panics link at opt-level 3, a record must fit a
//! buffer, and of single rotten bytes in two pages 12 % lose a record and 39 % fail the next save.

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

use entry::EntryMeta;
use flash_io::FlashIo;
use pages::Pages;
use save::NewRecord;
use scan::Scan;

/// Attempts at a load: after the first, all pages are read again.
const LOADS: u8 = 3;

/// The flash, read through.
///
/// RAM: the driver and about 130 bytes.
#[derive(Debug)]
pub struct Store<F: NorFlash> {
    flash_io: FlashIo<F>,
    scan: Scan<F::Error>,
}

/// How the flash is used up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Wear {
    /// Erasures of pages so far. They take turns: this over `pages` for each.
    pub erasures: u32,
    /// Pages there are.
    pub pages: u32,
    /// Bytes until the next erasure. An entry takes 28 more than its payload, in whole words.
    pub room: u32,
    /// Stretches of flash found damaged when it was last read through: torn writes and erasures of
    /// pages that are not in use yet again count too.
    pub damaged: u32,
}

impl<F: NorFlash> Store<F> {
    /// Reads through a range of flash. Nothing is written; flash that holds no records, or cannot be read,
    /// is an empty store.
    ///
    /// * `range`: addresses, of whole pages, at least two. Nothing else is read or written.
    /// * `page`: bytes, of whole erase blocks; always the same for the same flash. Two of each record
    ///   must fit.
    ///
    /// Fails to compile for a flash whose read and write sizes are not powers of two up to 64.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn open(flash: F, range: Range<u32>, page: u32) -> Result<Self, OpenError<F::Error>> {
        let pages = Pages::try_new(&flash, range, page)?;
        let mut flash_io = FlashIo { flash, pages };
        let scan = Scan::of(&mut flash_io, None);
        if scan.foreign { Err(OpenError::UnsupportedLayout) } else { Ok(Self { flash_io, scan }) }
    }

    /// Erases all pages, [`RecordKind::Factory`] with them; arguments as of [`Store::open`].
    ///
    /// After a loss of power meanwhile old records may be found: do it again.
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

    /// The newest intact record of a kind; `None` if there never was one, or it was removed.
    ///
    /// * `buffer`: may hold anything after an error.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn load<'b>(
        &mut self,
        kind: RecordKind,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, LoadError<F::Error>> {
        for attempt in 0..LOADS {
            if attempt > 0 {
                self.read_through();
            }
            let Some(place) = self.scan.record(kind).copied() else {
                if self.scan.faults == 0 {
                    return Ok(None);
                }
                match self.scan.fault.take() {
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
        Err(LoadError::Unstable)
    }

    /// Keeps a record in the place of the one before of its kind. Takes at most three erasures, and one
    /// unless the flash fails.
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

    /// Lets no record of a kind be found until the next is saved. It stays in flash for a while.
    ///
    /// # Errors
    /// [`SaveError`].
    pub fn remove(&mut self, kind: RecordKind) -> Result<(), SaveError<F::Error>> {
        if self.scan.record(kind).is_none() {
            return Ok(());
        }
        self.put(&NewRecord { meta: EntryMeta { kind, removed: true, length: 0 }, payload: &[] })
    }

    /// How the flash is used up, as far as it has been read through.
    pub fn wear(&self) -> Wear {
        let Scan { erasures, damaged, .. } = self.scan;
        let pages = self.flash_io.pages.count();
        Wear { erasures, pages, room: self.room().map_or(0, |(_, bytes)| bytes), damaged }
    }

    /// Gives the driver back.
    pub fn close(self) -> F {
        self.flash_io.flash
    }

    /// Address and bytes of what is free in the page in use.
    fn room(&self) -> Option<(u32, u32)> {
        let base = self.scan.base?;
        let end = self.scan.end;
        Some((end, self.flash_io.pages.end_of(base).saturating_sub(end)))
    }

    /// Reads all pages again; counters never go back.
    #[inline(never)]
    fn read_through(&mut self) {
        let Scan { sequence, erasures, .. } = self.scan;
        self.scan = Scan::of(&mut self.flash_io, None);
        self.scan.sequence = self.scan.sequence.max(sequence);
        self.scan.erasures = self.scan.erasures.max(erasures);
    }
}
