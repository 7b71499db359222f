//! Persistence of a calibrator: store and save policy together.

use core::fmt::Debug;
use core::time::Duration;

use embedded_storage::nor_flash::NorFlash;
use thiserror::Error;

use super::{LoadError, RecordKind, SaveError, SavePolicy, SaveReason, Store};
use crate::calibrator::Calibrator;
use crate::error::{RestoreError, SnapshotError};
use crate::scalar::Scalar;
use crate::snapshot::factory::FactoryCalibration;

/// Restores a calibrator at start and saves its state when the policy finds it due.
///
/// The caller lends a buffer to each call: [`Calibrator::SNAPSHOT_BYTES`] bytes, or [`FactoryCalibration::MAX_BYTES`].
///
/// ```
/// # use core::time::Duration;
/// # use embedded_storage::nor_flash::NorFlash;
/// # use stereo_selfcal::{*, store::*};
/// # fn run<F: NorFlash>(flash: F, now: Duration) -> Option<()> where F::Error: core::fmt::Debug {
/// // Two sectors of 128 kB.
/// let store = Store::open(flash, 0..0x4_0000, 0x2_0000).ok()?;
/// let mut persistence = Persistence::new(store, SavePolicy::<f32>::new());
/// let mut buffer = [0; Calibrator::<f32, 256>::SNAPSHOT_BYTES];
///
/// // At start. Without a factory calibration the firmware decides what to do.
/// let factory = persistence.load_factory(&mut buffer).ok()??;
/// let mut calibrator = Calibrator::<f32, 256>::new(Config::robust());
/// calibrator.set_cameras(factory.cameras);
/// calibrator.set_factory(factory.extrinsics);
/// let resumed = persistence.resume(&mut calibrator, &mut buffer); // log it
///
/// // After each pair.
/// let saved = persistence.save_if_due(&calibrator, now, &mut buffer); // log it
/// # Some(())
/// # }
/// ```
#[derive(Debug)]
pub struct Persistence<F: NorFlash, T: Scalar> {
    store: Store<F>,
    policy: SavePolicy<T>,
}

/// Why nothing was restored. The calibrator is unchanged: start without the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ResumeError<E: Debug> {
    /// The store could not load the record.
    #[error(transparent)]
    Load(LoadError<E>),
    /// The record does not suit this calibrator.
    #[error("the record in flash: {0}")]
    Record(RestoreError),
}

/// Why nothing was saved. The record saved before remains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PersistError<E: Debug> {
    /// No cameras are set, or the buffer is too small.
    #[error(transparent)]
    Snapshot(SnapshotError),
    /// The store could not save the record.
    #[error(transparent)]
    Save(SaveError<E>),
}

impl<F: NorFlash<Error: Debug>, T: Scalar> Persistence<F, T> {
    /// Persistence over an open store. If the store holds a state, or cannot be read, the first save that
    /// the policy finds due waits for the shortest interval.
    pub const fn new(store: Store<F>, mut policy: SavePolicy<T>) -> Self {
        if store.may_hold_state() {
            policy.wait();
        }
        Self { store, policy }
    }

    /// Loads the factory calibration; `None` if none was saved.
    ///
    /// # Errors
    /// [`ResumeError`].
    pub fn load_factory(
        &mut self,
        buffer: &mut [u8],
    ) -> Result<Option<FactoryCalibration<T>>, ResumeError<F::Error>> {
        let record = self.store.load(RecordKind::Factory, buffer).map_err(ResumeError::Load)?;
        record.map(FactoryCalibration::from_record).transpose().map_err(ResumeError::Record)
    }

    /// Saves a factory calibration in place of the previous one. A state learnt from the previous one can
    /// no longer be restored.
    ///
    /// # Errors
    /// [`PersistError`].
    pub fn save_factory(
        &mut self,
        factory: &FactoryCalibration<T>,
        buffer: &mut [u8],
    ) -> Result<(), PersistError<F::Error>> {
        let record = factory.to_record(buffer).map_err(PersistError::Snapshot)?;
        self.store.save(RecordKind::Factory, record).map_err(PersistError::Save)
    }

    /// Restores the saved state into a new calibrator; whether there was one.
    ///
    /// # Errors
    /// [`ResumeError`].
    pub fn resume<const N: usize>(
        &mut self,
        calibrator: &mut Calibrator<T, N>,
        buffer: &mut [u8],
    ) -> Result<bool, ResumeError<F::Error>> {
        let record = self.store.load(RecordKind::State, buffer).map_err(ResumeError::Load)?;
        let Some(record) = record else { return Ok(false) };
        calibrator.restore(record).map_err(ResumeError::Record)?;
        self.policy.restored(calibrator);
        Ok(true)
    }

    /// Saves the state if the policy finds it due; the reason, if so. Call it after each pair.
    ///
    /// * `now`: time since a fixed origin.
    ///
    /// # Errors
    /// [`PersistError`]; the save is due again after the shortest interval.
    pub fn save_if_due<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
        buffer: &mut [u8],
    ) -> Result<Option<SaveReason>, PersistError<F::Error>> {
        let reason = self.policy.due(calibrator, now);
        if reason.is_some() {
            self.save(calibrator, now, buffer)?;
        }
        Ok(reason)
    }

    /// Saves the state, due or not: before power is switched off on purpose.
    ///
    /// # Errors
    /// [`PersistError`].
    pub fn save<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
        buffer: &mut [u8],
    ) -> Result<(), PersistError<F::Error>> {
        let record = calibrator.snapshot(buffer).map_err(PersistError::Snapshot)?;
        self.store.save(RecordKind::State, record).map_err(PersistError::Save)?;
        self.policy.saved(calibrator, now);
        Ok(())
    }

    /// Removes the saved state: a reset of the calibrator then survives the next start.
    ///
    /// # Errors
    /// [`PersistError::Save`].
    pub fn remove(&mut self) -> Result<(), PersistError<F::Error>> {
        self.store.remove(RecordKind::State).map_err(PersistError::Save)
    }

    /// Store below, for diagnostics.
    pub fn store(&self) -> &Store<F> {
        &self.store
    }

    /// Returns the store.
    pub fn release(self) -> Store<F> {
        self.store
    }
}
