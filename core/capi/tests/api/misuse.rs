//! Every misuse returns its error and changes nothing.

use std::collections::BTreeSet;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::rig::{Cal, Observed, at_work, factory, get, recorded};
use crate::source;
use crate::tracks::Joined;

pub(crate) static CORRESPONDENCE: selfcal_correspondence_t = selfcal_correspondence_t {
    left_px: [100.0, 100.0],
    right_px: [90.0, 100.0],
    score: 1.0,
    grid_step_px: 0.0,
};

/// A place for a result; it is never freed.
pub(crate) fn place<T>() -> *mut T {
    Box::leak(Box::<T>::new_uninit()).as_mut_ptr()
}

/// A place for up to four numbers.
pub(crate) fn four() -> *mut f32 {
    place::<[f32; 4]>().cast()
}

/// Calls every function of a calibrator. The other arguments are valid, except the records, which the functions check
/// after the calibrator.
pub(crate) fn every_function(cal: *mut selfcal_t) -> Vec<(&'static str, selfcal_error_t)> {
    let camera = selfcal_rectified_camera_t { focal_px: 500.0, principal_px: [320.0, 240.0] };
    let range = selfcal_range_t {
        pixel_px: [9.0; 2],
        range_m: 5.0,
        sd_m: 0.1,
        along_axis: 0,
        has_right: 0,
        right_px: [0.0; 2],
    };
    let tracked = selfcal_tracked_t { words: [0; 10] };
    let mut tracks = Joined::new();
    let mut event = selfcal_event_t::default();
    let (c, two) = (&raw const CORRESPONDENCE, CORRESPONDENCE.left_px.as_ptr());
    macro_rules! calls {
        ($($function:ident($($argument:expr),*);)*) => {
            // SAFETY: live objects, except for the calibrator under test.
            unsafe { vec![$((stringify!($function), $function(cal $(, $argument)*))),*] }
        };
    }
    calls! {
        selfcal_ray(0, two, four());
        selfcal_pixel(0, two, four());
        selfcal_in_use(place());
        selfcal_push(c, place());
        selfcal_push_array(c, 1, place());
        selfcal_push_range(&range, place());
        selfcal_track(c, c, place());
        selfcal_push_motion(&tracked, 1, place());
        selfcal_push_tracks(tracks.ptr(), place());
        selfcal_advance_tracks(tracks.ptr(), place(), place());
        selfcal_batch(place());
        selfcal_take_pair(c, 1, place());
        selfcal_advance_pair(place(), place());
        selfcal_solve_pair(place());
        selfcal_discard_pair();
        selfcal_state(place());
        selfcal_proposal(place());
        selfcal_verdict(place());
        selfcal_event(0, 0, &mut event, place());
        selfcal_details(place());
        selfcal_depth_errors(0.1, four());
        selfcal_apply(place());
        selfcal_undo(place());
        selfcal_set_frozen(true);
        selfcal_reset();
        selfcal_rotations(0, place());
        selfcal_choose_camera(0, 0.0, place());
        selfcal_homographies(0, &camera, place());
        selfcal_snapshot(null_mut());
        selfcal_restore(null(), 0);
    }
}

/// Checks that a call returns this error and changes nothing.
pub(crate) fn refused(
    cal: &mut Cal,
    code: selfcal_error_t,
    act: impl FnOnce(*mut selfcal_t) -> selfcal_error_t,
) {
    let before = Observed::of(cal);
    assert_eq!(act(cal.ptr()), code);
    assert_eq!(Observed::of(cal), before);
}

#[test]
fn every_function_of_a_calibrator_is_tested() {
    let tested = every_function(null_mut()).into_iter().map(|(name, _)| name.to_owned());
    assert_eq!(tested.collect::<BTreeSet<_>>(), source::functions_of("selfcal_t"));
}

#[test]
fn every_function_refuses_null() {
    for (name, code) in every_function(null_mut()) {
        assert_eq!(code, SELFCAL_ERROR_NULL, "{name}");
    }
}

#[test]
fn every_function_refuses_storage_that_is_not_initialised() {
    for (name, code) in every_function(Cal::zeroed().ptr()) {
        assert_eq!(code, SELFCAL_ERROR_NOT_INITIALISED, "{name}");
    }
}

#[test]
fn every_function_refuses_misaligned_storage() {
    let mut cal = Cal::new();
    for (name, code) in every_function(cal.ptr().cast::<u8>().wrapping_add(1).cast()) {
        assert_eq!(code, SELFCAL_ERROR_ALIGNMENT, "{name}");
    }
}

