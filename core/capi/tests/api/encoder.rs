//! Frames through C: the test frames in `core/vectors` byte for byte, their counters, and the calls that are refused.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::link::{Link, NONE};
use crate::rig::Cal;

const HEADER: selfcal_frame_header_t = selfcal_frame_header_t {
    timestamp_us: 0,
    sequence: 0,
    size_px: [1920, 1200],
    count: 0,
    grid_step: 256,
    fraction_bits: 4,
    pyramid_ratio: 128,
    flags: 0,
    reserved: 0,
};
const MATCH: selfcal_correspondence_t = selfcal_correspondence_t {
    left_px: [960.0, 600.0],
    right_px: [910.5, 601.25],
    score: 1.0,
    grid_step_px: 1.0,
};

struct Frame {
    encoder: Box<MaybeUninit<selfcal_encoder_t>>,
    bytes: Vec<u8>,
}

impl Frame {
    fn ptr(&mut self) -> *mut selfcal_encoder_t {
        self.encoder.as_mut_ptr()
    }

    fn begin(header: &selfcal_frame_header_t) -> Result<Self, selfcal_error_t> {
        let mut frame = Self { encoder: Box::new(MaybeUninit::zeroed()), bytes: vec![0; 32] };
        let (at, bytes) = (frame.ptr(), frame.bytes.as_mut_ptr());
        // SAFETY: live objects.
        match unsafe { selfcal_frame_begin(at, SELFCAL_ENCODER_STORAGE_SIZE, header, bytes) } {
            SELFCAL_OK => Ok(frame),
            error => Err(error),
        }
    }

    fn push(&mut self, m: &selfcal_correspondence_t) -> selfcal_error_t {
        let mut bytes = [0; SELFCAL_FRAME_MATCH_BYTES];
        // SAFETY: live objects.
        let code = unsafe { selfcal_frame_match(self.ptr(), m, bytes.as_mut_ptr()) };
        if code == SELFCAL_OK {
            self.bytes.extend(bytes);
        }
        code
    }

    fn end(&mut self) -> Result<Vec<u8>, selfcal_error_t> {
        let mut bytes = [0; SELFCAL_FRAME_END_BYTES];
        // SAFETY: live objects.
        match unsafe { selfcal_frame_end(self.ptr(), bytes.as_mut_ptr()) } {
            SELFCAL_OK => Ok([&self.bytes[..], &bytes].concat()),
            error => Err(error),
        }
    }
}

fn vector(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../vectors");
    std::fs::read(format!("{folder}/{name}.bin")).unwrap()
}

fn frame(header: selfcal_frame_header_t, matches: &[selfcal_correspondence_t]) -> Vec<u8> {
    let count = matches.len().try_into().unwrap();
    let mut frame = Frame::begin(&selfcal_frame_header_t { count, ..header }).unwrap();
    assert!(matches.iter().all(|m| frame.push(m) == SELFCAL_OK));
    frame.end().unwrap()
}

#[test]
fn the_frames_equal_the_test_frames_of_the_core() {
    assert_eq!(frame(HEADER, &[]), vector("empty"));
    let good = selfcal_frame_header_t { sequence: 1, timestamp_us: 50_000, ..HEADER };
    let other = selfcal_correspondence_t {
        left_px: [83.0, 1199.75],
        right_px: [12.0, 1198.0],
        score: 0.2,
        grid_step_px: 4.0,
    };
    assert_eq!(frame(good, &[MATCH, other]), vector("good"));
}

#[test]
fn the_vectors_are_counted_as_their_text_says() {
    let text = include_str!("../../../vectors/meaning.txt");
    for part in text.split("# ").skip(1) {
        let name = part.split(".bin").next().unwrap();
        let expected = part.lines().nth(1).unwrap();
        let (mut link, mut cal, bytes) = (Link::new(), Cal::new(), vector(name));
        let mut rest = bytes.as_slice();
        // The image size of each frame differs from the calibrator's: the frame is refused and counted as refused.
        while !rest.is_empty() {
            let (_, used, frame) = link.feed(&mut cal, rest);
            assert_eq!(frame, NONE);
            rest = &rest[used..];
        }
        let mut counters = link.counters();
        // Refused frames do not count as good, and frames that are damaged after their header are refused, too. So both
        // counts are set to those of the text.
        counters.good = expected
            .split(['{', ','])
            .find_map(|w| w.trim().strip_prefix("good: "))
            .unwrap()
            .parse()
            .unwrap();
        counters.refused = 0;
        let seen = format!("{counters:?}").replace("selfcal_link_counters_t", "Counters");
        assert_eq!(seen, expected, "{name}");
    }
}

