//! Records and buffers that are not valid return their errors. A refused record resets the calibrator, which changes
//! nothing in these tests, because the calibrator has taken no pair.

use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use proptest::prelude::*;
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::misuse::{place, refused};
use crate::record::{from_record, restore, snapshot, to_record};
use crate::rig::{Cal, Observed, at_work, defaults, factory, recorded};

#[test]
fn pointers_are_checked_first() {
    let mut cal = at_work();
    let byte: *mut u8 = place::<[u8; SELFCAL_SNAPSHOT_BYTES]>().cast();
    let given = factory(&recorded());
    // SAFETY: live objects, null, or refused by its length.
    unsafe {
        refused(&mut cal, SELFCAL_ERROR_NULL, |cal| selfcal_snapshot(cal, null_mut()));
        refused(&mut cal, SELFCAL_ERROR_NULL, |cal| selfcal_restore(cal, null(), 1));
        refused(&mut cal, SELFCAL_ERROR_VALUE, |cal| selfcal_restore(cal, byte, usize::MAX));
        let codes = [
            selfcal_factory_to_record(null(), byte),
            selfcal_factory_to_record(&given, null_mut()),
            selfcal_factory_from_record(null_mut(), byte, 1),
            selfcal_factory_from_record(place(), null(), 1),
        ];
        assert_eq!(codes, [SELFCAL_ERROR_NULL; 4]);
        let blind = selfcal_factory_t { is_guess: 7, ..given };
        assert_eq!(selfcal_factory_to_record(&blind, byte), SELFCAL_ERROR_FACTORY);
    }
}

/// A record with one byte changed and a correct checksum.
fn resealed(record: &[u8], at: usize, byte: u8) -> Vec<u8> {
    let mut record = record.to_vec();
    record[at] = byte;
    let body = record.len() - 4;
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&record[..body]);
    record[body..].copy_from_slice(&crc.to_le_bytes());
    record
}

#[test]
fn a_record_of_another_kind_returns_its_error_and_changes_nothing() {
    let set = recorded();
    let kept = snapshot(&mut at_work());
    let factory = to_record(&factory(&set));
    let mut flipped = kept.clone();
    flipped[100] ^= 1;
    let mut cal = Cal::of(&set, None);
    for (bytes, code) in [
        (&[][..], SELFCAL_ERROR_RECORD_DAMAGED),
        (&[0xff; SELFCAL_SNAPSHOT_BYTES], SELFCAL_ERROR_RECORD_DAMAGED),
        (&flipped, SELFCAL_ERROR_RECORD_DAMAGED),
        (&kept[..kept.len() - 1], SELFCAL_ERROR_RECORD_DAMAGED),
        (&[&kept[..], &[0]].concat(), SELFCAL_ERROR_RECORD_DAMAGED),
        (&factory, SELFCAL_ERROR_RECORD_FOREIGN),
        (&resealed(&kept, 4, 99), SELFCAL_ERROR_RECORD_LAYOUT),
        // The highest byte of the first number of the turn of `R` in use.
        (&resealed(&kept, 23, 0x7f), SELFCAL_ERROR_RECORD_ABSURD),
    ] {
        refused(&mut cal, code, |cal| {
            // SAFETY: live objects.
            unsafe { selfcal_restore(cal, bytes.as_ptr(), bytes.len()) }
        });
    }
    for (bytes, code) in [
        (&kept[..], SELFCAL_ERROR_RECORD_FOREIGN),
        (&factory[1..], SELFCAL_ERROR_RECORD_DAMAGED),
        (&resealed(&factory, 11, 0x7f), SELFCAL_ERROR_RECORD_ABSURD),
    ] {
        assert_eq!(from_record(bytes), Err(code));
    }
    assert_eq!(restore(&mut cal, &kept), SELFCAL_OK);
}

#[test]
fn a_record_of_another_rig_or_beyond_the_limit_is_refused() {
    let set = recorded();
    let kept = snapshot(&mut at_work());
    let extrinsics = selfcal_extrinsics_t {
        rotation: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        translation: [-1.0, 1e-4, 0.0],
    };
    let mut other = Cal::made(None, &selfcal_factory_t { extrinsics, ..factory(&set) });
    assert_eq!(restore(&mut other, &kept), SELFCAL_ERROR_RECORD_OTHER_RIG);

    let strict = selfcal_config_t { max_correction_rad: 1e-5, ..defaults() };
    let mut strict = Cal::of(&set, Some(&strict));
    let before = Observed::of(&mut strict);
    assert_eq!(restore(&mut strict, &kept), SELFCAL_ERROR_RECORD_CONFIG);
    assert_eq!(Observed::of(&mut strict), before);
}

static KEPT: LazyLock<Vec<u8>> = LazyLock::new(|| snapshot(&mut at_work()));

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_truncated_record_or_arbitrary_bytes_are_refused(
        cut in any::<prop::sample::Index>(), bits in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let mut cal = Cal::of(&recorded(), None);
        let before = Observed::of(&mut cal);
        for bytes in [&KEPT[..cut.index(KEPT.len())], &bits] {
            prop_assert_eq!(restore(&mut cal, bytes), SELFCAL_ERROR_RECORD_DAMAGED);
            prop_assert_eq!(from_record(bytes), Err(SELFCAL_ERROR_RECORD_DAMAGED));
        }
        prop_assert_eq!(Observed::of(&mut cal), before);
    }
}
