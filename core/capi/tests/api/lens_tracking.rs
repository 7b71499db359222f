//! Compensation of lens errors: the functions use extrinsics with the cameras that they belong to.

use rigs::data::Dataset;
use sim::synth::{LensErrors, Scene, rig};
use stereo_selfcal::{Config, LensTracking};
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::selfcal_fused_t::SELFCAL_FUSED_LENS_CORRECTED;
use stereo_selfcal_capi::selfcal_lens_tracking_t::*;
use stereo_selfcal_capi::selfcal_source_t::SELFCAL_SOURCE_IN_USE;
use stereo_selfcal_capi::*;

use crate::life::{Twin, bits, change_what_is_in_use, push, run, take_pair, twins};
use crate::record::{restore, snapshot};
use crate::rig::{Cal, cameras, defaults, factory, get, pair};

/// Excess of the right focal length over the given one, relative.
const LONGER: f32 = 0.003;
const PAIRS: usize = 60;

/// Pairs of a rig whose right focal length is longer than given.
fn longer() -> Dataset {
    let lens_errors = "f_r=0.3%".parse::<LensErrors>().unwrap().given;
    let rig = rig([1.0, -0.5, 0.8], [0.5, -0.4]).unwrap();
    Scene { lens_errors, rig, matches: 250, ..Scene::default() }.dataset(PAIRS, 1).unwrap()
}

fn tracking(tracking: selfcal_lens_tracking_t) -> selfcal_config_t {
    selfcal_config_t { lens_tracking: tracking as u32, ..defaults() }
}

fn compensating(set: &Dataset) -> (Cal, Box<Twin>) {
    let rust = Config::robust().with_lens_tracking(LensTracking::Compensate);
    twins(set, &tracking(SELFCAL_LENS_TRACKING_COMPENSATE), rust)
}

/// Relative excess of the right focal length in use over the given one, and the right camera in use.
fn in_use(cal: &mut Cal, set: &Dataset) -> (f32, selfcal_camera_t) {
    let used = get!(cal, selfcal_in_use).unwrap();
    let [left, right] = cameras(set);
    assert_eq!(used.left, left);
    (used.right.focal_px[0] / right.focal_px[0] - 1.0, used.right)
}

/// Pixel of a ray in the right camera in use; checks that the pixel has this ray.
fn pixel(cal: &mut Cal, ray: [f32; 2]) -> [f32; 2] {
    let [mut pixel, mut back] = [[0.0; 2]; 2];
    // SAFETY: live objects.
    let codes = unsafe {
        [
            selfcal_pixel(cal.ptr(), 1, ray.as_ptr(), pixel.as_mut_ptr()),
            selfcal_ray(cal.ptr(), 1, pixel.as_ptr(), back.as_mut_ptr()),
        ]
    };
    assert_eq!(codes, [SELFCAL_OK; 2]);
    assert!(back.iter().zip(ray).all(|(b, r)| (b - r).abs() < 1e-5), "{back:?}");
    pixel
}

/// Takes all pairs; returns the number of pairs that corrected the lens.
fn take_all(cal: &mut Cal, set: &Dataset) -> usize {
    let mut corrected = 0;
    for index in 0..PAIRS {
        let (all, _) = pair(set, index);
        let outcome = get!(cal, selfcal_take_pair, all.as_ptr(), all.len()).unwrap();
        if outcome.fused == SELFCAL_FUSED_LENS_CORRECTED {
            corrected += 1;
            assert_eq!(get!(cal, selfcal_batch).unwrap().held, 0);
            assert_eq!(get!(cal, selfcal_proposal), Err(SELFCAL_ERROR_NO_ESTIMATE));
            assert_eq!(get!(cal, selfcal_details), Err(SELFCAL_ERROR_NO_ESTIMATE));
            assert!(outcome.has_pair);
        }
    }
    corrected
}

fn homographies(cal: &mut Cal) -> selfcal_homographies_t {
    let camera = selfcal_rectified_camera_t { focal_px: 1400.0, principal_px: [960.0, 600.0] };
    let source = SELFCAL_SOURCE_IN_USE as u32;
    get!(cal, selfcal_homographies, source, &raw const camera).unwrap()
}

#[test]
fn a_longer_focal_length_is_compensated_and_rectified_with() {
    let set = longer();
    let mut cal = Cal::of(&set, Some(&tracking(SELFCAL_LENS_TRACKING_COMPENSATE)));
    assert!(take_all(&mut cal, &set) > 0);
    assert!(in_use(&mut cal, &set).0.abs() < f32::EPSILON, "not before it is applied");
    let by_given = pixel(&mut cal, [0.4, -0.2]);
    let proposal = get!(cal, selfcal_proposal).unwrap();
    let applied = get!(cal, selfcal_apply).unwrap();
    assert_eq!(get!(cal, selfcal_in_use), Ok(applied));
    assert_eq!(applied.extrinsics, proposal.applicable);
    let (longer, right) = in_use(&mut cal, &set);
    assert!((longer - LONGER).abs() < 3e-4, "{longer}");
    assert!((longer - proposal.applicable_correction.focal).abs() < 1e-6, "{longer}");
    let moved = pixel(&mut cal, [0.4, -0.2])[0] - by_given[0];
    assert!((moved - 0.4 * 1400.0 * LONGER).abs() < 0.3, "{moved}");

    // A calibrator that is given the cameras and extrinsics of the calibration in use has the same homographies.
    let selfcal_calibration_t { left, extrinsics, .. } = applied;
    let mut other =
        Cal::made(None, &selfcal_factory_t { left, right, extrinsics, ..factory(&set) });
    let [h, expected] = [homographies(&mut cal), homographies(&mut other)];
    let apart = h.right.iter().zip(expected.right).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f32::max) < 1e-3, "{h:?} {expected:?}");
}

#[test]
fn compensation_is_bit_identical_to_rust_and_kept_over_a_loss_of_power() {
    let set = longer();
    let (mut cal, mut twin) = compensating(&set);
    run(&mut cal, &mut twin, &set);
    assert!(!twin.proposal().unwrap().correction.is_none());
    let record = snapshot(&mut cal);
    let used = get!(cal, selfcal_in_use).unwrap();
    let (mut next, mut next_twin) = compensating(&set);
    assert_eq!(restore(&mut next, &record), SELFCAL_OK);
    next_twin.restore(&record).unwrap();
    let restored = get!(next, selfcal_in_use).unwrap();
    assert_eq!([restored.left, restored.right], [used.left, used.right]);
    assert_eq!(bits(&restored.right.focal_px), bits(&used.right.focal_px));
    push(&mut next, &mut next_twin, &set, 0);
    take_pair(&mut next, &mut next_twin);
    change_what_is_in_use(&mut next, &mut next_twin);
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_reset(next.ptr()) }, SELFCAL_OK);
    assert!(in_use(&mut next, &set).0.abs() < f32::EPSILON);
}

#[test]
fn only_the_tracking_that_compensates_corrects_the_lens() {
    let set = longer();
    for (which, compensates) in
        [(SELFCAL_LENS_TRACKING_COMPENSATE, true), (SELFCAL_LENS_TRACKING_REPORT, false)]
    {
        let mut cal = Cal::of(&set, Some(&tracking(which)));
        assert_eq!(take_all(&mut cal, &set) > 0, compensates);
    }
}
