//! Calls in the wrong order, and arguments that `selfcal_init` refuses.

use std::ptr::{null, null_mut};

use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::codes::string;
use crate::misuse::{CORRESPONDENCE, four, refused};
use crate::rig::{Cal, at_work, begin, defaults, factory, finish, get, pair, recorded};

#[test]
fn calls_in_the_wrong_order_return_their_errors() {
    let set = recorded();
    let mut cal = Cal::of(&set, None);
    // SAFETY: live objects.
    refused(&mut cal, SELFCAL_ERROR_NO_ESTIMATE, |cal| unsafe {
        selfcal_depth_errors(cal, 0.1, four())
    });
    let verdict = get!(cal, selfcal_verdict).unwrap();
    assert_eq!((verdict.may_arm, verdict.cause), (false, selfcal_cause_t::SELFCAL_CAUSE_NONE));
    assert_eq!(get!(cal, selfcal_details), Err(SELFCAL_ERROR_NO_ESTIMATE));
    assert_eq!(get!(cal, selfcal_in_use).unwrap().generation, 0);
    assert!(get!(cal, selfcal_rotations, 0).is_ok(), "those of the factory");
    assert_eq!(get!(cal, selfcal_proposal), Err(SELFCAL_ERROR_NO_ESTIMATE));
    assert_eq!(get!(cal, selfcal_rotations, 1), Err(SELFCAL_ERROR_NO_ESTIMATE));
    assert_eq!(get!(cal, selfcal_rotations, 2), Err(SELFCAL_ERROR_NO_ESTIMATE));
    assert_eq!(get!(cal, selfcal_apply), Err(SELFCAL_ERROR_NO_ESTIMATE));
    assert_eq!(get!(cal, selfcal_undo), Err(SELFCAL_ERROR_NOTHING_TO_UNDO));
    assert_eq!(get!(cal, selfcal_solve_pair), Err(SELFCAL_ERROR_TOO_FEW));
    let (all, _) = pair(&set, 0);
    get!(cal, selfcal_push_array, all.as_ptr(), all.len()).unwrap();
    begin(&mut cal);
    // SAFETY: live objects.
    refused(&mut cal, SELFCAL_ERROR_BUSY, |cal| unsafe {
        selfcal_push_array(cal, &raw const CORRESPONDENCE, 1, null_mut())
    });
    finish(&mut cal).unwrap();
    assert_eq!(get!(cal, selfcal_solve_pair), Err(SELFCAL_ERROR_TOO_FEW), "a pair counts once");
    get!(cal, selfcal_take_pair, all.as_ptr(), all.len()).unwrap();
    assert_eq!(get!(cal, selfcal_apply), Err(SELFCAL_ERROR_NOT_LOCKED));
    // SAFETY: live objects.
    refused(&mut cal, SELFCAL_ERROR_NOT_LOCKED, |cal| unsafe {
        selfcal_depth_errors(cal, 0.1, four())
    });
}

#[test]
fn the_batch_is_dropped_by_each_call_that_begins_anew() {
    type Act = fn(*mut selfcal_t) -> selfcal_error_t;
    let acts: [Act; 3] = [
        // SAFETY: live objects.
        |cal| unsafe { selfcal_discard_pair(cal) },
        // SAFETY: as above.
        |cal| unsafe { selfcal_reset(cal) },
        // SAFETY: as above.
        |cal| unsafe {
            selfcal_init(cal, SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, null(), &factory(&recorded()))
        },
    ];
    for act in acts {
        let mut cal = at_work();
        assert!(get!(cal, selfcal_batch).unwrap().held > 0);
        assert_eq!(act(cal.ptr()), SELFCAL_OK);
        assert_eq!(get!(cal, selfcal_batch).unwrap().held, 0);
        assert_eq!(get!(cal, selfcal_solve_pair), Err(SELFCAL_ERROR_TOO_FEW));
    }
}

const EXACT_LENS: selfcal_lens_prior_t =
    selfcal_lens_prior_t { focal: 0.0, principal_px: 0.0, k1: 0.0, p1: 0.0, p2: 0.0, yaw_rad: 0.0 };

/// Initialises a calibrator; returns the code, and whether the storage is initialised.
fn init(config: &selfcal_config_t, factory: &selfcal_factory_t) -> (selfcal_error_t, bool) {
    let mut cal = Cal::zeroed();
    // SAFETY: live objects, and storage of that size.
    let code =
        unsafe { selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, config, factory) };
    (code, get!(cal, selfcal_state).is_ok())
}

