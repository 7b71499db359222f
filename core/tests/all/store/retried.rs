//! Saves after one that failed because the flash could not be read for a moment.

use super::Kept;
use core::cell::Cell;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use std::rc::Rc;
use test_support::flash::{Fault, Flash};

type Nor = Flash<8, 1024>;

/// Flash that is deaf for a moment: numbers of reads that pass before, and of reads that then fail.
struct Deaf(Nor, Rc<Cell<[u32; 2]>>);

impl ErrorType for Deaf {
    type Error = Fault;
}

impl ReadNorFlash for Deaf {
    const READ_SIZE: usize = Nor::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        match self.1.get() {
            [0, 0] => self.0.read(offset, bytes),
            [0, failing] => {
                self.1.set([0, failing - 1]);
                Err(Fault::Deaf)
            }
            [passing, failing] => {
                self.1.set([passing - 1, failing]);
                self.0.read(offset, bytes)
            }
        }
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for Deaf {
    const WRITE_SIZE: usize = Nor::WRITE_SIZE;
    const ERASE_SIZE: usize = Nor::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        self.0.erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        self.0.write(offset, bytes)
    }
}

#[test]
fn the_last_save_is_found_although_the_one_before_it_failed() {
    let mut failed = 0;
    for blocks in 2..5 {
        for before in 1..5 {
            for (passing, failing) in (0..12).flat_map(|i| (1..6).map(move |n| (i, n))) {
                let reads = Rc::new(Cell::new([0; 2]));
                let flash = Nor::of(vec![0xff; 2 * blocks * 1024], 1);
                let mut kept = Kept::open(Deaf(flash, Rc::clone(&reads)));
                assert!((1..=before).all(|number| kept.save(number)));
                reads.set([passing, failing]);
                failed += u32::from(!kept.save(before + 1));
                reads.set([0; 2]);
                assert!(kept.save(before + 2));
                let found = Kept::open(kept.0.close()).state();
                assert_eq!(found, Some(before + 2), "{blocks} {before} {passing} {failing}");
            }
        }
    }
    assert!(failed > 100, "{failed}");
}
