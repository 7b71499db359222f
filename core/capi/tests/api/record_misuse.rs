//! Records and buffers that are not valid return their errors and change nothing.

use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use proptest::prelude::*;
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::misuse::{place, refused};
use crate::record::{Read, Write, read, record, restore, snapshot};
use crate::rig::{Cal, Observed, at_work, config, recorded};

const WRITERS: [(Write, usize); 2] = [
    (selfcal_snapshot, SELFCAL_SNAPSHOT_BYTES),
    (selfcal_factory_to_record, SELFCAL_FACTORY_BYTES),
];
const READERS: [Read; 2] = [selfcal_restore, selfcal_factory_from_record];

#[test]
fn pointers_are_checked_first() {
    let mut cal = at_work();
    let byte: *mut u8 = place::<[u8; SELFCAL_SNAPSHOT_BYTES]>().cast();
    // SAFETY: live objects, null, or refused by its length.
    unsafe {
        for (write, _) in WRITERS {
            refused(&mut cal, SELFCAL_ERROR_NULL, |cal| write(cal, null_mut()));
        }
        for read in READERS {
            refused(&mut cal, SELFCAL_ERROR_NULL, |cal| read(cal, null(), 1));
            refused(&mut cal, SELFCAL_ERROR_COUNT, |cal| read(cal, byte, usize::MAX));
        }
    }
}

#[test]
fn a_record_needs_cameras() {
    let mut cal = Cal::new(None);
    for (write, most) in WRITERS {
        assert_eq!(record(&mut cal, write, most), Err(SELFCAL_ERROR_NO_CAMERAS));
    }
    assert_eq!(restore(&mut cal, &snapshot(&mut at_work())), SELFCAL_ERROR_NO_CAMERAS);
}

/// A record with one byte changed and a right checksum.
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
    let mut learnt = at_work();
    let kept = snapshot(&mut learnt);
    let factory = record(&mut learnt, selfcal_factory_to_record, SELFCAL_FACTORY_BYTES).unwrap();
    let mut flipped = kept.clone();
    flipped[100] ^= 1;
    let mut cal = Cal::of(&set, None);
    for (bytes, code) in [
        (&[][..], SELFCAL_ERROR_RESTORE_DAMAGED),
        (&[0xff; SELFCAL_SNAPSHOT_BYTES], SELFCAL_ERROR_RESTORE_DAMAGED),
        (&flipped, SELFCAL_ERROR_RESTORE_DAMAGED),
        (&kept[..kept.len() - 1], SELFCAL_ERROR_RESTORE_DAMAGED),
        (&[&kept[..], &[0]].concat(), SELFCAL_ERROR_RESTORE_DAMAGED),
        (&factory, SELFCAL_ERROR_RESTORE_FOREIGN),
        (&resealed(&kept, 4, 99), SELFCAL_ERROR_RESTORE_LAYOUT),
        // The highest byte of the first number, of the turn in use.
        (&resealed(&kept, 23, 0x7f), SELFCAL_ERROR_RESTORE_ABSURD),
    ] {
        refused(&mut cal, code, |cal| {
            // SAFETY: live objects.
            unsafe { selfcal_restore(cal, bytes.as_ptr(), bytes.len()) }
        });
    }
    for (bytes, code) in [
        (&kept[..], SELFCAL_ERROR_RESTORE_FOREIGN),
        (&factory[1..], SELFCAL_ERROR_RESTORE_DAMAGED),
        (&resealed(&factory, 11, 0x7f), SELFCAL_ERROR_RESTORE_ABSURD),
    ] {
        refused(&mut cal, code, |cal| {
            // SAFETY: live objects.
            unsafe { selfcal_factory_from_record(cal, bytes.as_ptr(), bytes.len()) }
        });
    }
    assert_eq!(restore(&mut cal, &kept), SELFCAL_OK);
}

#[test]
fn a_record_of_another_rig_or_beyond_the_limit_is_refused() {
    let set = recorded();
    let kept = snapshot(&mut at_work());
    let mut other = Cal::of(&set, None);
    let factory = selfcal_extrinsics_t {
        rotation: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        translation: [-1.0, 1e-4, 0.0],
    };
    // SAFETY: live objects.
    assert_eq!(unsafe { selfcal_set_factory(other.ptr(), &factory) }, SELFCAL_OK);
    assert_eq!(restore(&mut other, &kept), SELFCAL_ERROR_RESTORE_OTHER_RIG);

    let mut strict = config(selfcal_config_default);
    // SAFETY: a live configuration.
    assert_eq!(unsafe { selfcal_config_set_max_correction_rad(&mut strict, 1e-5) }, SELFCAL_OK);
    let mut strict = Cal::of(&set, Some(&strict));
    let before = Observed::of(&mut strict);
    assert_eq!(restore(&mut strict, &kept), SELFCAL_ERROR_RESTORE_CONFIG);
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
            for reader in READERS {
                prop_assert_eq!(read(&mut cal, reader, bytes), SELFCAL_ERROR_RESTORE_DAMAGED);
            }
        }
        prop_assert_eq!(Observed::of(&mut cal), before);
    }
}
