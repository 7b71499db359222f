//! Calls out of order, reports of another pair, configurations that no preset has filled.

use std::mem::MaybeUninit;
use std::ptr::null_mut;

use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::misuse::{CORRESPONDENCE, four, place, refused};
use crate::rig::{Cal, at_work, cameras, config, get, pair, recorded};

#[test]
fn calls_in_the_wrong_order_return_their_errors() {
    let mut cal = Cal::new(None);
    let two = CORRESPONDENCE.left_px.as_ptr();
    let camera = selfcal_rectified_camera_t { focal_px: 500.0, principal_px: [320.0, 240.0] };
    // SAFETY: live objects.
    unsafe {
        refused(&mut cal, SELFCAL_ERROR_NO_CAMERAS, |cal| {
            selfcal_push(cal, &raw const CORRESPONDENCE, null_mut())
        });
        refused(&mut cal, SELFCAL_ERROR_NO_CAMERAS, |cal| {
            selfcal_push_array(cal, &raw const CORRESPONDENCE, 1, null_mut())
        });
        refused(&mut cal, SELFCAL_ERROR_NO_CAMERAS, |cal| selfcal_begin_pair(cal));
        refused(&mut cal, SELFCAL_ERROR_NO_CAMERAS, |cal| selfcal_ray(cal, 0, two, four()));
        refused(&mut cal, SELFCAL_ERROR_NO_CAMERAS, |cal| {
            selfcal_choose_camera(cal, 0, 0.0, place())
        });
        refused(&mut cal, SELFCAL_ERROR_NO_CAMERAS, |cal| {
            selfcal_homographies(cal, 0, &camera, place())
        });
        refused(&mut cal, SELFCAL_ERROR_NO_HEALTH, |cal| selfcal_depth_errors(cal, 0.1, four()));
    }
    assert_eq!(get!(cal, selfcal_calibration_in_use), Err(SELFCAL_ERROR_NO_CAMERAS));
    assert!(get!(cal, selfcal_rotations, 0).is_ok(), "without cameras too");
    assert_eq!(get!(cal, selfcal_proposal), Err(SELFCAL_ERROR_NO_ESTIMATE));
    assert_eq!(get!(cal, selfcal_rotations, 1), Err(SELFCAL_ERROR_NO_ESTIMATE));
    assert_eq!(get!(cal, selfcal_rotations, 2), Err(SELFCAL_ERROR_NO_ESTIMATE));

    let set = recorded();
    let mut cal = Cal::of(&set, None);
    assert_eq!(get!(cal, selfcal_fuse), Err(SELFCAL_ERROR_NO_REPORT));
    assert_eq!(get!(cal, selfcal_apply), Err(SELFCAL_ERROR_APPLY_NO_PROPOSAL));
    assert_eq!(get!(cal, selfcal_undo), Err(SELFCAL_ERROR_APPLY_NOTHING_TO_UNDO));
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_solve_pair(cal.ptr()) }, SELFCAL_ERROR_PAIR_TOO_FEW);
    let (all, _) = pair(&set, 0);
    get!(cal, selfcal_push_array, all.as_ptr(), all.len()).unwrap();
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_begin_pair(cal.ptr()) }, SELFCAL_OK);
    // SAFETY: live objects.
    refused(&mut cal, SELFCAL_ERROR_PUSH_BUSY, |cal| unsafe {
        selfcal_push_array(cal, &raw const CORRESPONDENCE, 1, null_mut())
    });
    while !get!(cal, selfcal_advance_pair).unwrap() {}
    get!(cal, selfcal_fuse).unwrap();
    assert_eq!(get!(cal, selfcal_fuse), Err(SELFCAL_ERROR_NO_REPORT));
    assert_eq!(get!(cal, selfcal_apply), Err(SELFCAL_ERROR_APPLY_NOT_LOCKED));
    // SAFETY: live objects.
    refused(&mut cal, SELFCAL_ERROR_NO_DEPTH_ERROR, |cal| unsafe {
        selfcal_depth_errors(cal, 0.1, four())
    });
}

