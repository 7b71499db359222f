//! Tracked frames give the same joined matches through C as through Rust.

use std::mem::MaybeUninit;
use std::ptr::null_mut;

use rigs::data::Match;
use sim::wire::Sender;
use stereo_selfcal::Config;
use stereo_selfcal::depth::Tracks;
use stereo_selfcal::link::{Decoder, MatchRecord, Tracking};
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::life::{take_pair, twins};
use crate::link::{Link, NONE};
use crate::misuse::{CORRESPONDENCE, place};
use crate::rig::{Cal, at_work, defaults, recorded};

/// Storage on the heap, zeroed as static storage of C.
pub(crate) struct Joined(Box<MaybeUninit<selfcal_tracks_t>>);

impl Joined {
    fn zeroed() -> Self {
        Self(Box::new(MaybeUninit::zeroed()))
    }

    pub(crate) fn new() -> Self {
        let mut tracks = Self::zeroed();
        // SAFETY: live storage of that size.
        let code = unsafe { selfcal_tracks_init(tracks.ptr(), SELFCAL_TRACKS_STORAGE_SIZE) };
        assert_eq!(code, SELFCAL_OK);
        tracks
    }

    pub(crate) fn ptr(&mut self) -> *mut selfcal_tracks_t {
        self.0.as_mut_ptr()
    }
}

fn feed(
    link: &mut Link,
    cal: &mut Cal,
    tracks: *mut selfcal_tracks_t,
    bytes: &[u8],
) -> (selfcal_error_t, usize, selfcal_frame_t) {
    let (mut used, mut frame) = (usize::MAX, NONE);
    let (link, cal, start) = (link.ptr(), cal.ptr(), bytes.as_ptr());
    // SAFETY: live objects; the tracks are live, or under test.
    let code = unsafe {
        selfcal_link_feed_tracked(link, cal, tracks, start, bytes.len(), &mut used, &mut frame)
    };
    (code, used, frame)
}

/// A frame in which the track of each match is its position, from 1.
fn frame(sequence: u32) -> Vec<u8> {
    let set = recorded();
    let pair = &set.pairs[usize::try_from(sequence).unwrap() % set.pairs.len()];
    let tracked: Vec<(Match, u16)> = pair.iter().copied().zip(1..).collect();
    Sender::of(&set).unwrap().tracked_frame(sequence, &tracked).0
}

/// Takes all steps of the tracks.
fn step_by_step(cal: &mut Cal, joined: &mut Joined) -> selfcal_error_t {
    for _ in 0..16 {
        let mut ended = false;
        // SAFETY: live objects; the effect is not wanted.
        let code =
            unsafe { selfcal_advance_tracks(cal.ptr(), joined.ptr(), &mut ended, null_mut()) };
        assert!(ended || code == SELFCAL_OK);
        if ended {
            return code;
        }
    }
    panic!("the steps end");
}

#[test]
fn tracked_frames_are_joined_and_pushed_as_in_rust() {
    let (mut cal, mut twin) = twins(&recorded(), &defaults(), Config::default());
    let (mut link, mut decoder) = (Link::new(), Decoder::new());
    let (mut joined, mut tracks) = (Joined::new(), Tracks::<f32, SELFCAL_CAPACITY>::new());
    let mut results = Vec::new();
    for sequence in 0..12 {
        let bytes = frame(sequence);
        let (code, used, frame) = feed(&mut link, &mut cal, joined.ptr(), &bytes);
        let mut sink = Tracking { calibrator: &mut twin, tracks: Some(&mut tracks) };
        let received = decoder.feed(&mut &bytes[..], &mut sink).unwrap().unwrap();
        assert_eq!((code, used, frame.whole), (SELFCAL_OK, bytes.len(), true));
        assert_eq!(usize::try_from(frame.taken).unwrap(), received.taken);
        take_pair(&mut cal, &mut twin);
        let rust = twin.push_tracks(&mut tracks).map_or_else(Into::into, |_| SELFCAL_OK);
        let c = if sequence % 2 == 0 {
            // SAFETY: live objects; the effect is not wanted.
            unsafe { selfcal_push_tracks(cal.ptr(), joined.ptr(), null_mut()) }
        } else {
            step_by_step(&mut cal, &mut joined)
        };
        assert_eq!(c, rust, "{sequence}");
        results.push((c, tracks.quads().len()));
    }
    assert!(results.iter().any(|(_, quads)| *quads > 20), "{results:?}");
    assert!(results.iter().any(|(c, _)| *c != SELFCAL_ERROR_NOT_LOCKED), "{results:?}");
}

#[test]
fn a_match_is_encoded_with_its_track() {
    let header = selfcal_frame_header_t {
        timestamp_us: 0,
        sequence: 0,
        size_px: [640, 480],
        count: 1,
        grid_step: 0,
        fraction_bits: 8,
        pyramid_ratio: 64,
        flags: 0,
        reserved: 0,
    };
    let mut encoder = MaybeUninit::<selfcal_encoder_t>::zeroed();
    let (at, mut bytes) = (encoder.as_mut_ptr(), [0; MatchRecord::BYTES]);
    // SAFETY: live objects.
    let codes = unsafe {
        [
            selfcal_frame_begin(
                at,
                SELFCAL_ENCODER_STORAGE_SIZE,
                &header,
                place::<[u8; 32]>().cast(),
            ),
            selfcal_frame_tracked_match(at, &CORRESPONDENCE, 0x1234, bytes.as_mut_ptr()),
        ]
    };
    assert_eq!(codes, [SELFCAL_OK; 2]);
    assert_eq!(MatchRecord::from_bytes(&bytes).track(), 0x234);
}

#[test]
fn other_storage_is_refused_and_uses_no_bytes() {
    let mut live = Joined::new();
    let odd = live.ptr().cast::<u8>().wrapping_add(1).cast();
    let (mut link, mut cal, mut zeroed) = (Link::new(), at_work(), Joined::zeroed());
    for (tracks, expected) in [
        (null_mut(), SELFCAL_ERROR_NULL),
        (odd, SELFCAL_ERROR_ALIGNMENT),
        (zeroed.ptr(), SELFCAL_ERROR_NOT_INITIALISED),
    ] {
        assert_eq!(feed(&mut link, &mut cal, tracks, &frame(0)), (expected, 0, NONE));
        // SAFETY: live objects, and the tracks under test.
        let pushed = unsafe { selfcal_push_tracks(cal.ptr(), tracks, place()) };
        assert_eq!(pushed, expected);
    }
    // SAFETY: null, misaligned or live storage.
    let codes = unsafe {
        [
            selfcal_tracks_init(null_mut(), SELFCAL_TRACKS_STORAGE_SIZE),
            selfcal_tracks_init(odd, SELFCAL_TRACKS_STORAGE_SIZE),
            selfcal_tracks_init(live.ptr(), 64),
        ]
    };
    let expected = [SELFCAL_ERROR_NULL, SELFCAL_ERROR_ALIGNMENT, SELFCAL_ERROR_STORAGE_SIZE];
    assert_eq!(codes, expected);
}
