//! Store of a device: factory calibration and state in NOR flash, safe against a loss of power at any moment.
//!
//! - The *factory calibration* has two copies in a range of its own, which saves of the state never touch. A save
//!   erases, writes and reads back one copy, and then the other copy.
//! - The *state* is in slots of one size over two or more erase blocks. Each slot has a sequence number and a CRC; the
//!   newest intact record counts. The block with this record is never erased, and every write is read back. A state
//!   that is lost is reported and learnt again.
//!
//! Flash: any [`NorFlash`] with words of up to 512 bytes. Erased words may read as ones or as zeros (STM32L0), or fail
//! to be read until they are written (LPC55, with ECC). No word is written twice between two erasures, except behind a
//! torn record in flash that cannot be read before it is written.
//!
//! A loss of power may leave a word whose ECC is wrong. If the controller reports it by a bus fault or an interrupt, the
//! driver masks that report during a read, and returns an error for the read instead: the store then takes the record as
//! lost and goes on with another one. A driver that lets the fault reset the device resets it at every start.
//!
//! # Ranges
//!
//! Each range has two erase blocks; the state may have more. With sectors of 128 kB this is 512 kB in all. A slot of
//! the state takes 408 bytes, rounded up to whole words. A page of 2 kB holds 5 slots; a sector of 128 kB with words of
//! 32 bytes holds 315.
//!
//! # Wear
//!
//! Each slot of a block takes one save before the block is erased again. By default there is at most one save in ten
//! minutes. At this rate two pages of 2 kB with 10,000 cycles last 1.9 years, and two sectors of 128 kB last 120 years.
//! Four pages last twice as long as two. Even in flash that fails, a save of the state erases at most one block. If
//! erased words cannot be read, and the driver accepts a write only right after an erasure, each save erases a block.
//!
//! # Cost
//!
//! | call | reads | writes, erasures |
//! |---|---|---|
//! | [`Store::open`] | each slot behind the newest record of its block, and that record | none |
//! | [`Store::resume`], [`Store::load_factory`] | the record; without one, all slots, twice | none |
//! | [`Store::save`] | the next slot, twice | the slot; an erasure once a block |
//! | [`Store::save_factory`] | both copies, twice; three times without an intact copy | both copies, two erasures |
//!
//! Each read or write has at most 512 bytes, the largest slot. Without a record, a load also reads the first slots of
//! the blocks again, to distinguish empty flash from damage.
//!
//! # A new layout
//!
//! A firmware with another layout refuses both records with [`RestoreError::Layout`]. The state is learnt again, and
//! the next save replaces it. The factory calibration is not replaced: the firmware asks for it again
//! ([`Store::save_factory`]), or reads it with the version of this crate that wrote it.

mod policy;
mod ring;
mod slot;

use core::fmt::Debug;
use core::ops::Range;
use core::time::Duration;

use embedded_storage::nor_flash::NorFlash;
use thiserror::Error;

pub use policy::{SavePolicy, SaveReason};

use crate::calibrator::Calibrator;
use crate::calibrator::record;
use crate::error::RestoreError;
use crate::fusion::prior::Learned;
use crate::record::factory::{self, FactoryCalibration};
use crate::scalar::Scalar;
use ring::Ring;
use slot::Slot;

/// Why the store was not opened, or did not save. The records saved before remain. `E`: error of the flash driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StoreError<E: Debug> {
    /// A range does not consist of whole erase blocks, ends beyond the flash, overlaps the other range, has fewer than
    /// two erase blocks, or has erase blocks too small for a record. Correct the ranges.
    #[error("the ranges do not hold two whole erase blocks each within the flash")]
    Range,
    /// Read-back differs from what was written: the flash is worn out, locked or stuck. Try again later.
    #[error("read-back differs from what was written")]
    Verify,
    /// The driver failed. Try again later.
    #[error("flash: {0:?}")]
    Flash(E),
}

/// Factory calibration, state and save policy of a device. RAM: the driver and 224 bytes in `f32`.
///
/// ```
/// # use core::{fmt::Debug, time::Duration};
/// # use embedded_storage::nor_flash::NorFlash;
/// # use stereo_selfcal::{*, store::*};
/// # fn run<F: NorFlash<Error: Debug>>(flash: F, now: Duration) -> Option<()> {
/// // Four sectors of 128 kB.
/// let mut store = Store::open(flash, 0..0x4_0000, 0x4_0000..0x8_0000, SavePolicy::default()).ok()?;
///
/// // At start. Without a factory calibration the firmware decides what to do.
/// let factory = store.load_factory().ok()??;
/// let mut calibrator = Calibrator::<f32, 256>::new(Config::robust(), &factory);
/// let resumed = store.resume(&mut calibrator); // log it
///
/// // After each pair.
/// let saved = store.save_if_due(&calibrator, now); // log it
/// # Some(())
/// # }
/// ```
#[derive(Debug)]
pub struct Store<F, T: Scalar> {
    flash: F,
    factory: Ring,
    state: Ring,
    policy: SavePolicy<T>,
}

