//! Loss of power at every word of every save, and again in the next save.

use super::Kept;
use crate::api::presets::robust;
use stereo_selfcal::RestoreError;
use stereo_selfcal::store::{SavePolicy, Store, StoreError};
use test_support::flash::{Blank, Flash, TEARS, Tear};
use test_support::is_campaign;

/// Number of saves. In the short test they use every slot of the flash at least once.
const SAVES: u32 = 8;

/// Cuts the power at every word of each save (every seventh word in the short test), and again in the next save.
/// Returns the numbers of states lost, of factory calibrations lost, of saves refused afterwards, and of runs with two
/// cuts.
fn cut<const W: usize, const E: usize>(blocks: usize, blank: Blank, tear: Tear) -> [u32; 4] {
    let (mut counts, every) = ([0; 4], if is_campaign() { 1 } else { 7 });
    let mut prepared = Kept::open(flash::<W, E>(blocks, blank, tear));
    assert!(prepared.save_factory(1));
    let prepared = prepared.0.close();
    for number in 1..=SAVES {
        let mut before = Kept::open(prepared.clone());
        assert!((1..number).all(|n| before.save(n)));
        let before = before.0.close();
        for first in (1..).step_by(every) {
            let mut flash = before.clone();
            flash.power_for = Some(first);
            let mut kept = Kept::open(flash);
            let whole = kept.save(number);
            let mut flash = kept.0.close();
            flash.power_on();
            for second in [1, 2, 3 + first % 20, 200] {
                let mut flash = flash.clone();
                flash.power_for = Some(second);
                let mut kept = Kept::open(flash);
                let _ = kept.save(number + 1);
                let mut flash = kept.0.close();
                flash.power_on();
                let mut kept = Kept::open(flash);
                let found = kept.state().unwrap_or(0);
                counts[0] += u32::from(found + 1 < number || found > number + 1);
                counts[1] += u32::from(kept.factory() != Some(1));
                let taken = kept.save(number + 2) && kept.state() == Some(number + 2);
                counts[2] += u32::from(!taken);
                counts[3] += 1;
            }
            if whole {
                break;
            }
        }
    }
    counts
}

fn flash<const W: usize, const E: usize>(blocks: usize, blank: Blank, tear: Tear) -> Flash<W, E> {
    let mut flash = Flash::of(vec![0xff; 2 * blocks * E], 1);
    (flash.blank, flash.tear) = (blank, tear);
    flash
}

fn cut_all<const W: usize, const E: usize>(blocks: usize) -> u32 {
    let mut cuts = 0;
    for blank in [Blank::Ones, Blank::Zeros, Blank::Unreadable] {
        for tear in TEARS {
            let [lost, factory, refused, all] = cut::<W, E>(blocks, blank, tear);
            assert_eq!(
                [lost, factory, refused],
                [0; 3],
                "{W} {blocks} {blank:?} {tear:?} of {all}"
            );
            cuts += all;
        }
    }
    cuts
}

#[test]
fn power_may_fail_at_any_word_of_a_save_and_of_the_next() {
    // In the short test each block holds two to four slots.
    let cuts = [cut_all::<4, 1024>(2), cut_all::<8, 1024>(3), cut_all::<32, 2048>(2)];
    let rest = if is_campaign() { [cut_all::<8, 4096>(4), cut_all::<1, 512>(2)] } else { [0; 2] };
    println!("{} cuts", cuts.iter().chain(&rest).sum::<u32>());
}

#[test]
fn power_may_fail_at_any_word_of_a_factory_save_twice() {
    let mut cuts = 0;
    for (blank, tear) in [Blank::Ones, Blank::Zeros, Blank::Unreadable]
        .into_iter()
        .flat_map(|blank| TEARS.map(|tear| (blank, tear)))
    {
        let mut kept = Kept::open(flash::<8, 1024>(2, blank, tear));
        assert!(kept.save_factory(1) && kept.save(5));
        let before = kept.0.close();
        for first in 1..60 {
            for second in (1..60).step_by(if is_campaign() { 1 } else { 9 }) {
                let mut flash = before.clone();
                for (number, power) in [(2, first), (3, second)] {
                    flash.power_for = Some(power);
                    let mut kept = Kept::open(flash);
                    let _ = kept.save_factory(number);
                    flash = kept.0.close();
                    flash.power_on();
                }
                let mut kept = Kept::open(flash);
                assert!(kept.factory().is_some(), "{blank:?} {tear:?} {first} {second}");
                assert_eq!(kept.state(), Some(5));
                assert!(kept.save_factory(4) && kept.factory() == Some(4));
                cuts += 1;
            }
        }
    }
    println!("{cuts} cuts");
}

#[test]
fn wear_is_even_and_a_block_is_erased_once_for_its_slots() {
    let mut kept = Kept::open(flash::<8, 2048>(4, Blank::Ones, Tear::Word));
    assert!((1..=200).all(|number| kept.save(number)));
    // 200 saves over four blocks of five slots of 408 bytes.
    assert_eq!(kept.0.close().erased, [0, 0, 0, 0, 10, 10, 10, 10]);
}

#[test]
fn ranges_that_cannot_hold_a_store_are_refused() {
    let open = |factory, state| {
        let flash = Flash::<8, 1024>::of(vec![0xff; 8 * 1024], 1);
        Store::<_, f32>::open(flash, factory, state, SavePolicy::default()).map(|_| ()).err()
    };
    assert_eq!(open(0..2048, 2048..8192), None);
    assert_eq!(open(4096..8192, 0..4096), None);
    for (factory, state) in [
        (0..2048, 2048..9216),
        (0..1024, 2048..4096),
        (0..2048, 2048..3072),
        (0..4096, 3072..8192),
        #[expect(clippy::reversed_empty_ranges, reason = "to be refused")]
        (2048..0, 2048..4096),
        (8..2056, 4096..8192),
    ] {
        assert_eq!(open(factory, state), Some(StoreError::Range));
    }
    let small = Flash::<8, 256>::of(vec![0xff; 1024], 1);
    let small = Store::<_, f32>::open(small, 0..512, 512..1024, SavePolicy::default());
    assert_eq!(small.err(), Some(StoreError::Range), "a block holds no record");
}

#[test]
fn an_empty_flash_holds_nothing_and_lost_records_are_reported() {
    let mut kept = Kept::open(flash::<8, 1024>(2, Blank::Ones, Tear::Word));
    assert_eq!(kept.0.load_factory(), Ok(None));
    assert_eq!(kept.0.resume(&mut robust::<f32>()), Ok(false));
    assert!(kept.save_factory(7) && kept.save(3));
    let mut flash = kept.0.close();
    flash.bytes.iter_mut().for_each(|byte| *byte ^= 1);
    let mut kept = Kept::open(flash);
    assert_eq!(kept.0.load_factory(), Err(RestoreError::Damaged));
    assert_eq!(kept.0.resume(&mut robust::<f32>()), Err(RestoreError::Damaged));
}
