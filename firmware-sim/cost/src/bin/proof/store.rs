//! The flash store and its save policy.

use core::hint::black_box;
use core::time::Duration;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use stereo_selfcal::Calibrator;
use stereo_selfcal::store::{SavePolicy, Store};

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
    let [factory, state] = [(); 2].map(|()| black_box(0)..black_box(0));
    let policy = if black_box(false) { SavePolicy::new(time()) } else { SavePolicy::default() };
    if let Ok(mut store) = Store::open(black_box(Flash), factory, state, policy) {
        if let Ok(Some(made)) = store.load_factory() {
            show(store.save_factory(&made));
        }
        show(store.resume(calibrator));
        show(store.save_if_due(calibrator, time()));
        show(store.save(calibrator, time()));
        black_box(store.close());
    }
    policy_alone(calibrator);
}

fn time() -> Duration {
    Duration::new(black_box(0), black_box(0) % 1_000_000_000)
}

#[inline(never)]
fn policy_alone(calibrator: &Calibrator<f32, 256>) {
    let mut policy = SavePolicy::new(time());
    show(policy.due(calibrator, time()));
    policy.saved(calibrator, time());
    policy.restarted(calibrator);
    show(&policy);
}