#[test]
fn a_parameter_out_of_its_range_is_refused_and_named() {
    let (d, made) = (defaults(), factory(&recorded()));
    let lens = |lens_prior| selfcal_config_t { has_lens_prior: 1, lens_prior, ..d };
    let refused = [
        (selfcal_config_t { prior_sd_rad: f32::NAN, ..d }, "prior_sd_rad"),
        (selfcal_config_t { fit_limit_px: f32::INFINITY, ..d }, "fit_limit_px"),
        (selfcal_config_t { max_passes: 1, ..d }, "max_passes is below 2"),
        (selfcal_config_t { min_correspondences: 5, ..d }, "min_correspondences is below 6"),
        (selfcal_config_t { noise_floor_px: f32::NAN, ..d }, "noise_floor_px"),
        (selfcal_config_t { max_correction_rad: 1.5, ..d }, "max_correction_rad"),
        (selfcal_config_t { memory_pairs: 19, ..d }, "memory_pairs is below 20"),
        (selfcal_config_t { lens_tracking: 2, ..d }, "lens_tracking is no value"),
        (selfcal_config_t { has_lens_prior: 2, ..d }, "has_lens_prior is neither 0 nor 1"),
        (lens(selfcal_lens_prior_t { k1: -1.0, ..EXACT_LENS }), "a deviation of lens_prior"),
        (lens(selfcal_lens_prior_t { yaw_rad: 0.2, ..EXACT_LENS }), "yaw_rad of lens_prior"),
    ];
    for (config, text) in refused {
        assert_eq!(init(&config, &made), (SELFCAL_ERROR_CONFIG, false), "{text}");
        // SAFETY: live objects.
        let named = string(unsafe { selfcal_argument_string(&config, &made) });
        assert!(named.starts_with(text), "{named}");
    }
    for config in [d, lens(EXACT_LENS)] {
        assert_eq!(init(&config, &made), (SELFCAL_OK, true));
        // SAFETY: live objects.
        assert_eq!(string(unsafe { selfcal_argument_string(&config, &made) }), "no error");
    }
    // SAFETY: null.
    assert_eq!(string(unsafe { selfcal_argument_string(null(), null()) }), "no error");
}

#[test]
fn a_factory_calibration_out_of_its_range_is_refused_and_named() {
    let good = factory(&recorded());
    let side = selfcal_extrinsics_t { rotation: [0.0; 9], translation: [-1.0, 0.0, 0.0] };
    let cam = good.right;
    let fisheye = selfcal_lens_t::SELFCAL_LENS_FISHEYE as u32;
    let far = [0.0, 0.0, 0.0, 0.0, 1e4, 0.0, 0.0, 0.0];
    let right = [
        (selfcal_camera_t { focal_px: [0.5, 500.0], ..cam }, "a focal length"),
        (selfcal_camera_t { principal_px: [1e6, 0.0], ..cam }, "the principal point"),
        (selfcal_camera_t { size_px: [640, 1], ..cam }, "the image is smaller"),
        (selfcal_camera_t { distortion: far, ..cam }, "a lens coefficient"),
        (selfcal_camera_t { lens: 4, ..cam }, "the lens model"),
        (selfcal_camera_t { lens: fisheye, ..cam }, "a coefficient that the lens model does not"),
    ];
    let of_cameras = right.into_iter().flat_map(|(camera, text)| {
        [
            (selfcal_factory_t { right: camera, ..good }, format!("right camera: {text}")),
            (selfcal_factory_t { left: camera, ..good }, format!("left camera: {text}")),
        ]
    });
    let identity = good.extrinsics.rotation;
    let along = selfcal_extrinsics_t { rotation: identity, translation: [0.0, 0.0, 1.0] };
    let none = selfcal_extrinsics_t { rotation: identity, translation: [0.0; 3] };
    let made = selfcal_factory_t { is_guess: 0, ..good };
    let others = [
        (selfcal_factory_t { extrinsics: side, ..good }, "extrinsics: R is not finite"),
        (selfcal_factory_t { extrinsics: none, ..good }, "extrinsics: t is not finite"),
        (selfcal_factory_t { extrinsics: along, ..good }, "extrinsics: t is within 6 degrees"),
        (selfcal_factory_t { is_guess: 2, ..good }, "is_guess is neither 0 nor 1"),
        (selfcal_factory_t { yaw_sd_rad: 1e-7, ..made }, "yaw_sd_rad is not within 1e-6 to 1"),
        (selfcal_factory_t { baseline_m: f32::NAN, ..good }, "baseline_m is not within"),
    ];
    let others = others.into_iter().map(|(factory, text)| (factory, text.to_owned()));
    for (factory, text) in of_cameras.chain(others) {
        assert_eq!(init(&defaults(), &factory), (SELFCAL_ERROR_FACTORY, false), "{text}");
        // SAFETY: live objects.
        let named = string(unsafe { selfcal_argument_string(null(), &factory) });
        assert!(named.starts_with(&text), "{named}");
    }
}

#[test]
fn extrinsics_of_zeros_are_a_guess_of_cameras_side_by_side() {
    let guess = factory(&recorded());
    let zeros = selfcal_extrinsics_t { rotation: [0.0; 9], translation: [0.0; 3] };
    let bare = selfcal_factory_t { extrinsics: zeros, is_guess: 0, ..guess };
    let mut bytes = [[0_u8; SELFCAL_FACTORY_BYTES]; 2];
    for (factory, bytes) in [guess, bare].iter().zip(&mut bytes) {
        // SAFETY: live objects.
        let code = unsafe { selfcal_factory_to_record(factory, bytes.as_mut_ptr()) };
        assert_eq!(code, SELFCAL_OK);
    }
    let [of_guess, of_bare] = bytes;
    assert_eq!(of_guess, of_bare);
}
