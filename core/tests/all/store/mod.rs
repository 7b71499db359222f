//! The store through its public API, under loss of power and faults of the flash.

mod cuts;
mod faults;
mod policy;
mod retried;

use crate::api::presets::robust;
use crate::api::scene::cameras;
use crate::record::Record;
use core::fmt::Debug;
use embedded_storage::nor_flash::NorFlash;
use stereo_selfcal::FactoryCalibration;
use stereo_selfcal::store::{SavePolicy, Store};

const CRC_32: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// A store whose records contain a number that identifies them.
pub(crate) struct Kept<F>(pub(crate) Store<F, f32>);

impl<F: NorFlash<Error: Debug>> Kept<F> {
    /// The first half of the flash holds the factory calibration, the other half the state.
    pub(crate) fn open(flash: F) -> Self {
        let end = u32::try_from(flash.capacity()).unwrap();
        let (factory, state) = (0..end / 2, end / 2..end);
        Self(Store::open(flash, factory, state, SavePolicy::default()).unwrap())
    }

    /// Saves a factory calibration with this number; returns whether it was saved.
    pub(crate) fn save_factory(&mut self, number: u16) -> bool {
        let made = FactoryCalibration::guess(cameras());
        let made = made.with_baseline_m(1.0 + f32::from(number)).unwrap();
        self.0.save_factory(&made).is_ok()
    }

    /// The number of the factory calibration found.
    pub(crate) fn factory(&mut self) -> Option<u16> {
        let found = self.0.load_factory().ok()??;
        let baseline_m = found.baseline_m()?;
        (0..u16::MAX).find(|number| 1.0 + f32::from(*number) >= baseline_m)
    }

    /// Saves a state with this number as its generation; returns whether it was saved.
    pub(crate) fn save(&mut self, number: u32) -> bool {
        let mut calibrator = robust::<f32>();
        calibrator.restore(&numbered(number)).unwrap();
        self.0.save(&calibrator, core::time::Duration::ZERO).is_ok()
    }

    /// The generation of the state found.
    pub(crate) fn state(&mut self) -> Option<u32> {
        let mut calibrator = robust::<f32>();
        self.0.resume(&mut calibrator).ok()?.then(|| calibrator.in_use().generation)
    }
}

/// The record of a calibrator without an estimate, with a number as its generation.
fn numbered(number: u32) -> Record {
    static FRESH: std::sync::LazyLock<Record> =
        std::sync::LazyLock::new(|| robust::<f32>().snapshot());
    let mut record = *FRESH;
    record[12..16].copy_from_slice(&number.to_le_bytes());
    let body = record.len() - 4;
    let sum = CRC_32.checksum(&record[..body]);
    record[body..].copy_from_slice(&sum.to_le_bytes());
    record
}
