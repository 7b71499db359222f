//! Flash with arbitrary content.

use std::collections::BTreeSet;

use proptest::prelude::*;
use stereo_selfcal::store::RecordKind;
use test_support::flash::Flash;

use crate::store::rig::{KINDS, content, load, open, payload, perform, save, scenario};

const BYTES: usize = 4 * 256;

/// Flash after the first `steps` of the scenario, and every payload saved.
fn used(steps: usize) -> (Vec<u8>, BTreeSet<Vec<u8>>) {
    let mut store = open(Flash::<4, 256>::new(4, 5), 1);
    let mut ever = BTreeSet::new();
    for step in scenario(20, 50).into_iter().take(steps) {
        perform(&mut store, &step).unwrap();
        ever.extend(step.payload);
    }
    (store.close().bytes, ever)
}

/// Damage to used flash.
#[derive(Debug, Clone)]
enum Damage {
    Move { from: usize, to: usize, bytes: usize },
    Fill { at: usize, bytes: usize, with: u8 },
    Noise { at: usize, noise: Vec<u8> },
}

fn damage() -> impl Strategy<Value = Damage> {
    let at = 256..BYTES;
    prop_oneof![
        (at.clone(), at.clone(), 1..400_usize).prop_map(|(from, to, bytes)| Damage::Move {
            from,
            to,
            bytes
        }),
        (at.clone(), 1..300_usize, prop_oneof![Just(0xff), any::<u8>()])
            .prop_map(|(at, bytes, with)| Damage::Fill { at, bytes, with }),
        (at, prop::collection::vec(any::<u8>(), 1..100))
            .prop_map(|(at, noise)| Damage::Noise { at, noise }),
    ]
}

fn damaged(mut flash: Vec<u8>, damage: &[Damage]) -> Vec<u8> {
    for damage in damage {
        match damage {
            Damage::Move { from, to, bytes } => {
                let bytes = *bytes.min(&(BYTES - from.max(to)));
                flash.copy_within(*from..from + bytes, *to);
            }
            Damage::Fill { at, bytes, with } => {
                flash[*at..(at + bytes).min(BYTES)].fill(*with);
            }
            Damage::Noise { at, noise } => {
                flash[*at..].iter_mut().zip(noise).for_each(|(byte, noise)| *byte = *noise);
            }
        }
    }
    flash
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(test_support::runs(400, 2000)))]
    #[test]
    fn only_saved_records_are_found_and_saves_work_on_any_flash(
        steps in 0..28_usize,
        damage in prop::collection::vec(damage(), 0..6),
    ) {
        let (flash, ever) = used(steps);
        let mut store = open(Flash::<4, 256>::of(damaged(flash, &damage), 1), 1);
        let held = content(&mut store);
        for kind in KINDS {
            if let Some(found) = held.of(kind) {
                prop_assert!(ever.contains(found), "{kind:?}: {found:?}");
            }
        }
        let next = save(RecordKind::State, 50, 40);
        if perform(&mut store, &next).is_ok() {
            let now = content(&mut store);
            prop_assert_eq!(&now.state, &next.payload);
            // After several faults an older record may be found.
            prop_assert_eq!(now.factory.is_some(), held.factory.is_some());
            prop_assert!(now.factory.is_none_or(|found| ever.contains(&found)));
        }
    }

    #[test]
    fn noise_is_an_empty_store(noise in prop::collection::vec(any::<u8>(), BYTES)) {
        let mut store = open(Flash::<4, 256>::of(noise, 1), 1);
        prop_assert_eq!(load(&mut store, RecordKind::Factory), Ok(None));
        prop_assert_eq!(load(&mut store, RecordKind::State), Ok(None));
        perform(&mut store, &save(RecordKind::State, 1, 90)).unwrap();
        prop_assert_eq!(load(&mut store, RecordKind::State), Ok(Some(payload(1, 90))));
    }
}

#[test]
fn records_inside_a_payload_are_not_found_when_its_own_header_is_damaged() {
    // The payload is the content of another store: its entries are intact, but at other addresses.
    let (inner, _) = used(7);
    let mut store = open(Flash::<4, 4096>::new(3, 6), 1);
    store.save(RecordKind::State, b"the one before").unwrap();
    store.save(RecordKind::State, &inner[256..]).unwrap();
    let mut flash = store.close();
    let start = flash.bytes.windows(8).position(|w| *w == inner[256..264]).unwrap();
    flash.bytes[start - 1] ^= 1;
    let mut store = open(flash, 1);
    assert_eq!(load(&mut store, RecordKind::State), Ok(Some(b"the one before".to_vec())));
    assert_eq!(load(&mut store, RecordKind::Factory), Ok(None));
}
