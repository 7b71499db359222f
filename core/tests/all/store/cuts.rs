//! Loss of power at every word that a save writes and at every block that it erases.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::store::RecordKind;
use test_support::flash::{Flash, TEARS, Tear};

use crate::store::rig::{
    Content, KINDS, Step, content, format, open, payload, perform, save, scenario,
};
use test_support::is_campaign;

/// Number of single losses of power, and of second losses in the save after one.
#[derive(Debug, Default)]
struct Cuts {
    first: u64,
    second: u64,
}

/// Number of pages, blocks per page, bytes of factory data and of state.
#[derive(Debug, Clone, Copy)]
struct Shape {
    pages: usize,
    page_blocks: usize,
    factory: usize,
    state: usize,
}

impl Cuts {
    /// Loses power at every operation of the first `steps` of the scenario, and at `again` random ones of
    /// the save after that.
    fn everywhere<const W: usize, const E: usize>(
        &mut self,
        shape: Shape,
        tear: Tear,
        (steps, again): (usize, u32),
    ) {
        let mut flash = Flash::<W, E>::new(1 + shape.pages * shape.page_blocks, 1);
        flash.tear = tear;
        let outside = flash.bytes[..E].to_vec();
        let mut held = Content::default();
        for step in scenario(shape.factory, shape.state).into_iter().take(steps) {
            let after = self.during(&flash, shape.page_blocks, &held, &step, again);
            held = held.after(&step);
            flash = after;
        }
        assert_eq!(flash.bytes[..E], outside, "flash outside the range changed");
    }

    /// Loses power at every operation of one save; the flash after the save without loss.
    fn during<const W: usize, const E: usize>(
        &mut self,
        before: &Flash<W, E>,
        page_blocks: usize,
        held: &Content,
        step: &Step,
        again: u32,
    ) -> Flash<W, E> {
        let mut store = open(before.clone(), page_blocks);
        assert_eq!(content(&mut store), *held);
        perform(&mut store, step).unwrap();
        assert_eq!(content(&mut store), held.after(step));
        let after = store.close();
        for cut in 0..after.operations - before.operations {
            let context = format!("cut {cut} of {step:?}, {:?}", before.tear);
            let mut random = ChaCha8Rng::seed_from_u64(u64::from(cut));
            let flash = cut_off(before, page_blocks, step, cut, &mut random);
            self.first += 1;
            let mut store = open(flash, page_blocks);
            let found = content(&mut store);
            assert!(found == *held || found == held.after(step), "{context}: {found:?}");
            // Alternates between the kinds.
            let kind = KINDS[usize::try_from(cut).unwrap() % 2];
            let length = found.of(kind).map_or(9, Vec::len);
            let next = Step { kind, payload: Some(payload(777, length)) };
            self.once_more(&store.close(), page_blocks, &found, &next, again, &mut random);
        }
        after
    }

    /// The next save succeeds, also after a second loss of power in it.
    fn once_more<const W: usize, const E: usize>(
        &mut self,
        flash: &Flash<W, E>,
        page_blocks: usize,
        held: &Content,
        step: &Step,
        again: u32,
        random: &mut ChaCha8Rng,
    ) {
        let tear = flash.tear;
        let saved = |flash: Flash<W, E>| {
            let mut store = open(flash, page_blocks);
            let mut saved = perform(&mut store, step);
            if saved.is_err() && *held == Content::default() && tear == Tear::Ecc {
                // The very first save has torn every page, and none can be read.
                store = format(store.close(), page_blocks);
                saved = perform(&mut store, step);
            }
            saved.unwrap_or_else(|e| panic!("{e}: {step:?} after {held:?}"));
            assert_eq!(content(&mut store), held.after(step));
            let flash = store.close();
            assert_eq!(content(&mut open(flash.clone(), page_blocks)), held.after(step));
            flash.operations
        };
        let operations = saved(flash.clone()) - flash.operations;
        for _ in 0..again {
            let cut = random.random_range(0..operations);
            let torn = cut_off(flash, page_blocks, step, cut, random);
            self.second += 1;
            let found = content(&mut open(torn.clone(), page_blocks));
            assert!(found == *held || found == held.after(step), "again, {cut} of {step:?}");
            saved(torn);
        }
    }
}