#[test]
fn storage_is_checked_before_it_is_written() {
    let mut cal = Cal::zeroed();
    let mut needed = MaybeUninit::zeroed();
    // SAFETY: a live place.
    let needed = unsafe {
        assert_eq!(selfcal_requirements(needed.as_mut_ptr()), SELFCAL_OK);
        needed.assume_init()
    };
    assert!(needed.size <= SELFCAL_STORAGE_SIZE && needed.align <= SELFCAL_STORAGE_ALIGN);
    assert_eq!(needed.capacity, SELFCAL_CAPACITY);
    let odd = cal.ptr().cast::<u8>().wrapping_add(1).cast();
    let factory = factory(&recorded());
    // SAFETY: null, misaligned or live storage.
    let codes = unsafe {
        [
            selfcal_init(null_mut(), SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, null(), &factory),
            selfcal_init(odd, SELFCAL_STORAGE_SIZE - 1, SELFCAL_HEADER, null(), &factory),
            selfcal_init(cal.ptr(), needed.size - 1, SELFCAL_HEADER, null(), &factory),
            selfcal_init(cal.ptr(), 0, SELFCAL_HEADER, null(), &factory),
            selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, null(), null()),
        ]
    };
    assert_eq!(
        codes,
        [
            SELFCAL_ERROR_NULL,
            SELFCAL_ERROR_ALIGNMENT,
            SELFCAL_ERROR_STORAGE_SIZE,
            SELFCAL_ERROR_STORAGE_SIZE,
            SELFCAL_ERROR_NULL
        ]
    );
    assert_eq!(get!(cal, selfcal_in_use), Err(SELFCAL_ERROR_NOT_INITIALISED));
    // SAFETY: live storage of that size.
    let code = unsafe { selfcal_init(cal.ptr(), needed.size, SELFCAL_HEADER, null(), &factory) };
    assert_eq!(code, SELFCAL_OK);
    assert_eq!(get!(cal, selfcal_in_use).unwrap().generation, 0);
}

#[test]
fn a_header_of_another_version_or_layout_is_refused_without_effect() {
    let mut cal = at_work();
    let factory = factory(&recorded());
    for header in [0, SELFCAL_HEADER - 1, SELFCAL_HEADER + 1000, SELFCAL_HEADER + 4 * 31] {
        // SAFETY: live objects.
        refused(&mut cal, SELFCAL_ERROR_HEADER, |cal| unsafe {
            selfcal_init(cal, SELFCAL_STORAGE_SIZE, header, null(), &factory)
        });
    }
}

#[test]
fn a_null_argument_is_refused_without_effect() {
    let mut cal = at_work();
    let camera = selfcal_rectified_camera_t { focal_px: 500.0, principal_px: [320.0, 240.0] };
    let two = CORRESPONDENCE.left_px.as_ptr();
    macro_rules! refuses_null {
        ($($function:ident($($argument:expr),*);)*) => {
            // SAFETY: live objects, or null.
            $(refused(&mut cal, SELFCAL_ERROR_NULL, |cal| unsafe { $function(cal $(, $argument)*) });)*
        };
    }
    refuses_null! {
        selfcal_ray(0, two, null_mut());
        selfcal_ray(0, null(), four());
        selfcal_pixel(0, two, null_mut());
        selfcal_pixel(0, null(), four());
        selfcal_in_use(null_mut());
        selfcal_push(null(), place());
        selfcal_push_array(null(), 1, place());
        selfcal_batch(null_mut());
        selfcal_advance_pair(null_mut(), place());
        selfcal_take_pair(null(), 1, place());
        selfcal_state(null_mut());
        selfcal_proposal(null_mut());
        selfcal_verdict(null_mut());
        selfcal_details(null_mut());
        selfcal_depth_errors(0.1, null_mut());
        selfcal_rotations(0, null_mut());
        selfcal_choose_camera(0, 0.0, null_mut());
        selfcal_homographies(0, &camera, null_mut());
        selfcal_homographies(0, null(), place());
    }
    // SAFETY: null.
    assert_eq!(unsafe { selfcal_requirements(null_mut()) }, SELFCAL_ERROR_NULL);
}

