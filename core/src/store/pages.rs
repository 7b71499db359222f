//! Geometry of the flash range: pages and access granularity. Addresses and lengths in bytes.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

use super::error::OpenError;

/// Range of flash, divided into pages of one or more erase blocks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pages {
    range: Range<u32>,
    size: u32,
    /// Granularity of every access: a power of two.
    word: u32,
}

impl Pages {
    pub(super) fn try_new<F: NorFlash>(
        flash: &F,
        range: Range<u32>,
        size: u32,
    ) -> Result<Self, OpenError<F::Error>> {
        const {
            let sizes = F::WRITE_SIZE.is_power_of_two() && F::READ_SIZE.is_power_of_two();
            assert!(sizes && F::WRITE_SIZE <= 64 && F::READ_SIZE <= 64, "powers of two up to 64");
            let word = if F::WRITE_SIZE > F::READ_SIZE { F::WRITE_SIZE } else { F::READ_SIZE };
            assert!(F::ERASE_SIZE.is_multiple_of(word), "erase blocks are multiples of the word");
        }
        let word = u32::try_from(F::WRITE_SIZE.max(F::READ_SIZE)).unwrap_or(1);
        let erase = u32::try_from(F::ERASE_SIZE).map_err(|_| OpenError::Unaligned)?;
        let capacity = u32::try_from(flash.capacity()).unwrap_or(u32::MAX);
        let bytes = range.end.checked_sub(range.start).ok_or(OpenError::OutOfBounds)?;
        if range.end > capacity {
            return Err(OpenError::OutOfBounds);
        }
        if size == 0 || bytes / 2 < size {
            return Err(OpenError::TooFewPages);
        }
        let aligned = range.start.is_multiple_of(erase) && size.is_multiple_of(erase);
        if !aligned || !bytes.is_multiple_of(size) {
            return Err(OpenError::Unaligned);
        }
        Ok(Self { range, size, word })
    }

    /// Start address of every page.
    pub(super) fn starts(&self) -> impl Iterator<Item = u32> + use<> {
        let Self { range, size, .. } = self.clone();
        (0..self.count()).map(move |i| range.start.saturating_add(size.saturating_mul(i)))
    }

    /// Page after `page`, cyclic; the first page for `None`.
    pub(super) fn after(&self, page: Option<u32>) -> u32 {
        let next = page.map_or(self.range.start, |page| self.end_of(page));
        if next < self.range.end { next } else { self.range.start }
    }

    /// Start of the page that holds an address.
    pub(super) fn page_of(&self, address: u32) -> u32 {
        let offset = address.saturating_sub(self.range.start).checked_rem(self.size);
        address.saturating_sub(offset.unwrap_or(0))
    }

    /// End address of the page that starts at `page`.
    pub(super) fn end_of(&self, page: u32) -> u32 {
        page.saturating_add(self.size)
    }

    /// Number of pages.
    pub(super) fn count(&self) -> u32 {
        self.range.end.saturating_sub(self.range.start).checked_div(self.size).unwrap_or(0)
    }

    /// Page size.
    pub(super) fn size(&self) -> u32 {
        self.size
    }

    /// Access granularity.
    pub(super) fn word(&self) -> u32 {
        self.word
    }

    /// Rounds up to whole words.
    pub(super) fn rounded(&self, bytes: u32) -> u32 {
        let last = self.word.saturating_sub(1);
        bytes.saturating_add(last) & !last
    }
}

/// A length as an index.
pub(super) fn to_usize(bytes: u32) -> usize {
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

/// A length within a page.
pub(super) fn to_u32(bytes: usize) -> u32 {
    u32::try_from(bytes).unwrap_or(u32::MAX)
}
