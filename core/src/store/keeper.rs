//! The calibrator's memory: store and policy, as one.

use core::fmt::Debug;
use core::time::Duration;

use embedded_storage::nor_flash::NorFlash;
use thiserror::Error;

use super::{Kind, LoadError, SaveError, SavePolicy, SaveReason, Store};
use crate::calibrator::Calibrator;
use crate::error::{RestoreError, SnapshotError};
use crate::scalar::Scalar;
use crate::snapshot::factory::FactoryCalibration;

/// Takes up at start what was learnt before, and keeps what is learnt since.
///
/// Buffers are the caller's, and free again after each call: [`Calibrator::SNAPSHOT_BYTES`] bytes, or
/// [`FactoryCalibration::MAX_BYTES`].
///
/// ```
/// # use core::time::Duration;
/// # use embedded_storage::nor_flash::NorFlash;
/// # use stereo_selfcal::{*, store::*};
/// # fn run<F: NorFlash>(flash: F, now: Duration) -> Option<()> where F::Error: core::fmt::Debug {
/// // Two sectors of 128 kB.
/// let store = Store::open(flash, 0..0x4_0000, 0x2_0000).ok()?;
/// let mut keeper = Keeper::new(store, SavePolicy::<f32>::new());
/// let mut buffer = [0; Calibrator::<f32, 256>::SNAPSHOT_BYTES];
///
/// // At start. What to do without factory calibration is the firmware's to say.
/// let made = keeper.factory(&mut buffer).ok()??;
/// let mut calibrator = Calibrator::<f32, 256>::new(Config::robust());
/// calibrator.set_cameras(made.cameras);
/// calibrator.set_factory(made.extrinsics);
/// let resumed = keeper.resume(&mut calibrator, &mut buffer); // log it
///
/// // After each pair.
/// let saved = keeper.tend(&calibrator, now, &mut buffer); // log it
/// # Some(())
/// # }
/// ```
#[derive(Debug)]
pub struct Keeper<F: NorFlash, T: Scalar> {
    store: Store<F>,
    policy: SavePolicy<T>,
}

/// Why nothing was taken up. The calibrator is as it was: start afresh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ResumeError<E: Debug> {
    /// The store did not give the record.
    #[error(transparent)]
    Load(LoadError<E>),
    /// It did, and the record is not for this calibrator.
    #[error("the record in flash: {0}")]
    Record(RestoreError),
}

/// Why nothing was kept. What was kept before is there still.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum KeepError<E: Debug> {
    /// There is no record to be kept.
    #[error(transparent)]
    Snapshot(SnapshotError),
    /// The store did not take it.
    #[error(transparent)]
    Save(SaveError<E>),
}

impl<F: NorFlash<Error: Debug>, T: Scalar> Keeper<F, T> {
    /// Of a store that has been opened.
    pub const fn new(store: Store<F>, policy: SavePolicy<T>) -> Self {
        Self { store, policy }
    }

    /// The factory calibration; `None` if none was kept yet.
    ///
    /// # Errors
    /// [`ResumeError`].
    pub fn factory(
        &mut self,
        buffer: &mut [u8],
    ) -> Result<Option<FactoryCalibration<T>>, ResumeError<F::Error>> {
        let record = self.store.load(Kind::Factory, buffer).map_err(ResumeError::Load)?;
        record.map(FactoryCalibration::from_record).transpose().map_err(ResumeError::Record)
    }

    /// Keeps a factory calibration in the place of the one before. What was learnt from that will not be
    /// taken up any more.
    ///
    /// # Errors
    /// [`KeepError`].
    pub fn keep_factory(
        &mut self,
        made: &FactoryCalibration<T>,
        buffer: &mut [u8],
    ) -> Result<(), KeepError<F::Error>> {
        let record = made.to_record(buffer).map_err(KeepError::Snapshot)?;
        self.store.save(Kind::Factory, record).map_err(KeepError::Save)
    }

    /// Lets a calibrator that has learnt nothing yet take up what was kept; whether there was anything.
    ///
    /// # Errors
    /// [`ResumeError`].
    pub fn resume<const N: usize>(
        &mut self,
        calibrator: &mut Calibrator<T, N>,
        buffer: &mut [u8],
    ) -> Result<bool, ResumeError<F::Error>> {
        let record = self.store.load(Kind::State, buffer).map_err(ResumeError::Load)?;
        let Some(record) = record else { return Ok(false) };
        calibrator.restore(record).map_err(ResumeError::Record)?;
        self.policy.restored(calibrator);
        Ok(true)
    }

    /// Keeps what was learnt if that is due; why it was. To be called after each pair.
    ///
    /// * `now`: since any origin, the same for all calls.
    ///
    /// # Errors
    /// [`KeepError`]; it is due again after the shortest interval.
    pub fn tend<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
        buffer: &mut [u8],
    ) -> Result<Option<SaveReason>, KeepError<F::Error>> {
        let reason = self.policy.due(calibrator, now);
        if reason.is_some() {
            self.keep(calibrator, now, buffer)?;
        }
        Ok(reason)
    }

    /// Keeps what was learnt, due or not: before power is switched off on purpose.
    ///
    /// # Errors
    /// [`KeepError`].
    pub fn keep<const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        now: Duration,
        buffer: &mut [u8],
    ) -> Result<(), KeepError<F::Error>> {
        let record = calibrator.snapshot(buffer).map_err(KeepError::Snapshot)?;
        self.store.save(Kind::State, record).map_err(KeepError::Save)?;
        self.policy.saved(calibrator, now);
        Ok(())
    }

    /// Lets nothing that was learnt be taken up, after a reset that is to last.
    ///
    /// # Errors
    /// [`KeepError::Save`].
    pub fn forget(&mut self) -> Result<(), KeepError<F::Error>> {
        self.store.forget(Kind::State).map_err(KeepError::Save)
    }

    /// The store, for what an operator asks of it.
    pub fn store(&self) -> &Store<F> {
        &self.store
    }

    /// The store again.
    pub fn release(self) -> Store<F> {
        self.store
    }
}
