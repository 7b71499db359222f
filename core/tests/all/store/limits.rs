//! Refusals, wear and size of the store.

use crc::{CRC_32_ISO_HDLC, Crc};
use stereo_selfcal::store::{LoadError, OpenError, RecordKind, SaveError, Store};
use test_support::flash::{Fault, Flash};

use crate::store::rig::{Content, KINDS, content, load, open, payload, perform, save};

type Small = Flash<8, 512>;

#[test]
fn ranges_without_two_aligned_pages_are_refused() {
    let refused = |range, page| {
        let flash = Small::new(8, 1);
        Store::open(flash, range, page).map(|_| ()).unwrap_err()
    };
    assert_eq!(refused(0..5000, 512), OpenError::OutOfBounds);
    #[allow(clippy::reversed_empty_ranges, reason = "what is refused")]
    let backwards = 1024..512;
    assert_eq!(refused(backwards, 512), OpenError::OutOfBounds);
    assert_eq!(refused(0..1024, 0), OpenError::TooFewPages);
    assert_eq!(refused(0..512, 512), OpenError::TooFewPages);
    assert_eq!(refused(0..1536, 1024), OpenError::TooFewPages);
    assert_eq!(refused(8..1032, 512), OpenError::Unaligned);
    assert_eq!(refused(0..2000, 1000), OpenError::Unaligned);
    assert_eq!(refused(0..2560, 1024), OpenError::Unaligned);
    assert!(Store::open(Small::new(8, 1), 512..4096, 512).is_ok());
    assert!(Store::open(Small::new(8, 1), 0..4096, 2048).is_ok());
}

#[test]
fn a_record_that_does_not_fit_a_page_twice_is_refused_before_any_write() {
    let mut store = open(Small::new(3, 1), 1);
    // Two entries of 60 + 28 bytes in words of 8 take 176; two of 168 remain, each with 140 of payload.
    store.save(RecordKind::Factory, &payload(1, 60)).unwrap();
    let before = store.wear();
    let refused = store.save(RecordKind::State, &payload(2, 141)).unwrap_err();
    assert_eq!(refused, SaveError::TooLarge { needed: 528, page: 512 });
    let refused = store.save(RecordKind::State, &vec![0; 65_536]).unwrap_err();
    assert_eq!(refused, SaveError::TooLarge { needed: 65_536, page: 512 });
    assert_eq!(store.wear(), before);
    for number in 0..20 {
        store.save(RecordKind::State, &payload(number, 140)).unwrap();
    }
    assert_eq!(load(&mut store, RecordKind::Factory), Ok(Some(payload(1, 60))));
}

#[test]
fn the_largest_payload_is_saved() {
    let mut store = open(Flash::<32, 0x2_1000>::new(3, 1), 1);
    let large = payload(1, 65_535);
    store.save(RecordKind::State, &large).unwrap();
    let mut buffer = vec![0; 70_000];
    assert_eq!(store.load(RecordKind::State, &mut buffer), Ok(Some(&large[..])));
    let refused = store.load(RecordKind::State, &mut buffer[..65_534]);
    assert_eq!(refused, Err(LoadError::BufferTooSmall { needed: 65_535 }));
}

#[test]
fn a_removed_kind_stays_removed_and_the_other_kind_stays() {
    let mut store = open(Small::new(3, 1), 1);
    perform(&mut store, &save(RecordKind::Factory, 1, 50)).unwrap();
    perform(&mut store, &save(RecordKind::State, 2, 90)).unwrap();
    store.remove(RecordKind::State).unwrap();
    let before = store.wear();
    store.remove(RecordKind::State).unwrap();
    assert_eq!(store.wear(), before, "there is no record to remove");
    let mut held = Content { factory: Some(payload(1, 50)), state: None };
    assert_eq!(content(&mut store), held);
    // Enough saves to erase every page.
    for number in 3..20 {
        let step = save(RecordKind::Factory, number, 90);
        perform(&mut store, &step).unwrap();
        held = held.after(&step);
        store = open(store.close(), 1);
        assert_eq!(content(&mut store), held);
    }
}

#[test]
fn a_formatted_store_is_empty() {
    let mut store = open(Small::new(3, 1), 1);
    for kind in KINDS {
        store.save(kind, b"something").unwrap();
    }
    let mut store = Store::format(store.close(), 512..1536, 512).unwrap();
    assert_eq!(content(&mut store), Content::default());
    assert_eq!(store.wear().damaged, 0);
}

#[test]
fn records_of_another_layout_are_not_overwritten() {
    let mut store = open(Small::new(3, 1), 1);
    store.save(RecordKind::State, b"something").unwrap();
    let mut flash = store.close();
    // Header of layout 2 at the start of the range, address 512.
    flash.bytes[512 + 3] = 2;
    let address = 512_u32.to_le_bytes();
    let summed = [&flash.bytes[512..512 + 20], &address].concat();
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&summed);
    flash.bytes[512 + 20..512 + 24].copy_from_slice(&crc.to_le_bytes());
    let refused = Store::open(flash.clone(), 512..1536, 512).map(|_| ()).unwrap_err();
    assert_eq!(refused, OpenError::UnsupportedLayout);
    assert!(Store::format(flash, 512..1536, 512).is_ok());
}

