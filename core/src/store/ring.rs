//! The state: slots of one size over two or more erase blocks. The newest intact record counts, and the block that holds
//! it is never erased.

use embedded_storage::nor_flash::NorFlash;

use super::StoreError;
use super::range::Blocks;
use super::slot::{self, to_u32};
use crate::record::state::BYTES;

/// Attempts at slots that look erased, before another block is erased.
const ATTEMPTS: u8 = 2;

/// A record in its slot.
#[derive(Debug, Clone, Copy)]
struct Newest {
    sequence: u32,
    block: u32,
    slot: u32,
}

/// Slots in a range.
#[derive(Debug)]
pub(super) struct Ring {
    blocks: Blocks,
    newest: Option<Newest>,
    /// Block that is erased next.
    next: u32,
}

impl Ring {
    /// Finds the newest record. Flash without records, or unreadable, is an empty ring.
    pub(super) fn open<F: NorFlash>(flash: &mut F, blocks: Blocks) -> Self {
        let mut ring = Self { blocks, newest: None, next: 0 };
        ring.scan(flash);
        ring
    }

    /// Slots of an erase block.
    pub(super) fn slots<F: NorFlash>() -> u32 {
        to_u32(F::ERASE_SIZE).checked_div(slot::bytes::<F>(BYTES)).unwrap_or(0)
    }

    /// Loads the newest record; returns whether there is one.
    pub(super) fn load<F: NorFlash>(&mut self, flash: &mut F, record: &mut [u8; BYTES]) -> bool {
        for _ in 0..2 {
            let Some(Newest { sequence, block, slot }) = self.newest else { break };
            if slot::load(flash, self.address::<F>(block, slot), record) == Some(sequence) {
                return true;
            }
            self.scan(flash);
        }
        false
    }

    /// Whether a slot has content although no record is intact.
    pub(super) fn is_damaged<F: NorFlash>(&self, flash: &mut F) -> bool {
        let is_blank = |block| slot::is_blank(flash, self.address::<F>(block, 0), BYTES);
        self.newest.is_none() && !(0..self.blocks.count).all(is_blank)
    }

    /// Saves a record. At most one erasure.
    ///
    /// # Errors
    /// [`StoreError`]; the record saved before is still there.
    #[inline(never)]
    pub(super) fn save<F: NorFlash>(
        &mut self,
        flash: &mut F,
        record: &[u8; BYTES],
    ) -> Result<(), StoreError<F::Error>> {
        if self.newest.is_none() {
            // A fault at the last scan may have passed.
            self.scan(flash);
        }
        if self.append(flash, record) {
            return Ok(());
        }
        let block = self.next;
        // Before the attempt: a block that fails is not tried again at once.
        self.next = self.after(block);
        let start = self.address::<F>(block, 0);
        let end = start.saturating_add(to_u32(F::ERASE_SIZE));
        flash.erase(start, end).map_err(StoreError::Flash)?;
        if self.put(flash, block, 0, record).map_err(StoreError::Flash)? {
            Ok(())
        } else {
            Err(StoreError::Verify)
        }
    }

    /// Writes a record behind the newest one; returns whether that was possible. The slots there are erased, or torn by
    /// a loss of power.
    fn append<F: NorFlash>(&mut self, flash: &mut F, record: &[u8; BYTES]) -> bool {
        let Some(Newest { block, slot, .. }) = self.newest else { return false };
        let mut attempts = ATTEMPTS;
        for slot in slot.saturating_add(1)..Self::slots::<F>() {
            let address = self.address::<F>(block, slot);
            if attempts > 0 && slot::is_blank(flash, address, BYTES) {
                if self.put(flash, block, slot, record).is_ok_and(|is_there| is_there) {
                    return true;
                }
                attempts = attempts.saturating_sub(1);
            }
        }
        false
    }

    /// Writes a record and reads it back; returns whether it is there.
    fn put<F: NorFlash>(
        &mut self,
        flash: &mut F,
        block: u32,
        slot: u32,
        record: &[u8; BYTES],
    ) -> Result<bool, F::Error> {
        // Erased flash reads as the largest numbers, so they are no sequence numbers.
        let before = self.newest.map_or(0, |newest| newest.sequence);
        let sequence = before.saturating_add(1).min(u32::MAX - 1);
        let is_there = slot::write(flash, self.address::<F>(block, slot), sequence, record)?;
        if is_there {
            self.found(Newest { sequence, block, slot });
        }
        Ok(is_there)
    }

    fn found(&mut self, newest: Newest) {
        self.newest = Some(newest);
        self.next = self.after(newest.block);
    }

    /// Finds the newest record of all blocks: the last intact one of each.
    #[inline(never)]
    fn scan<F: NorFlash>(&mut self, flash: &mut F) {
        self.newest = None;
        for block in 0..self.blocks.count {
            let last = (0..Self::slots::<F>()).rev().find_map(|slot| {
                let sequence = slot::check(flash, self.address::<F>(block, slot), BYTES)?;
                Some(Newest { sequence, block, slot })
            });
            if let Some(last) = last
                && self.newest.is_none_or(|newest| last.sequence > newest.sequence)
            {
                self.found(last);
            }
        }
    }

    /// The next block in turn that does not hold the newest record.
    fn after(&self, block: u32) -> u32 {
        let turn = |block: u32| {
            let next = block.saturating_add(1);
            if next < self.blocks.count { next } else { 0 }
        };
        let next = turn(block);
        if self.newest.is_some_and(|newest| newest.block == next) { turn(next) } else { next }
    }

    fn address<F: NorFlash>(&self, block: u32, slot: u32) -> u32 {
        self.blocks.address::<F>(block).wrapping_add(slot.wrapping_mul(slot::bytes::<F>(BYTES)))
    }
}
