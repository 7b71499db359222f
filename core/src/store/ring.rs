//! Records of one kind, in slots of one size over several erase blocks. Only the newest intact record is used, and the
//! block with this record is never erased.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

use super::StoreError;
use super::slot::{self, Slot, to_u32};
use crate::error::RestoreError;

/// Number of attempts to write slots that look erased, before another block is erased.
const ATTEMPTS: u8 = 2;

/// Place of a record, and its sequence number.
#[derive(Debug, Clone, Copy)]
struct Newest {
    sequence: u32,
    block: u32,
    slot: u32,
}

/// Slots in a range.
#[derive(Debug)]
pub(super) struct Ring {
    start: u32,
    blocks: u32,
    /// Number of slots of a block.
    slots: u32,
    /// Length of a record, bytes.
    length: usize,
    newest: Option<Newest>,
    /// Block that is erased next.
    next: u32,
    /// Largest sequence number written. A record whose save failed may be intact, so its number is not used again.
    used: u32,
}

impl Ring {
    /// Returns a ring over the whole range; its records are not known yet.
    ///
    /// # Errors
    /// [`StoreError::Range`].
    pub(super) fn try_new<F: NorFlash>(
        flash: &F,
        range: &Range<u32>,
        length: usize,
    ) -> Result<Self, StoreError<F::Error>> {
        let (block, slot) = (to_u32(F::ERASE_SIZE), to_u32(slot::bytes::<F>(length)));
        let slots = block.checked_div(slot).unwrap_or(0);
        let blocks = range.end.saturating_sub(range.start).checked_div(block).unwrap_or(0);
        let is_whole = range.start.is_multiple_of(block) && range.end.is_multiple_of(block);
        if is_whole && range.end <= to_u32(flash.capacity()) && slots > 0 && blocks >= 2 {
            Ok(Self { start: range.start, blocks, slots, length, newest: None, next: 0, used: 0 })
        } else {
            Err(StoreError::Range)
        }
    }

    /// Returns the ring with only two slots, each in a block of its own, for two copies of one record. Two saves
    /// replace both copies.
    pub(super) fn of_two_copies(self) -> Self {
        Self { blocks: 2, slots: 1, ..self }
    }

    /// Searches the flash again for the newest record, whatever was known before. Without a record, the first block is
    /// erased next.
    pub(super) fn find<F: NorFlash>(&mut self, flash: &mut F) {
        self.next = 0;
        self.scan(flash);
    }

    /// Loads the newest record; returns whether there is one.
    ///
    /// # Errors
    /// [`RestoreError::Damaged`] if there is content in the first slot of a block, but no intact record.
    pub(super) fn load<F: NorFlash>(
        &mut self,
        flash: &mut F,
        content: &mut Slot,
    ) -> Result<bool, RestoreError> {
        // A fault during the last scan may have passed, or the newest record may have been lost since then.
        for _ in 0..2 {
            if let Some(Newest { sequence, block, slot }) = self.newest {
                let address = self.address::<F>(block, slot);
                if content.read(flash, address, self.length) == Some(sequence) {
                    return Ok(true);
                }
            }
            self.scan(flash);
        }
        let is_blank = |block| slot::is_blank(flash, self.address::<F>(block, 0), self.length);
        if (0..self.blocks).all(is_blank) { Ok(false) } else { Err(RestoreError::Damaged) }
    }

    /// Saves a record, with at most one erasure.
    ///
    /// * `write`: writes the record into its place in RAM.
    ///
    /// # Errors
    /// [`StoreError`]; the record saved before is still there.
    #[inline(never)]
    pub(super) fn save<F: NorFlash>(
        &mut self,
        flash: &mut F,
        write: &mut dyn FnMut(&mut [u8]),
    ) -> Result<(), StoreError<F::Error>> {
        if self.newest.is_none() {
            self.scan(flash);
        }
        // The largest number is not a sequence number, because erased flash may read as this number.
        let before = self.newest.map_or(0, |newest| newest.sequence).max(self.used);
        let sequence = before.saturating_add(1).min(u32::MAX - 1);
        self.used = sequence;
        let mut content = Slot::erased();
        write(content.record(self.length));
        content.seal(sequence, self.length);
        if self.append(flash, &content, sequence) {
            return Ok(());
        }
        let block = self.next;
        // Set before the attempt, so that a block that fails is not tried again at once.
        self.next = self.after(block);
        let start = self.address::<F>(block, 0);
        let end = start.saturating_add(to_u32(F::ERASE_SIZE));
        flash.erase(start, end).map_err(StoreError::Flash)?;
        if !content.write(flash, start, self.length).map_err(StoreError::Flash)? {
            return Err(StoreError::Verify);
        }
        self.found(Newest { sequence, block, slot: 0 });
        Ok(())
    }

    /// Writes a record behind the newest one; returns whether that was possible. The slots there are erased, or torn by
    /// a loss of power.
    fn append<F: NorFlash>(&mut self, flash: &mut F, content: &Slot, sequence: u32) -> bool {
        let Some(Newest { block, slot, .. }) = self.newest else { return false };
        let mut attempts = ATTEMPTS;
        for slot in slot.saturating_add(1)..self.slots {
            let address = self.address::<F>(block, slot);
            if attempts > 0 && slot::is_blank(flash, address, self.length) {
                if content.write(flash, address, self.length).is_ok_and(|is_there| is_there) {
                    self.found(Newest { sequence, block, slot });
                    return true;
                }
                attempts = attempts.saturating_sub(1);
            }
        }
        false
    }

    fn found(&mut self, newest: Newest) {
        self.newest = Some(newest);
        self.next = self.after(newest.block);
    }

    /// Finds the newest record: reads the last intact record of each block, and keeps the newest of these.
    #[inline(never)]
    fn scan<F: NorFlash>(&mut self, flash: &mut F) {
        let mut content = Slot::erased();
        self.newest = None;
        for block in 0..self.blocks {
            let last = (0..self.slots).rev().find_map(|slot| {
                let address = self.address::<F>(block, slot);
                let sequence = content.read(flash, address, self.length)?;
                Some(Newest { sequence, block, slot })
            });
            if let Some(last) = last
                && self.newest.is_none_or(|newest| last.sequence > newest.sequence)
            {
                self.found(last);
            }
        }
    }

    /// Returns the next block in turn that does not hold the newest record.
    fn after(&self, block: u32) -> u32 {
        let mut turn = (block.saturating_add(1)..self.blocks).chain(0..self.blocks);
        let holds = |block| self.newest.is_some_and(|newest| newest.block == block);
        turn.find(|block| !holds(*block)).unwrap_or(0)
    }

    fn address<F: NorFlash>(&self, block: u32, slot: u32) -> u32 {
        let slots = slot.wrapping_mul(to_u32(slot::bytes::<F>(self.length)));
        let blocks = block.wrapping_mul(to_u32(F::ERASE_SIZE));
        self.start.wrapping_add(blocks).wrapping_add(slots)
    }
}
