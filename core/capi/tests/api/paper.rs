//! The published method through C is bit-identical to Rust.

use std::mem::MaybeUninit;
use std::ptr;

use stereo_selfcal::Extrinsics;
use stereo_selfcal::paper::{Central, PaperCalibrator, Settings};
use stereo_selfcal_capi::selfcal_error_t::{self, *};
use stereo_selfcal_capi::*;

use crate::life::{assert_same, bits};
use crate::rig::{factory, get, pair, recorded};

/// Storage on the heap, zeroed as static storage of C.
struct Paper(Box<MaybeUninit<selfcal_paper_t>>);

impl Paper {
    fn zeroed() -> Self {
        Self(Box::new(MaybeUninit::zeroed()))
    }

    fn init(&mut self, config: *const selfcal_paper_config_t) -> selfcal_error_t {
        let (size, factory) = (size_of::<selfcal_paper_t>(), factory(&recorded()));
        // SAFETY: live objects, and storage of that size.
        unsafe { selfcal_paper_init(self.ptr(), size, config, &factory) }
    }

    fn ptr(&mut self) -> *mut selfcal_paper_t {
        self.0.as_mut_ptr()
    }
}

const DEFAULTS: selfcal_paper_config_t = selfcal_paper_config_t {
    max_passes: 0,
    min_correspondences: 0,
    max_correction_rad: 0.0,
    noise_floor_px: 0.0,
    huber_threshold_px: 0.0,
    step_tolerance_rad: 0.0,
    max_sd_rad: 0.0,
    angle: 0,
};

const EVERY: selfcal_paper_config_t = selfcal_paper_config_t {
    max_passes: 40,
    min_correspondences: 20,
    max_correction_rad: 0.4,
    noise_floor_px: 0.05,
    huber_threshold_px: 1.5,
    step_tolerance_rad: 1e-7,
    max_sd_rad: 0.1,
    angle: selfcal_angle_t::SELFCAL_ANGLE_MEDIAN as u32,
};

#[test]
fn a_run_with_defaults_and_with_every_parameter_is_bit_identical_to_rust() {
    let set = recorded();
    let every = Settings::DEFAULT
        .with_angle(Central::Median)
        .with_max_passes(40)
        .and_then(|s| s.with_min_correspondences(20))
        .and_then(|s| s.with_max_correction_rad(0.4))
        .and_then(|s| s.with_noise_floor_px(0.05))
        .and_then(|s| s.with_huber_threshold_px(1.5))
        .and_then(|s| s.with_step_tolerance_rad(1e-7))
        .and_then(|s| s.with_max_sd_rad(0.1));
    for (c, rust) in [(DEFAULTS, Settings::DEFAULT), (EVERY, every.unwrap())] {
        let mut paper = Paper::zeroed();
        assert_eq!(paper.init(&c), SELFCAL_OK);
        assert_eq!(get!(paper, selfcal_paper_estimate), Err(SELFCAL_ERROR_NO_ESTIMATE));
        let cameras = set.cameras().unwrap();
        let start = Extrinsics::SIDE_BY_SIDE;
        let mut twin = PaperCalibrator::<f32, SELFCAL_CAPACITY>::new(rust, cameras, start);
        for index in 0..set.pairs.len() {
            let (of_c, of_rust) = pair(&set, index);
            let taken = get!(paper, selfcal_paper_take_pair, of_c.as_ptr(), of_c.len());
            let outcome = twin.take_pair(of_rust);
            assert_eq!(taken.is_ok(), outcome.fused.is_ok());
            if let Ok(taken) = taken {
                assert_same(&taken.pair.extrinsics, &outcome.pair.unwrap().extrinsics);
            }
            let Some(expected) = twin.estimate() else { continue };
            let found = get!(paper, selfcal_paper_estimate).unwrap();
            assert_same(&found.extrinsics, &expected.extrinsics);
            let sd = [found.sd.rotation_rad, found.sd.translation_rad];
            assert_eq!(bits(&sd), bits(&[expected.sd.rotation, expected.sd.translation]));
            assert_eq!(found.pairs, expected.pairs);
            let axis = (found.axis_concentration, found.axis_is_meaningful);
            assert_eq!(axis, (expected.axis_concentration, expected.axis_is_meaningful));
        }
        assert!(twin.estimate().is_some_and(|estimate| estimate.pairs > 5));
    }
}

#[test]
fn storage_and_arguments_are_checked() {
    let mut paper = Paper::zeroed();
    assert_eq!(get!(paper, selfcal_paper_estimate), Err(SELFCAL_ERROR_NOT_INITIALISED));
    let none = get!(paper, selfcal_paper_take_pair, ptr::null(), 0);
    assert_eq!(none, Err(SELFCAL_ERROR_NOT_INITIALISED));
    let refused = [
        selfcal_paper_config_t { max_passes: 1, ..DEFAULTS },
        selfcal_paper_config_t { min_correspondences: 5, ..DEFAULTS },
        selfcal_paper_config_t { max_correction_rad: 1.5, ..DEFAULTS },
        selfcal_paper_config_t { noise_floor_px: f32::NAN, ..DEFAULTS },
        selfcal_paper_config_t { huber_threshold_px: f32::INFINITY, ..DEFAULTS },
        selfcal_paper_config_t { step_tolerance_rad: -1.0, ..DEFAULTS },
        selfcal_paper_config_t { max_sd_rad: -1.0, ..DEFAULTS },
        selfcal_paper_config_t { angle: 2, ..DEFAULTS },
    ];
    for config in refused {
        assert_eq!(paper.init(&config), SELFCAL_ERROR_CONFIG, "{config:?}");
    }
    let factory = factory(&recorded());
    let size = size_of::<selfcal_paper_t>();
    let odd = paper.ptr().cast::<u8>().wrapping_add(1).cast();
    // SAFETY: live, null or misaligned objects.
    let codes = unsafe {
        [
            selfcal_paper_init(ptr::null_mut(), size, ptr::null(), &factory),
            selfcal_paper_init(odd, size, ptr::null(), &factory),
            selfcal_paper_init(paper.ptr(), 64, ptr::null(), &factory),
            selfcal_paper_init(paper.ptr(), size, ptr::null(), ptr::null()),
        ]
    };
    let expected = [
        SELFCAL_ERROR_NULL,
        SELFCAL_ERROR_ALIGNMENT,
        SELFCAL_ERROR_STORAGE_SIZE,
        SELFCAL_ERROR_NULL,
    ];
    assert_eq!(codes, expected);
    assert_eq!(get!(paper, selfcal_paper_estimate), Err(SELFCAL_ERROR_NOT_INITIALISED));
    assert_eq!(paper.init(ptr::null()), SELFCAL_OK);
    let none = get!(paper, selfcal_paper_take_pair, ptr::null(), 0);
    assert_eq!(none, Err(SELFCAL_ERROR_TOO_FEW));
}
