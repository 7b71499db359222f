//! Flash with lasting faults, and flash with any content.

use super::Kept;
use core::cell::Cell;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::rc::Rc;
use test_support::flash::{Fault, Flash};
use test_support::runs;

type Nor = Flash<8, 1024>;

#[derive(Debug, Clone, Copy)]
enum Kind {
    ReadFails,
    ReadsZeros,
    ReadsOnes,
    /// Reads return random bytes.
    ReadsNoise,
    WriteFails,
    NoWrite,
    NoErasure,
}

const KINDS: [Kind; 7] = [
    Kind::ReadFails,
    Kind::ReadsZeros,
    Kind::ReadsOnes,
    Kind::ReadsNoise,
    Kind::WriteFails,
    Kind::NoWrite,
    Kind::NoErasure,
];

/// A kind of fault of one block, or of all blocks.
type Standing = (Kind, Option<u32>);

/// Flash with faults that last while they are set.
struct Faulty(Nor, Rc<Cell<[Option<Standing>; 2]>>, ChaCha8Rng);

impl Faulty {
    fn has(&self, address: u32, of: fn(Kind) -> bool) -> Option<Kind> {
        let hits = |(kind, block): &Standing| {
            of(*kind) && block.is_none_or(|block| block == address / Nor::ERASE_SIZE as u32)
        };
        self.1.get().into_iter().flatten().find(hits).map(|(kind, _)| kind)
    }
}

impl ErrorType for Faulty {
    type Error = Fault;
}

impl ReadNorFlash for Faulty {
    const READ_SIZE: usize = Nor::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        match self
            .has(offset, |kind| !matches!(kind, Kind::WriteFails | Kind::NoWrite | Kind::NoErasure))
        {
            None => return self.0.read(offset, bytes),
            Some(Kind::ReadFails) => return Err(Fault::Deaf),
            Some(Kind::ReadsZeros) => bytes.fill(0),
            Some(Kind::ReadsOnes) => bytes.fill(0xff),
            Some(_) => self.2.fill_bytes(bytes),
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for Faulty {
    const WRITE_SIZE: usize = Nor::WRITE_SIZE;
    const ERASE_SIZE: usize = Nor::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        let fails = self.has(from, |kind| matches!(kind, Kind::NoErasure)).is_some();
        if fails { Ok(()) } else { self.0.erase(from, to) }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        match self.has(offset, |kind| matches!(kind, Kind::WriteFails | Kind::NoWrite)) {
            Some(Kind::WriteFails) => Err(Fault::Worn),
            Some(_) => Ok(()),
            // After `NoErasure` the words may not be erased: the driver refuses to write them.
            None => {
                let range = offset as usize..offset as usize + bytes.len();
                let is_erased = self.0.bytes[range].iter().all(|byte| *byte == 0xff);
                if is_erased { self.0.write(offset, bytes) } else { Err(Fault::Torn) }
            }
        }
    }
}

#[test]
fn under_standing_faults_no_factory_calibration_is_lost_and_no_save_is_refused_for_ever() {
    let [mut lost, mut older, mut all] = [0; 3];
    for seed in 0..runs(600, 13_440) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let faults = Rc::new(Cell::new([None; 2]));
        let blocks = rng.random_range(2..=4);
        let flash = Nor::of(vec![0xff; 2 * blocks * Nor::ERASE_SIZE], seed);
        let open =
            |flash| Kept::open(Faulty(flash, Rc::clone(&faults), ChaCha8Rng::seed_from_u64(seed)));
        let mut kept = open(flash);
        assert!(kept.save_factory(1));
        let good = rng.random_range(1..8);
        assert!((1..=good).all(|number| kept.save(number)));
        let mut drawn = || {
            let kind = KINDS[rng.random_range(0..KINDS.len())];
            let block = rng.random_range(0..2 * blocks as u32);
            (kind, rng.random::<bool>().then_some(block))
        };
        faults.set([Some(drawn()), Some(drawn()).filter(|_| seed % 2 == 0)]);
        let mut last = good;
        for number in good + 1..good + 6 {
            if number == good + 3 {
                kept = open(kept.0.close().0);
            }
            last = if kept.save(number) { number } else { last };
            let _ = kept.save_factory(2);
        }
        faults.set([None; 2]);
        let mut kept = open(kept.0.close().0);
        assert!(matches!(kept.factory(), Some(1 | 2)), "{seed}: factory lost");
        let found = kept.state();
        lost += u32::from(found.is_none());
        older += u32::from(found.is_some_and(|found| found < last));
        assert!(kept.save(100) && kept.state() == Some(100), "{seed}: refused");
        assert!(kept.save_factory(3) && kept.factory() == Some(3));
        all += 1;
    }
    println!("{all} runs: {lost} states lost, {older} older");
    assert!(lost * 20 < all && older * 10 < all, "{lost} {older}");
}

#[test]
fn flash_that_holds_anything_takes_records() {
    for seed in 0..runs(60, 540) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut kept = Kept::open(Nor::new(4, seed));
        assert!(kept.save_factory(1) && kept.save(9));
        // Parts of the flash, which may be parts of the valid records, are copied to random places.
        let mut bytes = kept.0.close().bytes;
        for _ in 0..rng.random_range(1..6) {
            let [from, to] = [(); 2].map(|()| 8 * rng.random_range(0..bytes.len() / 8 - 60));
            let part = bytes[from..from + 8 * rng.random_range(1..60)].to_vec();
            bytes[to..to + part.len()].copy_from_slice(&part);
        }
        let mut kept = Kept::open(Nor::of(bytes, seed));
        assert!((10..30).all(|number| kept.save(number)) && kept.state() == Some(29), "{seed}");
        assert!(kept.save_factory(2) && kept.factory() == Some(2), "{seed}");
    }
}

#[test]
fn any_one_damaged_byte_leaves_the_factory_calibration_and_a_state() {
    let mut kept = Kept::open(Nor::of(vec![0xff; 4 * 1024], 1));
    assert!(kept.save_factory(1) && (1..=5).all(|number| kept.save(number)));
    let good = kept.0.close();
    for at in (0..good.bytes.len()).step_by(runs(3, 1)) {
        let mut flash = good.clone();
        flash.bytes[at] ^= 0x21;
        flash = Nor::of(flash.bytes, 1);
        let mut kept = Kept::open(flash);
        assert_eq!(kept.factory(), Some(1), "{at}");
        assert!(matches!(kept.state(), Some(4 | 5)), "{at}");
        assert!(kept.save(6) && kept.state() == Some(6), "{at}");
    }
}
