//! Lens models, the lens prior and the lens estimate through C equal those of Rust.

use stereo_selfcal::{Config, State};
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::selfcal_lens_t::*;
use stereo_selfcal_capi::*;

use crate::life::{bits, run, twins};
use crate::rig::{Cal, defaults, factory, get, recorded};

#[test]
fn a_calibrator_with_a_lens_prior_is_bit_identical_to_rust() {
    let set = recorded();
    for focal in [0.0, 0.002] {
        let yaw_rad = 4e-3;
        let lens_prior =
            selfcal_lens_prior_t { focal, principal_px: 0.0, k1: 0.0, p1: 0.0, p2: 0.0, yaw_rad };
        let c = selfcal_config_t { has_lens_prior: 1, lens_prior, ..defaults() };
        let rust = Config::robust().with_lens_prior(lens_prior.into());
        let rust = rust.and_then(|rust| rust.with_lens_yaw_sd_rad(yaw_rad)).unwrap();
        let (mut cal, mut twin) = twins(&set, &c, rust);
        assert_eq!(run(&mut cal, &mut twin, &set), State::Locked);
        assert_eq!(twin.proposal().unwrap().lens.is_some(), focal > 0.0);
    }
}

#[test]
fn rays_and_pixels_of_all_lens_models_equal_those_of_the_core() {
    let camera = |lens, distortion| selfcal_camera_t {
        focal_px: [534.0, 531.0],
        principal_px: [342.0, 234.5],
        size_px: [640, 480],
        lens: lens as u32,
        distortion,
    };
    let five = |[a, b, c, d, e]: [f32; 5]| [a, b, c, d, e, 0.0, 0.0, 0.0];
    let pinhole = camera(SELFCAL_LENS_PINHOLE, [0.0; 8]);
    let brown = camera(SELFCAL_LENS_RADIAL_TANGENTIAL, five([-0.28, 0.04, 1e-3, -1e-4, 0.11]));
    let fisheye = camera(SELFCAL_LENS_FISHEYE, five([-0.01, 0.02, -0.003, 1e-3, 0.0]));
    let rational = camera(SELFCAL_LENS_RATIONAL, [9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2]);
    for (left, right) in [(pinhole, brown), (fisheye, pinhole), (rational, brown)] {
        let mut cal = Cal::made(None, &selfcal_factory_t { left, right, ..factory(&recorded()) });
        let used = get!(cal, selfcal_in_use).unwrap();
        assert_eq!([used.left, used.right], [left, right]);
        for side in [0, 1] {
            let pixel = [20.0_f32, 460.0];
            let [mut ray, mut back] = [[0.0; 2]; 2];
            // SAFETY: live objects.
            let codes = unsafe {
                [
                    selfcal_ray(cal.ptr(), side, pixel.as_ptr(), ray.as_mut_ptr()),
                    selfcal_pixel(cal.ptr(), side, ray.as_ptr(), back.as_mut_ptr()),
                ]
            };
            assert_eq!(codes, [SELFCAL_OK; 2]);
            assert!(back.iter().zip(pixel).all(|(b, p)| (b - p).abs() < 1e-3), "{back:?}");
            let straight = [(20.0 - 342.0) / 534.0, (460.0 - 234.5) / 531.0];
            let distorted = if side == 0 { left.lens } else { right.lens } != 0;
            assert_eq!(bits(&ray) != bits(&straight), distorted);
        }
    }
}
