//! The flash store and its save policy.

use core::hint::black_box;
use core::time::Duration;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use stereo_selfcal::Calibrator;
use stereo_selfcal::store::{Persistence, RecordKind, SavePolicy, Store};

use crate::show;

/// Flash unknown to the compiler, with the geometry of an STM32H7.
struct Flash;

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    #[inline(never)]
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        show(offset);
        bytes.fill(black_box(0xff));
        black_box(Ok(()))
    }

    fn capacity(&self) -> usize {
        black_box(0)
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 32;
    const ERASE_SIZE: usize = 0x2_0000;

    #[inline(never)]
    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        show([from, to]);
        black_box(Ok(()))
    }

    #[inline(never)]
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        show(offset);
        show(bytes);
        black_box(Ok(()))
    }
}

pub(crate) fn all(calibrator: &mut Calibrator<f32, 256>) {
    let range = black_box(0)..black_box(0);
    let store = if black_box(false) { Store::open } else { Store::format };
    if let Ok(mut store) = store(black_box(Flash), range, black_box(0)) {
        keep(&mut store);
        show(store.wear());
        let mut persistence = Persistence::new(store, SavePolicy::new());
        save_if_due(&mut persistence, calibrator);
        show(persistence.store().wear());
        black_box(persistence.release().close());
    }
    let _ = policy(calibrator);
}

#[inline(never)]
fn keep(store: &mut Store<Flash>) {
    let kind = if black_box(false) { RecordKind::Factory } else { RecordKind::State };
    let mut buffer = black_box([0; 64]);
    let length = black_box(0);
    show(store.load(kind, buffer.get_mut(..length).unwrap_or_default()));
    show(store.save(kind, buffer.get(..length).unwrap_or_default()));
    show(store.remove(kind));
}

#[inline(never)]
fn save_if_due(persistence: &mut Persistence<Flash, f32>, calibrator: &mut Calibrator<f32, 256>) {
    let mut buffer = black_box([0; 64]);
    let length = black_box(0);
    let buffer = buffer.get_mut(..length).unwrap_or_default();
    if let Ok(Some(made)) = persistence.load_factory(buffer) {
        show(persistence.save_factory(&made, buffer));
    }
    show(persistence.resume(calibrator, buffer));
    show(persistence.save_if_due(calibrator, time(), buffer));
    show(persistence.save(calibrator, time(), buffer));
    show(persistence.remove());
}

fn time() -> Duration {
    Duration::new(black_box(0), black_box(0) % 1_000_000_000)
}

fn policy(calibrator: &Calibrator<f32, 256>) -> Result<(), stereo_selfcal::store::PolicyError> {
    let policy = if black_box(false) { SavePolicy::new() } else { SavePolicy::default() };
    let mut policy = policy.with_shortest_interval(time())?.with_longest_interval(time())?;
    show(policy.due(calibrator, time()));
    policy.saved(calibrator, time());
    policy.restored(calibrator);
    show(&policy);
    Ok(())
}
