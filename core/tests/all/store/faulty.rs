//! Flash with faults of reads, writes and erasures, of all pages or of some.

use core::cell::RefCell;
use std::rc::Rc;

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use rand::RngExt;
use test_support::flash::{Fault, Flash};

/// What does not work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Defect {
    /// Reads return an error; writes and erasures work.
    Deaf,
    /// Reads return this byte; writes and erasures work.
    Stuck(u8),
    /// Nothing works.
    Gone,
    /// Erasures have no effect.
    NoErase,
    /// Writes have no effect.
    NoWrite,
    /// One read in so many has a wrong bit.
    Flips(u32),
    /// The first bit of each write stays 0.
    FirstBit,
}

/// Those of the campaigns.
pub(crate) const DEFECTS: [Defect; 7] = [
    Defect::Deaf,
    Defect::Stuck(0),
    Defect::Stuck(0xff),
    Defect::Gone,
    Defect::NoErase,
    Defect::NoWrite,
    Defect::Flips(40),
];

/// A defect, the pages that have it, bit by bit, and the number of reads before it begins.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Active {
    pub(crate) defect: Defect,
    pub(crate) pages: u32,
    pub(crate) after: u32,
}

/// Faults of a flash, shared with the test.
pub(crate) type Faults = Rc<RefCell<Vec<Active>>>;

/// Simulated flash whose pages, of one block each, come after one block outside the store.
#[derive(Debug, Clone)]
pub(crate) struct Faulty<const W: usize, const E: usize> {
    pub(crate) flash: Flash<W, E>,
    pub(crate) faults: Faults,
}

impl<const W: usize, const E: usize> Faulty<W, E> {
    fn has(&self, offset: u32, defect: impl Fn(Defect) -> bool) -> bool {
        let page = (offset as usize / E).saturating_sub(1);
        let is = |a: &Active| a.after == 0 && a.pages >> page & 1 == 1 && defect(a.defect);
        self.faults.borrow().iter().any(is)
    }
}

impl<const W: usize, const E: usize> ErrorType for Faulty<W, E> {
    type Error = Fault;
}

impl<const W: usize, const E: usize> ReadNorFlash for Faulty<W, E> {
    const READ_SIZE: usize = Flash::<W, E>::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        self.flash.read(offset, bytes)?;
        self.faults.borrow_mut().iter_mut().for_each(|a| a.after = a.after.saturating_sub(1));
        if self.has(offset, |d| matches!(d, Defect::Deaf | Defect::Gone)) {
            return Err(Fault::Deaf);
        }
        for with in [0, 0xff] {
            if self.has(offset, |d| d == Defect::Stuck(with)) {
                bytes.fill(with);
            }
        }
        let flips = DEFECTS.into_iter().find_map(|d| match d {
            Defect::Flips(one_in) if self.has(offset, |other| other == d) => Some(one_in),
            _ => None,
        });
        if flips.is_some_and(|one_in| self.flash.random.random_ratio(1, one_in)) {
            let at = self.flash.random.random_range(0..bytes.len());
            bytes[at] ^= 1 << self.flash.random.random_range(0..8);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl<const W: usize, const E: usize> NorFlash for Faulty<W, E> {
    const WRITE_SIZE: usize = W;
    const ERASE_SIZE: usize = E;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        if self.has(from, |d| d == Defect::Gone) {
            return Err(Fault::Deaf);
        }
        if self.has(from, |d| d == Defect::NoErase) { Ok(()) } else { self.flash.erase(from, to) }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        if self.has(offset, |d| d == Defect::Gone) {
            return Err(Fault::Deaf);
        }
        if self.has(offset, |d| d == Defect::NoWrite) {
            return Ok(());
        }
        if self.faults.borrow().is_empty() {
            return self.flash.write(offset, bytes);
        }
        // The store may not know what it writes onto: bits are cleared, as NOR flash does.
        for (i, word) in bytes.chunks(W).enumerate() {
            self.flash.operations += 1;
            let power = self.flash.power_for.as_mut();
            let left = power.map_or(1, |left| {
                *left = left.saturating_sub(1);
                *left
            });
            let cells = &mut self.flash.bytes[offset as usize + i * W..][..W];
            for (cell, bits) in cells.iter_mut().zip(word) {
                let kept: u8 = if left == 0 { self.flash.random.random() } else { 0 };
                *cell &= bits | kept;
            }
            if i == 0 && self.has(offset, |d| d == Defect::FirstBit) {
                self.flash.bytes[offset as usize] &= 0xfe;
            }
            if left == 0 {
                return Err(Fault::NoPower);
            }
        }
        Ok(())
    }
}
