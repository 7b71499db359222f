//! Simulated NOR flash: RAM that a reset preserves, with the alignment and write rules of flash.
//!
//! The boards that QEMU emulates have no writable flash. The simulated flash is delivered erased: at power on, when the
//! content of RAM is undefined, it is filled with ff.

use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use embedded_storage::nor_flash::{ErrorType, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// Size of four pages, bytes.
const SIZE: usize = 4 * NorFlash::PAGE as usize;

/// Not initialised at start, so a reset preserves it.
#[unsafe(link_section = ".uninit.nor_flash")]
static mut CELLS: MaybeUninit<[u8; SIZE]> = MaybeUninit::uninit();

/// [`MAGIC`] once the flash has been delivered; undefined at power on.
#[unsafe(link_section = ".uninit.nor_flash")]
static mut DELIVERED: MaybeUninit<u32> = MaybeUninit::uninit();

const MAGIC: u32 = 0x4e4f_5246;

static TAKEN: AtomicBool = AtomicBool::new(false);

/// An access that flash does not allow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum FlashError {
    /// Beyond the end of the flash.
    OutOfBounds,
    /// Not aligned to words or pages.
    NotAligned,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::NotAligned => NorFlashErrorKind::NotAligned,
        }
    }
}

/// The only flash of the board.
#[derive(Debug)]
pub struct NorFlash {
    cells: *mut u8,
}

impl NorFlash {
    /// Size, bytes.
    pub const SIZE: u32 = 4 * Self::PAGE;
    /// Size of a page, the unit of erasure, bytes.
    pub const PAGE: u32 = 4096;

    /// The flash. `None` after the first call.
    pub fn take() -> Option<Self> {
        if TAKEN.swap(true, Ordering::AcqRel) {
            return None;
        }
        let cells: *mut u8 = (&raw mut CELLS).cast();
        let delivered: *mut u32 = (&raw mut DELIVERED).cast();
        // SAFETY: statics that only the first call accesses. Volatile: their content survives a reset.
        unsafe {
            if ptr::read_volatile(delivered) != MAGIC {
                (0..SIZE).for_each(|i| ptr::write_volatile(cells.add(i), 0xff));
                ptr::write_volatile(delivered, MAGIC);
            }
        }
        Some(Self { cells })
    }

    /// Address of a range of bytes within the flash.
    fn at(&self, offset: u32, bytes: usize) -> Result<*mut u8, FlashError> {
        let offset = offset as usize;
        let end = offset.checked_add(bytes).filter(|end| *end <= SIZE);
        end.ok_or(FlashError::OutOfBounds)?;
        // SAFETY: the range is within the static.
        Ok(unsafe { self.cells.add(offset) })
    }
}

impl ErrorType for NorFlash {
    type Error = FlashError;
}

impl ReadNorFlash for NorFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let cells = self.at(offset, bytes.len())?;
        for (i, byte) in bytes.iter_mut().enumerate() {
            // SAFETY: within the static, which only this value accesses. Volatile: the content survives a
            // reset, so the compiler cannot know it.
            *byte = unsafe { ptr::read_volatile(cells.add(i)) };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        SIZE
    }
}

impl embedded_storage::nor_flash::NorFlash for NorFlash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = Self::PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        if !from.is_multiple_of(Self::PAGE) || !to.is_multiple_of(Self::PAGE) || from > to {
            return Err(FlashError::NotAligned);
        }
        let bytes = (to - from) as usize;
        let cells = self.at(from, bytes)?;
        for i in 0..bytes {
            // SAFETY: as in `read`.
            unsafe { ptr::write_volatile(cells.add(i), 0xff) };
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let word = Self::WRITE_SIZE;
        if !(offset as usize).is_multiple_of(word) || !bytes.len().is_multiple_of(word) {
            return Err(FlashError::NotAligned);
        }
        let cells = self.at(offset, bytes.len())?;
        for (i, byte) in bytes.iter().enumerate() {
            // SAFETY: as in `read`. A write only clears bits.
            unsafe {
                let cell = cells.add(i);
                ptr::write_volatile(cell, ptr::read_volatile(cell) & byte);
            }
        }
        Ok(())
    }
}
