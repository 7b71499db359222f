//! NOR flash of the board: RAM that a reset leaves as it is, held to the rules of flash.
//!
//! The machines that QEMU emulates have none that can be written. What is in it at power on is whatever
//! the RAM was.

use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use embedded_storage::nor_flash::{ErrorType, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// Two pages, bytes.
const SIZE: usize = 2 * NorFlash::PAGE as usize;

/// Not touched at start, so that a reset leaves it alone.
#[unsafe(link_section = ".uninit.nor_flash")]
static mut CELLS: MaybeUninit<[u8; SIZE]> = MaybeUninit::uninit();

static TAKEN: AtomicBool = AtomicBool::new(false);

/// What a caller asked that flash cannot do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum FlashError {
    /// Beyond its end.
    OutOfBounds,
    /// Not whole words, or whole pages.
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

/// The flash; there is one.
#[derive(Debug)]
pub struct NorFlash {
    cells: *mut u8,
}

impl NorFlash {
    /// Bytes of it.
    pub const SIZE: u32 = 2 * Self::PAGE;
    /// Bytes that are erased at once.
    pub const PAGE: u32 = 8192;

    /// The flash, for the first that asks.
    pub fn take() -> Option<Self> {
        let cells = (&raw mut CELLS).cast();
        (!TAKEN.swap(true, Ordering::AcqRel)).then_some(Self { cells })
    }

    /// Where so many bytes are, if they are of the flash.
    fn at(&self, offset: u32, bytes: usize) -> Result<*mut u8, FlashError> {
        let offset = offset as usize;
        let end = offset.checked_add(bytes).filter(|end| *end <= SIZE);
        end.ok_or(FlashError::OutOfBounds)?;
        // SAFETY: up to its end it is within the static.
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
            // SAFETY: within the static, to which there is no other way than this one; volatile, because
            // what is there is what the hardware has kept, not what the program has written.
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