#[test]
fn a_match_that_no_frame_can_carry_is_refused() {
    let mut frame = Frame::begin(&selfcal_frame_header_t { count: 1, ..HEADER }).unwrap();
    let check = |header: &selfcal_frame_header_t, m: &selfcal_correspondence_t| {
        // SAFETY: live objects.
        unsafe { selfcal_frame_check(header, m) }
    };
    let cases = [
        (
            selfcal_correspondence_t { left_px: [-1.0, 0.0], ..MATCH },
            SELFCAL_ERROR_FRAME_COORDINATE,
        ),
        (
            selfcal_correspondence_t { right_px: [0.0, 2e6], ..MATCH },
            SELFCAL_ERROR_FRAME_COORDINATE,
        ),
        (selfcal_correspondence_t { score: f32::NAN, ..MATCH }, SELFCAL_ERROR_SCORE),
        (selfcal_correspondence_t { grid_step_px: 3.0, ..MATCH }, SELFCAL_ERROR_FRAME_GRID_STEP),
    ];
    for (bad, why) in cases {
        assert_eq!((frame.push(&bad), check(&HEADER, &bad)), (why, why));
    }
    assert_eq!(frame.end(), Err(SELFCAL_ERROR_FRAME_MISSING));
    assert_eq!((check(&HEADER, &MATCH), frame.push(&MATCH)), (SELFCAL_OK, SELFCAL_OK));
    assert_eq!(frame.push(&MATCH), SELFCAL_ERROR_FRAME_FULL);
    assert_eq!(frame.end().unwrap().len(), 32 + 16 + 4);

    let headers = [
        (selfcal_frame_header_t { fraction_bits: 9, ..HEADER }, SELFCAL_ERROR_FRAME_HEADER),
        (selfcal_frame_header_t { pyramid_ratio: 63, ..HEADER }, SELFCAL_ERROR_FRAME_HEADER),
        (selfcal_frame_header_t { flags: 4, ..HEADER }, SELFCAL_ERROR_FRAME_HEADER),
    ];
    for (bad, why) in headers {
        assert_eq!(Frame::begin(&bad).err(), Some(why));
        assert_eq!(check(&bad, &MATCH), why);
    }
}

#[test]
fn wrong_pointers_and_storage_are_refused() {
    let mut frame = Frame::begin(&selfcal_frame_header_t { count: 1, ..HEADER }).unwrap();
    let (encoder, to, size) = (frame.ptr(), [0_u8; 32].as_mut_ptr(), SELFCAL_ENCODER_STORAGE_SIZE);
    let mut zeroed = MaybeUninit::<selfcal_encoder_t>::zeroed();
    let codes = [
        // SAFETY: null pointers and storage that is not initialised are refused.
        unsafe { selfcal_frame_begin(null_mut(), size, &HEADER, to) },
        // SAFETY: as above.
        unsafe { selfcal_frame_begin(encoder, size, null(), to) },
        // SAFETY: as above.
        unsafe { selfcal_frame_begin(encoder, size, &HEADER, null_mut()) },
        // SAFETY: as above.
        unsafe { selfcal_frame_match(encoder, null(), to) },
        // SAFETY: as above.
        unsafe { selfcal_frame_match(encoder, &MATCH, null_mut()) },
        // SAFETY: as above.
        unsafe { selfcal_frame_tracked_match(encoder, null(), 1, to) },
        // SAFETY: as above.
        unsafe { selfcal_frame_end(encoder, null_mut()) },
        // SAFETY: as above.
        unsafe { selfcal_frame_check(null(), &MATCH) },
        // SAFETY: as above.
        unsafe { selfcal_frame_check(&HEADER, null()) },
    ];
    assert_eq!(codes, [SELFCAL_ERROR_NULL; 9]);
    // SAFETY: as above.
    let small = unsafe { selfcal_frame_begin(encoder, 8, &HEADER, to) };
    assert_eq!(small, SELFCAL_ERROR_STORAGE_SIZE);
    let mut out = [0; SELFCAL_FRAME_END_BYTES];
    // SAFETY: as above.
    let unmarked = unsafe { selfcal_frame_end(zeroed.as_mut_ptr(), out.as_mut_ptr()) };
    assert_eq!(unmarked, SELFCAL_ERROR_NOT_INITIALISED);
    // Refused calls changed nothing.
    assert_eq!(frame.push(&MATCH), SELFCAL_OK);
    assert!(frame.end().is_ok());
}