impl<F: NorFlash<Error: Debug>, T: Scalar> Store<F, T> {
    /// Opens a store, and finds the newest records. It writes nothing. Flash without records, or flash that cannot be
    /// read, is an empty store.
    ///
    /// * `factory`, `state`: address ranges, bytes, each of two or more whole erase blocks, constant over the life of
    ///   the device. The store accesses no other addresses. It uses only the first two blocks of `factory`.
    ///
    /// # Errors
    /// [`StoreError::Range`].
    pub fn open(
        mut flash: F,
        factory: Range<u32>,
        state: Range<u32>,
        policy: SavePolicy<T>,
    ) -> Result<Self, StoreError<F::Error>> {
        if !(factory.end <= state.start || state.end <= factory.start) {
            return Err(StoreError::Range);
        }
        let mut factory = Ring::try_new(&flash, &factory, factory::BYTES)?.of_two_copies();
        let mut state = Ring::try_new(&flash, &state, record::BYTES)?;
        factory.find(&mut flash);
        state.find(&mut flash);
        Ok(Self { flash, factory, state, policy })
    }

    /// Loads the factory calibration; returns `None` if no calibration was saved.
    ///
    /// # Errors
    /// [`RestoreError`]; [`RestoreError::Damaged`]: both copies are lost.
    #[inline(never)]
    pub fn load_factory(&mut self) -> Result<Option<FactoryCalibration<T>>, RestoreError> {
        let mut content = Slot::erased();
        let found = self.factory.load(&mut self.flash, &mut content)?;
        let record = found.then(|| content.record(factory::BYTES));
        record.map(|record| FactoryCalibration::from_record(record)).transpose()
    }

    /// Saves a factory calibration in place of the previous one, in production or on request. Afterwards a state that
    /// was learnt with other cameras or other factory extrinsics is refused. The second copy is erased only after the
    /// first one has been read back, so a loss of power leaves the old calibration or the new one.
    ///
    /// # Errors
    /// [`StoreError::Flash`], [`StoreError::Verify`]: the previous calibration remains, or one copy of the new one.
    pub fn save_factory(
        &mut self,
        factory: &FactoryCalibration<T>,
    ) -> Result<(), StoreError<F::Error>> {
        // `find` makes the first save write the damaged or older copy. If that save fails, the next call writes the
        // same copy again, and the intact copy is erased only after that.
        self.factory.find(&mut self.flash);
        let mut write = |record: &mut [u8]| factory.write(record);
        self.factory.save(&mut self.flash, &mut write)?;
        self.factory.save(&mut self.flash, &mut write)
    }

    /// Restores the newest state after a start; returns whether there was a state. If there was a state, restored or
    /// lost, the next save waits for the interval of the policy.
    ///
    /// # Errors
    /// [`RestoreError`]: the state is lost, and the calibrator is in the state after [`Calibrator::reset`].
    /// [`RestoreError::Damaged`] is also returned if the flash holds content but no intact record.
    pub fn resume<const N: usize>(
        &mut self,
        calibrator: &mut Calibrator<T, N>,
    ) -> Result<bool, RestoreError> {
        let mut read = |to: &mut _, learned: &mut _| self.read(to, learned);
        let restored = calibrator.restore_by(&mut read);
        if restored != Ok(false) {
            self.policy.restarted(calibrator);
        }
        restored
    }

    // Out of line, so that the record is on the stack only while it is read.
    #[inline(never)]
    fn read<const N: usize>(
        &mut self,
        calibrator: &mut Calibrator<T, N>,
        learned: &mut Learned<T>,
    ) -> Result<bool, RestoreError> {
        let mut content = Slot::erased();
        let found = self.state.load(&mut self.flash, &mut content)?;
        if found {
            calibrator.read(content.record(record::BYTES), learned)?;
        }
        Ok(found)
    }

    /// Saves the state if the policy says that a save is due, and then returns the reason of the save. Call it after
    /// each pair.
    ///
    /// * `now`: time since a fixed origin.
    ///
    /// # Errors
    /// [`StoreError`]; the save is due again after the interval.
    pub fn save_if_due<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
    ) -> Result<Option<SaveReason>, StoreError<F::Error>> {
        let reason = self.policy.due(calibrator, now);
        if reason.is_some() {
            self.save(calibrator, now)?;
        }
        Ok(reason)
    }

    /// Saves the state, due or not: before power is switched off on purpose, and after a [`Calibrator::reset`] that
    /// must survive the next start.
    ///
    /// # Errors
    /// [`StoreError`].
    #[inline(never)]
    pub fn save<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
    ) -> Result<(), StoreError<F::Error>> {
        calibrator.learn(&mut |learned| {
            let mut write = |record: &mut [u8]| calibrator.write_snapshot(learned, record);
            self.state.save(&mut self.flash, &mut write)
        })?;
        self.policy.saved(calibrator, now);
        Ok(())
    }

    /// Returns the driver.
    pub fn close(self) -> F {
        self.flash
    }
}
