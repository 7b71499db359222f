//! Every misuse of a link returns its error and changes nothing.

use std::collections::BTreeSet;
use std::ptr::{null, null_mut};

use proptest::prelude::*;
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::link::{Link, NONE, feed, frame};
use crate::misuse::place;
use crate::rig::{Cal, Observed, at_work, recorded};
use crate::source;
use crate::tracks::Joined;

#[test]
fn a_link_is_small_and_its_structures_have_no_padding() {
    assert!(size_of::<selfcal_link_t>() == SELFCAL_LINK_STORAGE_SIZE);
    const { assert!(SELFCAL_LINK_STORAGE_SIZE < 160) }
    // The size is the sum of the sizes of the fields, so no compiler adds padding.
    assert_eq!(size_of::<selfcal_frame_t>(), 8 + 3 * 4 + 4);
    assert_eq!(size_of::<selfcal_link_counters_t>(), 10 * 4);
}

/// Calls every function of a link; the other arguments are valid.
fn every_function(link: *mut selfcal_link_t) -> Vec<(&'static str, selfcal_error_t)> {
    let (mut cal, mut tracks) = (Cal::new(), Joined::new());
    // SAFETY: live objects, except for the link under test.
    unsafe {
        vec![
            ("selfcal_link_feed", selfcal_link_feed(link, cal.ptr(), null(), 0, place(), place())),
            (
                "selfcal_link_feed_tracked",
                selfcal_link_feed_tracked(
                    link,
                    cal.ptr(),
                    tracks.ptr(),
                    null(),
                    0,
                    place(),
                    place(),
                ),
            ),
            ("selfcal_link_note_overrun", selfcal_link_note_overrun(link)),
            ("selfcal_link_counters", selfcal_link_counters(link, place())),
        ]
    }
}

#[test]
fn every_function_refuses_other_storage() {
    let tested = every_function(null_mut()).into_iter().map(|(name, _)| name.to_owned());
    assert_eq!(tested.collect::<BTreeSet<_>>(), source::functions_of("selfcal_link_t"));
    let mut live = Link::new();
    let odd = live.ptr().cast::<u8>().wrapping_add(1).cast();
    for (link, expected) in [
        (null_mut(), SELFCAL_ERROR_NULL),
        (odd, SELFCAL_ERROR_ALIGNMENT),
        (Link::zeroed().ptr(), SELFCAL_ERROR_NOT_INITIALISED),
        // The name at the start of a calibrator differs.
        (Cal::new().ptr().cast(), SELFCAL_ERROR_NOT_INITIALISED),
    ] {
        for (name, code) in every_function(link) {
            assert_eq!(code, expected, "{name}");
        }
    }
}

#[test]
fn storage_of_a_link_is_checked_before_it_is_written() {
    let mut link = Link::zeroed();
    let odd = link.ptr().cast::<u8>().wrapping_add(1).cast();
    // SAFETY: null, misaligned or live storage.
    let codes = unsafe {
        [
            selfcal_link_init(null_mut(), SELFCAL_LINK_STORAGE_SIZE),
            selfcal_link_init(odd, SELFCAL_LINK_STORAGE_SIZE),
            selfcal_link_init(link.ptr(), 64),
        ]
    };
    let expected = [SELFCAL_ERROR_NULL, SELFCAL_ERROR_ALIGNMENT, SELFCAL_ERROR_STORAGE_SIZE];
    assert_eq!(codes, expected);
    assert!(link.bytes().iter().all(|byte| *byte == 0));
}

#[test]
fn a_feed_that_is_refused_uses_nothing_and_changes_nothing() {
    let set = recorded();
    let (mut cal, mut link) = (at_work(), Link::new());
    let bytes = frame(&set, 0);
    let (seen, state) = (Observed::of(&mut cal), link.bytes().to_vec());
    let refused = |code| (code, 0, NONE);
    let cals = [
        (null_mut(), SELFCAL_ERROR_NULL),
        (cal.ptr().cast::<u8>().wrapping_add(1).cast(), SELFCAL_ERROR_ALIGNMENT),
        (Cal::zeroed().ptr(), SELFCAL_ERROR_NOT_INITIALISED),
    ];
    for (cal, code) in cals {
        assert_eq!(feed(link.ptr(), cal, &bytes), refused(code));
    }
    assert_eq!(feed(null_mut(), cal.ptr(), &bytes), refused(SELFCAL_ERROR_NULL));
    let (length, mut used, mut whole) = (bytes.len(), 7, NONE);
    let (link_ptr, cal_ptr, start) = (link.ptr(), cal.ptr(), bytes.as_ptr());
    let odd: *mut selfcal_frame_t = (&raw mut whole).cast::<u8>().wrapping_add(1).cast();
    // SAFETY: live objects, null, misaligned, or refused by its length.
    let codes = unsafe {
        [
            selfcal_link_feed(link_ptr, cal_ptr, null(), 1, &mut used, &mut whole),
            selfcal_link_feed(link_ptr, cal_ptr, start, usize::MAX, &mut used, &mut whole),
            selfcal_link_feed(link_ptr, cal_ptr, start, length, null_mut(), &mut whole),
            selfcal_link_feed(link_ptr, cal_ptr, start, length, &mut used, null_mut()),
            selfcal_link_feed(link_ptr, cal_ptr, start, length, &mut used, odd),
            selfcal_link_counters(link_ptr, null_mut()),
        ]
    };
    assert_eq!(
        codes,
        [
            SELFCAL_ERROR_NULL,
            SELFCAL_ERROR_VALUE,
            SELFCAL_ERROR_NULL,
            SELFCAL_ERROR_NULL,
            SELFCAL_ERROR_ALIGNMENT,
            SELFCAL_ERROR_NULL
        ]
    );
    assert_eq!((used, whole), (0, NONE));
    assert_eq!(Observed::of(&mut cal), seen);
    assert!(link.bytes() == state);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn one_wrong_byte_in_the_magic_of_a_link_is_detected(at in 0..12_usize, flip in 1..=u8::MAX) {
        let mut link = Link::new();
        link.bytes()[at] ^= flip;
        for (name, code) in every_function(link.ptr()) {
            prop_assert_eq!(code, SELFCAL_ERROR_NOT_INITIALISED, "{}", name);
        }
        link.bytes()[at] ^= flip;
        prop_assert_eq!(link.counters().good, 0);
    }
}
