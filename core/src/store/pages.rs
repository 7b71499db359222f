//! The range of flash as pages, and how finely it can be read and written. Bytes throughout.

use core::ops::Range;

use embedded_storage::nor_flash::{NorFlash, NorFlashError};

use super::error::OpenError;

/// The pages, each of one or more erase blocks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pages {
    range: Range<u32>,
    size: u32,
    /// What every access is a multiple of: a power of two.
    word: u32,
}

impl Pages {
    pub(super) fn try_new<F: NorFlash>(
        flash: &F,
        range: Range<u32>,
        size: u32,
    ) -> Result<Self, OpenError<F::Error>>
    where
        F::Error: NorFlashError,
    {
        const {
            let sizes = F::WRITE_SIZE.is_power_of_two() && F::READ_SIZE.is_power_of_two();
            assert!(sizes && F::WRITE_SIZE <= 64 && F::READ_SIZE <= 64, "powers of two up to 64");
            let word = if F::WRITE_SIZE > F::READ_SIZE { F::WRITE_SIZE } else { F::READ_SIZE };
            assert!(F::ERASE_SIZE.is_multiple_of(word), "erase blocks are of whole words");
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

    /// Start of every page.
    pub(super) fn starts(&self) -> impl Iterator<Item = u32> + use<> {
        let Self { range, size, .. } = self.clone();
        (0..self.count()).map(move |i| range.start.saturating_add(size.saturating_mul(i)))
    }

    /// The page after one; the first after the last, and if there is none before.
    pub(super) fn after(&self, page: Option<u32>) -> u32 {
        let next = page.map_or(self.range.start, |page| self.end_of(page));
        if next < self.range.end { next } else { self.range.start }
    }

    /// End of the page that starts at `page`.
    pub(super) fn end_of(&self, page: u32) -> u32 {
        page.saturating_add(self.size)
    }

    pub(super) fn count(&self) -> u32 {
        self.range.end.saturating_sub(self.range.start).checked_div(self.size).unwrap_or(0)
    }

    /// Bytes of a page.
    pub(super) fn size(&self) -> u32 {
        self.size
    }

    pub(super) fn word(&self) -> u32 {
        self.word
    }

    /// Up to whole words.
    pub(super) fn rounded(&self, bytes: u32) -> u32 {
        let last = self.word.saturating_sub(1);
        bytes.saturating_add(last) & !last
    }
}
