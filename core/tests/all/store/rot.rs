//! Bit rot: one damaged byte, anywhere, at any time.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::store::{LoadError, RecordKind, Store};
use test_support::flash::Flash;

use crate::store::rig::{KINDS, load, open, perform, save, scenario};

/// Payloads of a kind, newest last; `None` after removal.
type History = Vec<Option<Vec<u8>>>;

fn histories(pages: usize, steps: usize) -> (Flash<8, 512>, [History; 2]) {
    let mut store = open(Flash::new(1 + pages, 2), 1);
    let mut histories = [vec![None], vec![None]];
    for step in scenario(60, 140).into_iter().take(steps) {
        perform(&mut store, &step).unwrap();
        histories[usize::from(step.kind == RecordKind::State)].push(step.payload);
    }
    (store.close(), histories)
}

/// Checks that the newest record is found; of the state, which may have one copy, or the one before.
fn assert_recent(store: &mut Store<Flash<8, 512>>, histories: &[History; 2], context: &str) {
    for (kind, history) in KINDS.into_iter().zip(histories) {
        let loaded = load(store, kind).unwrap();
        let newest = history.last().unwrap();
        let before = history.len().checked_sub(2).and_then(|i| history[i].clone());
        let fell_back = kind == RecordKind::State && before.is_some() && loaded == before;
        assert!(loaded == *newest || fell_back, "{kind:?} after {context}: {loaded:?}");
    }
}

fn rotten(flash: &Flash<8, 512>, at: usize, how: u8) -> Flash<8, 512> {
    let mut flash = flash.clone();
    let byte = &mut flash.bytes[at];
    *byte = match how {
        0 => *byte ^ 1 << (at % 8),
        1 => 0xff,
        2 => 0,
        _ => !*byte,
    };
    flash
}

#[test]
fn any_byte_may_rot_while_the_power_is_off() {
    let mut tried = 0_u32;
    // First saves, and steps before to after an erasure for each kind.
    for steps in [1, 2, 3, 4, 5, 6, 16, 17, 18, 19, 23, 24, 25] {
        let (flash, histories) = histories(3, steps);
        for at in 512..flash.bytes.len() {
            let how = u8::try_from((at + steps) % 4).unwrap();
            let context = format!("byte {at}, {how}, after {steps} steps");
            let mut store = open(rotten(&flash, at, how), 1);
            assert_recent(&mut store, &histories, &context);
            tried += 1;
        }
    }
    println!("{tried} rotten bytes, none lost a record");
}

#[test]
fn any_byte_may_rot_while_the_store_is_open_and_pages_are_erased() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for run in 0..1000 {
        let (mut flash, mut histories) = histories(2 + run % 2, run % 28);
        let at = random.random_range(512..flash.bytes.len());
        flash.rot = Some((random.random_range(1..400), at, random.random_range(1..=255)));
        let context = format!("rot {:?} in run {run}", flash.rot);
        let mut store = open(flash, 1);
        for number in 40..48 {
            assert_recent(&mut store, &histories, &context);
            let kind = KINDS[usize::from(random.random_ratio(3, 4))];
            let next = save(kind, number, 60);
            perform(&mut store, &next).unwrap();
            histories[usize::from(kind == RecordKind::State)].push(next.payload);
        }
        let mut store = open(store.close(), 1);
        assert_recent(&mut store, &histories, &context);
    }
}

#[test]
fn transient_read_errors_never_yield_a_wrong_record() {
    let (mut flash, histories) = histories(3, 20);
    flash.flaky = Some(6);
    let (mut right, mut other) = (0, 0);
    for seed in 0..2000 {
        flash.random = ChaCha8Rng::seed_from_u64(seed);
        let mut store = open(flash.clone(), 1);
        for (kind, history) in KINDS.into_iter().zip(&histories) {
            match load(&mut store, kind) {
                Ok(loaded) if loaded == *history.last().unwrap() => right += 1,
                Ok(loaded) => {
                    assert!(history.contains(&loaded));
                    other += 1;
                }
                Err(error) => assert_eq!(error, LoadError::Unstable),
            }
        }
    }
    assert!(right > 100 && other > 0, "{right} {other}: neither is rare");
}
