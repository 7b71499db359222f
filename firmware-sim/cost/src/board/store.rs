//! Measures the flash store and its save policy.

use core::time::Duration;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use stereo_selfcal::store::{SavePolicy, Store};
use stereo_selfcal::{Config, FactoryCalibration, Scalar};

use crate::calls::{CalibratorOf, fresh};
use crate::probe::{Probe, Sample};

/// A page holds five records.
const PAGE: usize = 2048;
const PAGES: usize = 2;

/// Enough saves to fill every page and start the first one again.
const SAVES: u64 = 12;

/// NOR flash in RAM.
struct RamFlash<'a>(&'a mut [u8]);

impl RamFlash<'_> {
    fn range(&mut self, from: u32, len: usize) -> Result<&mut [u8], NorFlashErrorKind> {
        let from = usize::try_from(from).map_err(|_| NorFlashErrorKind::OutOfBounds)?;
        self.0.get_mut(from..from + len).ok_or(NorFlashErrorKind::OutOfBounds)
    }
}

impl ErrorType for RamFlash<'_> {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for RamFlash<'_> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        bytes.copy_from_slice(self.range(offset, bytes.len())?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for RamFlash<'_> {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = 2048;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let len = usize::try_from(to - from).unwrap_or_default();
        self.range(from, len)?.fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        self.range(offset, bytes.len())?.copy_from_slice(bytes);
        Ok(())
    }
}

type Kept<'a, T> = Store<RamFlash<'a>, T>;

#[inline(never)]
fn open<T: Scalar>(flash: RamFlash<'_>) -> Option<Kept<'_, T>> {
    let [middle, end] = [PAGES * PAGE, 2 * PAGES * PAGE].map(u32::try_from);
    let (middle, end) = (middle.ok()?, end.ok()?);
    Store::open(flash, 0..middle, middle..end, SavePolicy::default()).ok()
}

#[inline(never)]
fn save<T: Scalar>(kept: &mut Kept<'_, T>, calibrator: &CalibratorOf<T>, now: Duration) -> bool {
    kept.save(calibrator, now).is_ok()
}

#[inline(never)]
fn save_if_due<T: Scalar>(kept: &mut Kept<'_, T>, calibrator: &CalibratorOf<T>) -> bool {
    kept.save_if_due(calibrator, Duration::ZERO).is_ok_and(|reason| reason.is_some())
}

#[inline(never)]
fn resume<T: Scalar>(kept: &mut Kept<'_, T>, calibrator: &mut CalibratorOf<T>) -> bool {
    kept.resume(calibrator).is_ok_and(|found| found)
}

/// Measures the calls of the store, the driver of a flash in RAM included: `Store::open`, `save_if_due` of a locked
/// calibrator, the most expensive of [`SAVES`] calls of `save`, and `resume`.
///
/// # Panics
/// If a record is not saved or not found again.
pub(crate) fn measure<T: Scalar>(probe: &Probe, calibrator: &CalibratorOf<T>) -> [Sample; 4] {
    let mut bytes = [0xff; 2 * PAGES * PAGE];
    let mut kept = open(RamFlash(&mut bytes)).expect("it has pages");
    let factory = FactoryCalibration::guess(calibrator.in_use().cameras);
    assert!(kept.save_factory(&factory).is_ok(), "it takes records");
    let (saved, if_due) = probe.run(|| save_if_due(&mut kept, calibrator));
    assert!(saved, "the first save of a locked calibrator is due");
    let mut of_save = Sample::default();
    for second in 1..=SAVES {
        let now = Duration::from_secs(second);
        let (saved, sample) = probe.run(|| save(&mut kept, calibrator, now));
        assert!(saved, "it takes records");
        of_save = of_save.max(sample);
    }
    let flash = kept.close();
    let (store, of_open) = probe.run(|| open(flash));
    let mut kept: Kept<'_, T> = store.expect("it has pages");
    let mut other = fresh::<T>(Config::robust());
    let (found, of_resume) = probe.run(|| resume(&mut kept, &mut other));
    assert!(found, "the record was saved");
    [of_open, if_due, of_save, of_resume]
}