#[test]
fn misaligned_arguments_are_refused_without_effect() {
    let mut cal = at_work();
    let bytes: *mut u8 = place::<[u64; 64]>().cast();
    let odd = bytes.wrapping_add(1);
    // SAFETY: live memory, misaligned.
    unsafe {
        refused(&mut cal, SELFCAL_ERROR_ALIGNMENT, |cal| selfcal_push(cal, odd.cast(), null_mut()));
        refused(&mut cal, SELFCAL_ERROR_ALIGNMENT, |cal| {
            selfcal_push(cal, &raw const CORRESPONDENCE, odd.cast())
        });
        refused(&mut cal, SELFCAL_ERROR_ALIGNMENT, |cal| {
            selfcal_push_array(cal, odd.cast(), 2, null_mut())
        });
        refused(&mut cal, SELFCAL_ERROR_ALIGNMENT, |cal| {
            selfcal_init(cal, SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, null(), odd.cast())
        });
        refused(&mut cal, SELFCAL_ERROR_ALIGNMENT, |cal| selfcal_apply(cal, odd.cast()));
        refused(&mut cal, SELFCAL_ERROR_ALIGNMENT, |cal| selfcal_solve_pair(cal, odd.cast()));
    }
}

#[test]
fn an_array_may_be_empty_but_not_longer_than_the_address_space() {
    let mut cal = at_work();
    let counts = get!(cal, selfcal_push_array, null(), 0).unwrap();
    assert_eq!((counts.kept, counts.refused, counts.first_refusal), (0, 0, SELFCAL_OK));
    // SAFETY: refused by its count.
    refused(&mut cal, SELFCAL_ERROR_VALUE, |cal| unsafe {
        selfcal_push_array(cal, &raw const CORRESPONDENCE, usize::MAX, null_mut())
    });
}

#[test]
fn an_array_continues_after_a_refusal_and_reports_the_first() {
    let mut cal = Cal::of(&recorded(), None);
    let bad = selfcal_correspondence_t { score: 2.0, ..CORRESPONDENCE };
    let worse = selfcal_correspondence_t { left_px: [f32::NAN, 0.0], ..CORRESPONDENCE };
    let all = [CORRESPONDENCE, bad, worse, CORRESPONDENCE];
    let counts = get!(cal, selfcal_push_array, all.as_ptr(), all.len()).unwrap();
    assert_eq!((counts.kept, counts.replaced, counts.left_out, counts.refused), (2, 0, 0, 2));
    assert_eq!(counts.first_refusal, SELFCAL_ERROR_SCORE);
}

#[test]
fn numbers_that_are_not_finite_or_out_of_range_are_refused() {
    let mut cal = at_work();
    let good = factory(&recorded());
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let extrinsics = selfcal_extrinsics_t { rotation: [bad; 9], translation: [-1.0, 0.0, 0.0] };
        let turned = selfcal_factory_t { extrinsics, ..good };
        let right = selfcal_camera_t { focal_px: [bad, 500.0], ..good.right };
        let blind = selfcal_factory_t { right, ..good };
        let own = selfcal_rectified_camera_t { focal_px: 500.0, principal_px: [bad, 0.0] };
        let ray = [bad, 0.0];
        // SAFETY: live objects.
        unsafe {
            for factory in [turned, blind] {
                refused(&mut cal, SELFCAL_ERROR_FACTORY, |cal| {
                    selfcal_init(cal, SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, null(), &factory)
                });
            }
            refused(&mut cal, SELFCAL_ERROR_VALUE, |cal| selfcal_depth_errors(cal, bad, four()));
            refused(&mut cal, SELFCAL_ERROR_ALPHA, |cal| {
                selfcal_choose_camera(cal, 0, bad, place())
            });
            refused(&mut cal, SELFCAL_ERROR_VALUE, |cal| {
                selfcal_homographies(cal, 0, &own, place())
            });
            refused(&mut cal, SELFCAL_ERROR_NOT_FINITE, |cal| {
                selfcal_ray(cal, 0, ray.as_ptr(), four())
            });
            refused(&mut cal, SELFCAL_ERROR_NOT_FINITE, |cal| {
                selfcal_pixel(cal, 1, ray.as_ptr(), four())
            });
        }
    }
    let own = selfcal_rectified_camera_t { focal_px: 0.0, principal_px: [0.0; 2] };
    let two = CORRESPONDENCE.left_px.as_ptr();
    // SAFETY: live objects.
    unsafe {
        refused(&mut cal, SELFCAL_ERROR_VALUE, |cal| selfcal_depth_errors(cal, 0.0, four()));
        refused(&mut cal, SELFCAL_ERROR_VALUE, |cal| selfcal_homographies(cal, 0, &own, place()));
        refused(&mut cal, SELFCAL_ERROR_VALUE, |cal| selfcal_rotations(cal, 3, place()));
        refused(&mut cal, SELFCAL_ERROR_VALUE, |cal| selfcal_ray(cal, 2, two, four()));
    }
}