#[test]
fn a_report_is_dropped_with_its_batch() {
    type Act = fn(*mut selfcal_t) -> selfcal_error_t;
    let acts: [Act; 4] = [
        // SAFETY: live objects.
        |cal| unsafe { selfcal_clear_pair(cal) },
        // SAFETY: as above.
        |cal| unsafe { selfcal_reset(cal) },
        |cal| {
            let [left, right] = cameras(&recorded());
            // SAFETY: as above.
            unsafe { selfcal_set_cameras(cal, &left, &right) }
        },
        |cal| {
            let factory = selfcal_extrinsics_t {
                rotation: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
                translation: [-1.0, 0.0, 0.0],
            };
            // SAFETY: as above.
            unsafe { selfcal_set_factory(cal, &factory) }
        },
    ];
    for act in acts {
        let mut cal = at_work();
        get!(cal, selfcal_report).unwrap();
        assert_eq!(act(cal.ptr()), SELFCAL_OK);
        assert_eq!(get!(cal, selfcal_report), Err(SELFCAL_ERROR_NO_REPORT));
        assert_eq!(get!(cal, selfcal_fuse), Err(SELFCAL_ERROR_NO_REPORT));
    }
}

const EXACT_LENS: selfcal_lens_prior_t =
    selfcal_lens_prior_t { focal: 0.0, principal_px: 0.0, k1: 0.0, p1: 0.0, p2: 0.0 };

#[test]
fn a_refused_setter_leaves_the_configuration_unchanged() {
    let mut c = config(selfcal_config_robust);
    let before = format!("{c:?}");
    // SAFETY: a live configuration.
    let codes = unsafe {
        [
            selfcal_config_set_prior_sd_rad(&mut c, f32::NAN),
            selfcal_config_set_huber_threshold_px(&mut c, f32::INFINITY),
            selfcal_config_set_max_passes(&mut c, 0),
            selfcal_config_set_step_tolerance_rad(&mut c, f32::NAN),
            selfcal_config_set_min_correspondences(&mut c, 0),
            selfcal_config_set_noise_floor_px(&mut c, f32::NAN),
            selfcal_config_set_angle(&mut c, 2),
            selfcal_config_set_max_sd_rad(&mut c, -1.0),
            selfcal_config_set_max_correction_rad(&mut c, f32::NAN),
            selfcal_config_set_memory_pairs(&mut c, 0),
            selfcal_config_set_lens_prior(&mut c, selfcal_lens_prior_t { k1: -1.0, ..EXACT_LENS }),
            selfcal_config_paper(null_mut()),
        ]
    };
    assert_eq!(
        codes,
        [
            SELFCAL_ERROR_CONFIG_PRIOR_SD,
            SELFCAL_ERROR_CONFIG_HUBER_THRESHOLD,
            SELFCAL_ERROR_CONFIG_MAX_PASSES,
            SELFCAL_ERROR_CONFIG_STEP_TOLERANCE,
            SELFCAL_ERROR_CONFIG_MIN_CORRESPONDENCES,
            SELFCAL_ERROR_CONFIG_NOISE_FLOOR,
            SELFCAL_ERROR_VALUE,
            SELFCAL_ERROR_CONFIG_MAX_SD,
            SELFCAL_ERROR_CONFIG_MAX_CORRECTION,
            SELFCAL_ERROR_CONFIG_MEMORY,
            SELFCAL_ERROR_CONFIG_LENS_PRIOR,
            SELFCAL_ERROR_NULL,
        ]
    );
    assert_eq!(format!("{c:?}"), before);
}

#[test]
fn a_configuration_that_no_preset_has_filled_is_refused() {
    let mut blank = MaybeUninit::<selfcal_config_t>::zeroed();
    let mut cal = Cal::zeroed();
    // SAFETY: zeros are a configuration that is refused.
    unsafe {
        assert_eq!(
            selfcal_config_set_max_passes(blank.as_mut_ptr(), 20),
            SELFCAL_ERROR_CONFIG_NOT_INITIALISED
        );
        assert_eq!(
            selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, blank.as_ptr()),
            SELFCAL_ERROR_CONFIG_NOT_INITIALISED
        );
    }
    assert_eq!(get!(cal, selfcal_generation), Err(SELFCAL_ERROR_NOT_INITIALISED));
}
