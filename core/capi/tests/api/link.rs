//! Bytes of a wire give the same bits through C as through Rust.

use std::mem::MaybeUninit;

use proptest::prelude::*;
use rigs::data::Dataset;
use sim::wire::{Faults, FaultyWire, Sender};
use stereo_selfcal::link::{Counters, Decoder};
use stereo_selfcal::{Calibrator, Config, FactoryCalibration, State};
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::life::{Twin, take_pair, twins};
use crate::rig::{Cal, Observed, advance, at_work, begin, defaults, finish, get, recorded};

/// Storage on the heap, zeroed as static storage of C.
pub(crate) struct Link(Box<MaybeUninit<selfcal_link_t>>);

/// Results of a feed: error, bytes used, frame.
pub(crate) type Fed = (selfcal_error_t, usize, selfcal_frame_t);

impl Link {
    pub(crate) fn zeroed() -> Self {
        Self(Box::new(MaybeUninit::zeroed()))
    }

    pub(crate) fn new() -> Self {
        let mut link = Self::zeroed();
        // SAFETY: live storage of that size.
        let code = unsafe { selfcal_link_init(link.ptr(), SELFCAL_LINK_STORAGE_SIZE) };
        assert_eq!(code, SELFCAL_OK);
        link
    }

    pub(crate) fn ptr(&mut self) -> *mut selfcal_link_t {
        self.0.as_mut_ptr()
    }

    pub(crate) fn feed(&mut self, cal: &mut Cal, bytes: &[u8]) -> Fed {
        feed(self.ptr(), cal.ptr(), bytes)
    }

    pub(crate) fn counters(&mut self) -> selfcal_link_counters_t {
        get!(self, selfcal_link_counters).unwrap()
    }

    pub(crate) fn bytes(&mut self) -> &mut [u8] {
        // SAFETY: live storage, in which every byte has been written.
        unsafe { std::slice::from_raw_parts_mut(self.ptr().cast(), SELFCAL_LINK_STORAGE_SIZE) }
    }
}

/// Feeds bytes. The places for the results hold other values before the call.
pub(crate) fn feed(link: *mut selfcal_link_t, cal: *mut selfcal_t, bytes: &[u8]) -> Fed {
    let (mut used, mut frame) = (usize::MAX, selfcal_frame_t { whole: true, ..NONE });
    // SAFETY: live bytes and places; the others are live, or under test.
    let code =
        unsafe { selfcal_link_feed(link, cal, bytes.as_ptr(), bytes.len(), &mut used, &mut frame) };
    (code, used, frame)
}

pub(crate) const NONE: selfcal_frame_t = selfcal_frame_t {
    timestamp_us: 0,
    sequence: 0,
    count: 0,
    taken: 0,
    whole: false,
    dropped_before: false,
    more_found: false,
    reserved: 0,
};

pub(crate) fn frame(set: &Dataset, sequence: u32) -> Vec<u8> {
    let index = usize::try_from(sequence).unwrap() % set.pairs.len();
    Sender::of(set).unwrap().frame(sequence, &set.pairs[index]).0
}

fn assert_same_counters(c: &selfcal_link_counters_t, rust: &Counters) {
    // The fields have the names and the order of the core.
    assert_eq!(
        format!("{c:?}").replace("selfcal_link_counters_t", "Counters"),
        format!("{rust:?}")
    );
}