/// Flash after a loss of power in a save.
fn cut_off<const W: usize, const E: usize>(
    flash: &Flash<W, E>,
    page_blocks: usize,
    step: &Step,
    cut: u32,
    random: &mut ChaCha8Rng,
) -> Flash<W, E> {
    let mut flash = flash.clone();
    flash.random = ChaCha8Rng::seed_from_u64(random.random());
    flash.power_for = Some(cut + 1);
    let mut store = open(flash, page_blocks);
    // The last write of a save may fail unnoticed.
    let saved = perform(&mut store, step);
    assert!(saved.is_err() || store.wear().erasures > 0, "power is lost");
    let mut flash = store.close();
    flash.power_on();
    flash
}

/// Largest state, in bytes, beside `factory` bytes of factory data in a page of `page` bytes.
fn largest<const W: usize>(page: usize, factory: usize) -> usize {
    page / 2 - (factory + 28).next_multiple_of(W) - 28
}

fn shapes<const W: usize, const E: usize>() -> Vec<Shape> {
    let of_one = |pages| {
        let lengths = [(0, 1), (20, 31), (30, largest::<W>(E, 30))];
        lengths.map(|(factory, state)| Shape { pages, page_blocks: 1, factory, state })
    };
    let mut shapes = [2, 3, 5].map(of_one).concat();
    let state = largest::<W>(2 * E, 50);
    shapes.push(Shape { pages: 2, page_blocks: 2, factory: 50, state });
    shapes
}

/// Every shape, each with one kind of tear; in the campaign with all of them, and twice.
fn every_shape<const W: usize, const E: usize>(steps: usize) {
    let mut cuts = Cuts::default();
    for (shape, tear) in shapes::<W, E>().into_iter().zip(TEARS.into_iter().cycle()) {
        if is_campaign() {
            for tear in TEARS {
                cuts.everywhere::<W, E>(shape, tear, (28, 2));
            }
        } else {
            cuts.everywhere::<W, E>(shape, tear, (steps, 1));
        }
    }
    println!("words of {W} bytes: {cuts:?}, none lost a record");
}

#[test]
fn a_cut_at_any_word_of_1_byte_leaves_the_old_record_or_the_new_one() {
    every_shape::<1, 224>(3);
}

#[test]
fn a_cut_at_any_word_of_4_bytes_leaves_the_old_record_or_the_new_one() {
    every_shape::<4, 256>(8);
}

#[test]
fn a_cut_at_any_word_of_8_bytes_leaves_the_old_record_or_the_new_one() {
    every_shape::<8, 512>(16);
}

#[test]
fn a_cut_at_any_word_of_32_bytes_leaves_the_old_record_or_the_new_one() {
    every_shape::<32, 1024>(28);
}

#[test]
fn a_cut_at_any_word_of_64_bytes_leaves_the_old_record_or_the_new_one() {
    every_shape::<64, 1536>(28);
}

#[test]
fn nothing_is_written_onto_bytes_of_a_torn_header_that_look_erased() {
    let mut flash = Flash::<1, 2048>::new(3, 9);
    flash.tear = Tear::Hidden;
    let mut store = open(flash, 1);
    for number in 0..500 {
        let step = save(RecordKind::State, number, 5);
        perform(&mut store, &step).unwrap();
        let held = content(&mut store);
        let flash = store.close();
        // Within the CRC of the header: one byte in 256 reads as erased.
        for cut in 21..24 {
            let mut random = ChaCha8Rng::seed_from_u64(u64::from(cut));
            let mut torn = open(cut_off(&flash, 1, &step, cut, &mut random), 1);
            perform(&mut torn, &step).unwrap();
            assert_eq!(content(&mut torn), held);
        }
        store = open(flash, 1);
    }
}
