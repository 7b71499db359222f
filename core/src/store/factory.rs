//! The factory calibration: two copies, each in its own half of a range that no state is written to.

use embedded_storage::nor_flash::NorFlash;

use super::StoreError;
use super::range::Blocks;
use super::slot;
use crate::record::factory::BYTES;

/// Addresses of the halves, and the end.
fn halves<F: NorFlash>(blocks: Blocks) -> [u32; 3] {
    [0, blocks.count / 2, blocks.count].map(|block| blocks.address::<F>(block))
}

/// Whether a half takes a record.
pub(super) fn fits<F: NorFlash>() -> bool {
    slot::bytes::<F>(BYTES) <= slot::to_u32(F::ERASE_SIZE)
}

/// Loads an intact copy, the newer one if both are intact; returns whether there is one.
pub(super) fn load<F: NorFlash>(flash: &mut F, blocks: Blocks, record: &mut [u8; BYTES]) -> bool {
    let [first, second, _] = halves::<F>(blocks);
    let newer = slot::check(flash, second, BYTES);
    let [one, other] =
        if newer > slot::check(flash, first, BYTES) { [second, first] } else { [first, second] };
    slot::load(flash, one, record).is_some() || slot::load(flash, other, record).is_some()
}

/// Whether the flash holds content but no intact copy.
pub(super) fn is_damaged<F: NorFlash>(flash: &mut F, blocks: Blocks) -> bool {
    let [first, second, _] = halves::<F>(blocks);
    ![first, second].into_iter().all(|half| slot::is_blank(flash, half, BYTES))
}

/// Saves both copies, first the damaged or older one. The other one is not touched before the first is read back, so a
/// loss of power leaves the old record or the new.
///
/// # Errors
/// [`StoreError`]
#[inline(never)]
pub(super) fn save<F: NorFlash>(
    flash: &mut F,
    blocks: Blocks,
    record: &[u8; BYTES],
) -> Result<(), StoreError<F::Error>> {
    let [first, second, end] = halves::<F>(blocks);
    let [old, older] = [first, second].map(|half| slot::check(flash, half, BYTES));
    let sequence = old.max(older).unwrap_or(0).saturating_add(1).min(u32::MAX - 1);
    let [first, second] = [(first, second), (second, end)];
    for (start, end) in if old > older { [second, first] } else { [first, second] } {
        flash.erase(start, end).map_err(StoreError::Flash)?;
        if !slot::write(flash, start, sequence, record).map_err(StoreError::Flash)? {
            return Err(StoreError::Verify);
        }
    }
    Ok(())
}