#[test]
fn a_worn_out_page_is_skipped_and_without_another_the_records_stay() {
    for (pages, says_so) in [2, 3, 4].into_iter().flat_map(|n| [(n, true), (n, false)]) {
        let mut store = open(Small::new(1 + pages, 1), 1);
        perform(&mut store, &save(RecordKind::Factory, 1, 50)).unwrap();
        let mut flash = store.close();
        flash.worn = Some((2, says_so));
        let mut store = open(flash, 1);
        let mut held = Content { factory: Some(payload(1, 50)), state: None };
        let mut failed = 0;
        for number in 2..20 {
            let step = save(RecordKind::State, number, 90);
            match perform(&mut store, &step) {
                Ok(()) => held = held.after(&step),
                Err(error) => {
                    let worn = SaveError::Flash(Fault::Worn);
                    assert_eq!(error, if says_so { worn } else { SaveError::VerifyFailed });
                    failed += 1;
                }
            }
            assert_eq!(content(&mut store), held);
            store = open(store.close(), 1);
            assert_eq!(content(&mut store), held);
        }
        assert_eq!(failed > 0, pages == 2, "{pages} pages");
    }
}

#[test]
fn records_unreadable_at_open_are_not_overwritten() {
    let mut store = open(Small::new(3, 1), 1);
    let factory = save(RecordKind::Factory, 1, 50);
    perform(&mut store, &factory).unwrap();
    let flash = store.close();
    let is_deaf = flash.is_deaf.clone();
    is_deaf.set(true);
    let mut store = open(flash, 1);
    assert_eq!(load(&mut store, RecordKind::Factory), Err(LoadError::Flash(Fault::Deaf)));
    is_deaf.set(false);
    let state = save(RecordKind::State, 2, 50);
    perform(&mut store, &state).unwrap();
    assert_eq!(content(&mut store), Content::default().after(&factory).after(&state));
}

/// Places of the headers of entries in flash with pages of 512 bytes.
fn headers(flash: &Small) -> Vec<usize> {
    (512..flash.bytes.len() - 24).filter(|at| flash.bytes[*at..].starts_with(b"SSC\x01")).collect()
}

fn sequence_number(header: &[u8]) -> u64 {
    u64::from_le_bytes(header[4..12].try_into().unwrap())
}

#[test]
fn sequence_numbers_of_healthy_flash_follow_each_other_over_restarts() {
    let mut store = open(Small::new(3, 1), 1);
    let mut last = 0;
    for number in 0..30 {
        store.save(RecordKind::State, &payload(number, 80)).unwrap();
        let flash = store.close();
        let newest =
            headers(&flash).into_iter().map(|at| sequence_number(&flash.bytes[at..])).max();
        let step = newest.unwrap() - last;
        // Once both pages have entries. A turn of the page numbers its copies too.
        assert!(number < 8 || (1..=4).contains(&step), "{number}: {step}");
        last += step;
        store = open(flash, 1);
    }
}

/// Adds to the sequence number of every entry in flash with pages of 512 bytes.
fn renumber(flash: &mut Small, by: u64) {
    for at in headers(flash) {
        let entry = &mut flash.bytes[at..at + 24];
        let number = sequence_number(entry).wrapping_add(by);
        entry[4..12].copy_from_slice(&number.to_le_bytes());
        let summed = [&entry[..20], &u32::try_from(at).unwrap().to_le_bytes()].concat();
        let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&summed);
        entry[20..].copy_from_slice(&crc.to_le_bytes());
    }
}

#[test]
fn sequence_numbers_wrap() {
    for steps in [3, 8, 20] {
        // Also where the numbers of one page lie on both sides.
        for by in (0..60).map(|n| u64::MAX - n).chain([1 << 63, (1 << 63) - 1, u64::MAX / 4 * 3]) {
            let mut store = open(Small::new(3, 1), 1);
            let mut held = Content::default();
            for step in crate::store::rig::scenario(30, 90).into_iter().take(steps) {
                perform(&mut store, &step).unwrap();
                held = held.after(&step);
            }
            let mut flash = store.close();
            renumber(&mut flash, by);
            let mut store = open(flash, 1);
            assert_eq!(content(&mut store), held, "{by} after {steps}");
            for number in 40..60 {
                let step = save(KINDS[usize::from(number % 5 != 0)], number, 80);
                perform(&mut store, &step).unwrap();
                held = held.after(&step);
                store = open(store.close(), 1);
                assert_eq!(content(&mut store), held, "{by} after {steps}");
            }
        }
    }
}

#[test]
fn pages_wear_evenly_and_last_as_documented() {
    let mut store = open(Flash::<32, 0x2_0000>::new(3, 1), 1);
    store.save(RecordKind::Factory, &[1; 1024]).unwrap();
    let saves = 600_u32;
    for _ in 0..saves {
        store.save(RecordKind::State, &[2; 2048]).unwrap();
    }
    let wear = store.wear();
    let flash = store.close();
    assert_eq!(flash.erased, [0, 5, 5]);
    assert_eq!((wear.erasures, wear.pages, wear.damaged), (10, 2, 0));
    let wear = open(flash, 1).wear();
    assert_eq!((wear.erasures, wear.pages, wear.damaged), (10, 2, 0));
    println!("{} saves an erasure", saves / wear.erasures);
}

#[test]
fn a_store_takes_an_eighth_of_a_kib_beside_its_driver() {
    let bytes = size_of::<Store<Small>>() - size_of::<Small>();
    println!("{bytes} bytes");
    assert!(bytes <= 128);
}

#[test]
fn free_bytes_are_exact() {
    let mut store = open(Small::new(3, 1), 1);
    assert_eq!((store.wear().free, store.wear().erasures), (0, 0));
    store.save(RecordKind::State, &payload(0, 4)).unwrap();
    // Two entries of 32 bytes.
    // The last 8 bytes are for a mark.
    assert_eq!((store.wear().free, store.wear().erasures), (440, 1));
    for number in 1..14 {
        store.save(RecordKind::State, &payload(number, 4)).unwrap();
    }
    assert_eq!((store.wear().free, store.wear().erasures), (24, 1));
    store.save(RecordKind::State, &payload(14, 4)).unwrap();
    assert_eq!((store.wear().free, store.wear().erasures), (440, 2));
}