/// Feeds all bytes of a piece to both, and compares the results; returns the number of whole frames.
fn feed_both(c: (&mut Link, &mut Cal), rust: (&mut Decoder, &mut Twin), piece: &[u8]) -> usize {
    let ((link, cal), (decoder, twin)) = (c, rust);
    let (mut piece, mut frames) = (piece, 0);
    while !piece.is_empty() {
        let (code, used, frame) = link.feed(cal, piece);
        let mut left = piece;
        let received = decoder.feed(&mut left, twin);
        assert_eq!(used, piece.len() - left.len());
        match received {
            Err(refusal) => assert_eq!((code, frame), (refusal.into(), NONE)),
            Ok(None) => assert_eq!((code, frame), (SELFCAL_OK, NONE)),
            Ok(Some(received)) => {
                let header = received.header;
                let expected = selfcal_frame_t {
                    timestamp_us: header.timestamp_us,
                    sequence: header.sequence,
                    count: header.count.into(),
                    taken: received.taken.try_into().unwrap(),
                    whole: true,
                    dropped_before: header.dropped_before,
                    more_found: header.more_found,
                    reserved: 0,
                };
                assert_eq!((code, frame), (SELFCAL_OK, expected));
                take_pair(cal, twin);
                frames += 1;
            }
        }
        piece = left;
    }
    frames
}

#[test]
fn a_damaged_stream_is_bit_identical_to_rust() {
    let set = recorded();
    let faults = Faults { damaged: 0.3, dropped: 0.1, repeated: 0.1, noise_after: 0.3 };
    let mut wire = FaultyWire::new(faults, 0x11);
    let mut bytes = Vec::new();
    for sequence in 0..40 {
        wire.send(&frame(&set, sequence), &mut bytes);
    }
    let (mut cal, mut twin) = twins(&set, &defaults(), Config::default());
    let (mut link, mut decoder) = (Link::new(), Decoder::new());
    let (mut frames, mut at) = (0, 0);
    for length in [1, 7, 64, 255, 1024, 9000].into_iter().cycle() {
        let piece = &bytes[at..bytes.len().min(at + length)];
        frames += feed_both((&mut link, &mut cal), (&mut decoder, &mut twin), piece);
        at += piece.len();
        if at == bytes.len() {
            break;
        }
    }
    let counters = link.counters();
    assert_same_counters(&counters, decoder.counters());
    assert_eq!(usize::try_from(counters.good).unwrap(), frames);
    assert!(frames > 20 && counters.gaps > 5 && counters.repeats > 0, "{counters:?}");
    assert!(counters.bad_crc > 3 && counters.skipped_bytes > 0, "{counters:?}");
    assert_eq!(twin.state(), State::Locked);
}

#[test]
fn bytes_after_a_whole_frame_are_left_for_the_next_call() {
    let set = recorded();
    let (mut cal, mut link) = (Cal::of(&set, None), Link::new());
    let [first, second] = [frame(&set, 0), frame(&set, 1)];
    let bytes = [&first[..], &second[..]].concat();
    let (code, used, whole) = link.feed(&mut cal, &bytes);
    assert_eq!((code, used, whole.whole, whole.sequence), (SELFCAL_OK, first.len(), true, 0));
    assert_eq!(whole.count, u32::try_from(set.pairs[0].len()).unwrap());
    assert_eq!(whole.taken, get!(cal, selfcal_batch).unwrap().held);
    let (code, used, whole) = link.feed(&mut cal, &bytes[used..]);
    assert_eq!((code, used, whole.sequence), (SELFCAL_OK, second.len(), 1));
    assert_eq!(link.feed(&mut cal, &[]), (SELFCAL_OK, 0, NONE));
}

#[test]
fn a_pair_being_solved_keeps_its_batch_and_no_byte_is_used() {
    let set = recorded();
    let (mut cal, mut link) = (Cal::of(&set, None), Link::new());
    link.feed(&mut cal, &frame(&set, 0));
    begin(&mut cal);
    let (before, next) = (Observed::of(&mut cal), frame(&set, 1));
    assert_eq!(link.feed(&mut cal, &next), (SELFCAL_ERROR_BUSY, 0, NONE));
    assert_eq!(Observed::of(&mut cal), before);
    finish(&mut cal).unwrap();
    let (code, used, whole) = link.feed(&mut cal, &next);
    assert_eq!((code, used, whole.sequence), (SELFCAL_OK, next.len(), 1));
    assert_eq!((link.counters().good, link.counters().refused), (2, 0));
}

