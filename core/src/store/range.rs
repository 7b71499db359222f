//! Whole erase blocks of a flash.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

use super::StoreError;
use super::slot::to_u32;

/// Two erase blocks or more.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blocks {
    pub(super) start: u32,
    pub(super) count: u32,
}

impl Blocks {
    /// # Errors
    /// [`StoreError::Range`], [`StoreError::Alignment`].
    pub(super) fn try_new<F: NorFlash>(
        flash: &F,
        range: &Range<u32>,
    ) -> Result<Self, StoreError<F::Error>> {
        let length = range.end.checked_sub(range.start).ok_or(StoreError::Range)?;
        if range.end > to_u32(flash.capacity()) {
            return Err(StoreError::Range);
        }
        let block = to_u32(F::ERASE_SIZE);
        if !(length.is_multiple_of(block) && range.start.is_multiple_of(block)) {
            return Err(StoreError::Alignment);
        }
        let count = length.checked_div(block).unwrap_or(0);
        if count < 2 { Err(StoreError::Range) } else { Ok(Self { start: range.start, count }) }
    }

    pub(super) fn address<F: NorFlash>(self, block: u32) -> u32 {
        self.start.wrapping_add(block.wrapping_mul(to_u32(F::ERASE_SIZE)))
    }
}