#[test]
fn a_pair_begun_in_the_middle_of_a_frame_is_refused_and_the_frame_goes_on() {
    let set = recorded();
    let (mut cal, mut link) = (Cal::of(&set, None), Link::new());
    let (first, rest) = (&frame(&set, 0)[..2000], &frame(&set, 0)[2000..]);
    assert_eq!(link.feed(&mut cal, first), (SELFCAL_OK, 2000, NONE));
    assert_eq!(get!(cal, selfcal_batch).unwrap().held, 0, "hidden until the frame is whole");
    assert_eq!(advance(&mut cal), (true, Err(SELFCAL_ERROR_TOO_FEW)));
    let (code, used, whole) = link.feed(&mut cal, rest);
    assert_eq!((code, used, whole.whole), (SELFCAL_OK, rest.len(), true));
    assert_eq!(get!(cal, selfcal_batch).unwrap().offered, whole.count);
    begin(&mut cal);
}

#[test]
fn a_refused_frame_leaves_the_batch_and_the_next_one_is_decoded() {
    let set = recorded();
    let (mut cal, mut link) = (at_work(), Link::new());
    let (before, size) = (Observed::of(&mut cal), [set.meta.width, set.meta.height + 1]);
    let other = Sender::new(size, []).unwrap().frame(7, &set.pairs[0]).0;
    let (code, used, whole) = link.feed(&mut cal, &other);
    assert_eq!((code, whole), (SELFCAL_ERROR_IMAGE_SIZE, NONE));
    // The header is used; the rest is skipped.
    assert_eq!(link.feed(&mut cal, &other[used..]), (SELFCAL_OK, other.len() - used, NONE));
    assert_eq!(Observed::of(&mut cal), before);
    assert!(link.feed(&mut cal, &frame(&set, 8)).2.whole);
    assert_eq!((link.counters().refused, link.counters().good), (1, 1));
}

#[test]
fn a_frame_replaces_the_batch_and_a_damaged_one_leaves_none() {
    let set = recorded();
    let whole = frame(&set, 6);
    let mut damaged = whole.clone();
    *damaged.last_mut().unwrap() ^= 1;
    for (bytes, held) in [(&whole[..32], false), (&whole, true), (&damaged, false)] {
        let (mut cal, mut link) = (at_work(), Link::new());
        assert_eq!(link.feed(&mut cal, bytes).0, SELFCAL_OK);
        assert_eq!(get!(cal, selfcal_batch).unwrap().held > 0, held);
    }
}

#[test]
fn overruns_are_counted_and_init_restarts_a_link() {
    let set = recorded();
    let (mut cal, mut link) = (Cal::of(&set, None), Link::new());
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_link_note_overrun(link.ptr()) }, SELFCAL_OK);
    link.feed(&mut cal, &frame(&set, 0)[..1000]);
    assert_eq!(link.counters().overruns, 1);
    // SAFETY: live storage of that size.
    let code = unsafe { selfcal_link_init(link.ptr(), SELFCAL_LINK_STORAGE_SIZE) };
    assert_eq!(code, SELFCAL_OK);
    assert_same_counters(&link.counters(), Decoder::new().counters());
    assert_eq!(link.feed(&mut cal, &frame(&set, 1)).2.sequence, 1);
    assert_eq!(link.counters().bad_crc, 0, "the previous frame is dropped");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_bytes_are_used_as_by_rust(
        bytes in prop::collection::vec(prop_oneof![Just(b'S'), Just(b'C'), any::<u8>()], 0..300),
    ) {
        let (mut cal, mut link) = (Cal::new(), Link::new());
        let mut decoder = Decoder::new();
        prop_assert_eq!(link.feed(&mut cal, &bytes), (SELFCAL_OK, bytes.len(), NONE));
        let factory = FactoryCalibration::guess(recorded().cameras().unwrap());
        let mut twin = Box::new(Calibrator::<f32, 8>::new(Config::default(), &factory));
        prop_assert_eq!(decoder.feed(&mut bytes.as_slice(), &mut *twin), Ok(None));
        assert_same_counters(&link.counters(), decoder.counters());
    }
}
