//! A whole run through C is bit-identical to the same run through Rust.

use std::ptr;

use nalgebra::Matrix3;
use rigs::data::Dataset;
use stereo_selfcal::batch::Pushed;
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};
use stereo_selfcal::{
    Calibration, Calibrator, Cameras, Config, Extrinsics, FactoryCalibration, PairReport, State,
};
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::rig::{Cal, Observed, advance, defaults, factory, finish, get, pair, recorded};

pub(crate) type Twin = Calibrator<f32, SELFCAL_CAPACITY>;

pub(crate) fn bits(of: &[f32]) -> Vec<u32> {
    of.iter().map(|x| x.to_bits()).collect()
}

pub(crate) fn assert_same(c: &selfcal_extrinsics_t, rust: &Extrinsics<f32>) {
    assert_eq!(bits(&c.rotation), bits(&rust.rotation_row_major()));
    assert_eq!(bits(&c.translation), bits(rust.translation().as_slice()));
}

fn assert_same_calibration(c: &selfcal_calibration_t, rust: &Calibration<f32>) {
    assert_same(&c.extrinsics, &rust.extrinsics);
    assert_eq!(c.left, (&rust.cameras.left).into());
    assert_eq!(c.right, (&rust.cameras.right).into());
    assert_eq!(c.generation, rust.generation);
}

fn assert_rows(c: &[f32; 9], rust: &Matrix3<f32>) {
    assert_eq!(bits(c), bits(rust.transpose().as_slice()));
}

pub(crate) fn push(cal: &mut Cal, twin: &mut Twin, set: &Dataset, index: usize) {
    let (c, rust) = pair(set, index);
    let counts = get!(cal, selfcal_push_array, c.as_ptr(), c.len()).unwrap();
    let all: Vec<_> = rust.iter().map(|m| twin.push(m)).collect();
    let count = |wanted: Pushed| all.iter().filter(|p| **p == Ok(wanted)).count();
    assert_eq!(counts.kept, count(Pushed::Kept));
    assert_eq!(counts.replaced, count(Pushed::Replaced));
    assert_eq!(counts.left_out, count(Pushed::LeftOut));
    assert_eq!((counts.refused, counts.first_refusal), (0, SELFCAL_OK));
    let batch = get!(cal, selfcal_batch).unwrap();
    assert_eq!(usize::try_from(batch.held).unwrap(), twin.batch().matches().len());
    assert_eq!(
        (batch.offered, batch.left_out, batch.refused),
        (twin.batch().offered(), twin.batch().left_out(), twin.batch().refused())
    );
}

/// Solves the batch in both, pass by pass, and compares the outcomes.
fn solve(cal: &mut Cal, twin: &mut Twin) {
    loop {
        let (ended, c) = advance(cal);
        let rust = twin.advance_pair();
        assert_eq!(ended, rust.is_some());
        if let Some(rust) = rust {
            assert_eq!(c.map(|c| c.fused), rust.fused.map(Into::into).map_err(Into::into));
            assert_eq!(c.is_ok_and(|c| c.has_pair), rust.fused.is_ok());
            if let (Ok(c), Some(rust)) = (c, rust.pair) {
                assert_same_report(&c.pair, &rust);
            }
            return;
        }
    }
}

fn assert_same_report(c: &selfcal_report_t, rust: &PairReport<f32>) {
    assert_same(&c.extrinsics, &rust.extrinsics);
    let information = rust.information.matrix();
    for (i, row) in c.information.iter().enumerate() {
        assert!(row.iter().enumerate().all(|(j, x)| x.to_bits() == information[(i, j)].to_bits()));
    }
    assert_eq!(c.stop, rust.stop.into());
    assert_eq!(
        (c.passes, c.usable, c.skipped, c.screened),
        (rust.passes, rust.usable, rust.skipped, rust.screened)
    );
    assert_eq!(
        bits(&[c.cost_before, c.cost_after, c.rms_px_before, c.rms_px_after, c.noise_px]),
        bits(&[
            rust.cost_before,
            rust.cost_after,
            rust.rms_px_before,
            rust.rms_px_after,
            rust.noise_px
        ])
    );
}

pub(crate) fn assert_same_estimate(cal: &mut Cal, twin: &Twin) {
    assert_eq!(get!(cal, selfcal_state), Ok(twin.state().into()));
    let Some(rust) = twin.proposal() else {
        assert_eq!(get!(cal, selfcal_proposal), Err(SELFCAL_ERROR_NO_ESTIMATE));
        return;
    };
    let c = get!(cal, selfcal_proposal).unwrap();
    assert_same(&c.extrinsics, &rust.extrinsics);
    assert_same(&c.applicable, &rust.applicable);
    assert_eq!((c.pairs, c.state), (rust.pairs, rust.state.into()));
    assert_eq!(c.reasons, u32::from(rust.reasons().bits()) << 16);
    assert_eq!((c.baseline_observed, c.lens_yaw), (rust.baseline_observed, rust.lens_yaw.into()));
    let sd = [c.sd.rotation_rad, c.sd.translation_rad];
    assert_eq!(bits(&sd), bits(&[rust.sd.rotation, rust.sd.translation]));
    assert_eq!((c.sd_lens, c.vibration), (rust.sd_lens.into(), rust.vibration.into()));
    assert_eq!(c.correction, rust.correction.into());
    assert_eq!(c.applicable_correction, rust.applicable_correction.into());
    assert_eq!(c.has_lens, rust.lens.is_some());
    assert_eq!(c.lens, rust.lens.map(Into::into).unwrap_or_default());
    let covariance = rust.covariance;
    for (i, row) in c.covariance.iter().enumerate() {
        assert!(row.iter().enumerate().all(|(j, x)| x.to_bits() == covariance[(i, j)].to_bits()));
    }
    assert_eq!(c.weakest, rust.weakest().into());
}

fn assert_same_verdict(cal: &mut Cal, twin: &Twin) {
    let (c, rust) = (get!(cal, selfcal_verdict).unwrap(), twin.verdict());
    assert_eq!(
        bits(&[c.rows_px, c.depth_px, c.coverage, c.image_coverage]),
        bits(&[rust.rows_px, rust.depth_px, rust.coverage, rust.image_coverage])
    );
    assert_eq!(
        [c.rows_ok, c.depth_ok, c.may_arm, c.should_apply],
        [rust.rows_ok, rust.depth_ok, rust.may_arm, rust.should_apply]
    );
    assert_eq!(
        (c.state, c.reasons, c.cause),
        (rust.state.into(), u32::from(rust.reasons.bits()) << 16, rust.cause.into())
    );
}

fn assert_same_details(cal: &mut Cal, twin: &Twin) {
    let c = get!(cal, selfcal_details);
    let Some(rust) = twin.details() else {
        let none = twin.proposal().map_or(SELFCAL_ERROR_NO_ESTIMATE, |_| SELFCAL_ERROR_NO_MATCH);
        assert_eq!(c, Err(none));
        return;
    };
    let c = c.unwrap();
    assert_eq!(
        bits(&[c.in_use_px, c.proposed_px, c.off_px, c.yaw_rad, c.corner_px]),
        bits(&[rust.in_use_px, rust.proposed_px, rust.off_px, rust.yaw, rust.corner_px])
    );
    assert_eq!((c.fit_in_use, c.fit_proposed), (rust.fit_in_use, rust.fit_proposed));
    assert_eq!(
        (c.contradicting_ranges, c.contradicting_motions),
        (rust.contradicting_ranges, rust.contradicting_motions)
    );
    let mut depth = [0.0; 4];
    // SAFETY: live objects.
    let code = unsafe { selfcal_depth_errors(cal.ptr(), 0.12, depth.as_mut_ptr()) };
    let depth = (code == SELFCAL_OK).then(|| bits(&depth));
    let locked = (twin.state() == State::Locked).then(|| bits(&rust.depth_errors(0.12)));
    assert_eq!(depth, locked);
}

fn assert_same_rectification(cal: &mut Cal, twin: &Twin, given: &Cameras<f32>) {
    let proposal = twin.proposal().unwrap();
    let Calibration { cameras: in_use, extrinsics, .. } = twin.in_use();
    let corrected = |correction| given.corrected(&correction).unwrap();
    let [proposed, applicable] =
        [proposal.correction, proposal.applicable_correction].map(corrected);
    let sources = [
        (selfcal_source_t::SELFCAL_SOURCE_IN_USE, in_use, extrinsics),
        (selfcal_source_t::SELFCAL_SOURCE_PROPOSED, proposed, proposal.extrinsics),
        (selfcal_source_t::SELFCAL_SOURCE_APPLICABLE, applicable, proposal.applicable),
    ];
    for (source, cameras, extrinsics) in sources {
        let (source, cameras) = (source as u32, &cameras);
        let rotations = RectifyingRotations::from(&extrinsics);
        let c = get!(cal, selfcal_rotations, source).unwrap();
        assert_rows(&c.left, rotations.left().matrix());
        assert_rows(&c.right, rotations.right().matrix());
        let chosen = RectifiedCamera::try_choose(cameras, &rotations, 0.5).unwrap();
        let c = get!(cal, selfcal_choose_camera, source, 0.5).unwrap();
        let [cx, cy] = chosen.principal;
        assert_eq!(bits(&[c.focal_px]), bits(&[chosen.focal]));
        assert_eq!(bits(&c.principal_px), bits(&[cx, cy]));
        let [left, right] = chosen.homographies(cameras, &rotations);
        let c = get!(cal, selfcal_homographies, source, &raw const c).unwrap();
        assert_rows(&c.left, &left);
        assert_rows(&c.right, &right);
    }
}

/// Applies, undoes twice and applies again in both, and compares the results.
pub(crate) fn change_what_is_in_use(cal: &mut Cal, twin: &mut Twin) {
    let check = |cal: &mut Cal, twin: &Twin, c: Result<selfcal_calibration_t, _>, rust| {
        match rust {
            Ok(rust) => assert_same_calibration(&c.unwrap(), &rust),
            Err(error) => assert_eq!(c, Err(selfcal_error_t::from(error))),
        }
        assert_same_calibration(&get!(cal, selfcal_in_use).unwrap(), &twin.in_use());
    };
    let (c, rust) = (get!(cal, selfcal_apply), twin.apply());
    check(cal, twin, c, rust);
    for _ in 0..2 {
        let (c, rust) = (get!(cal, selfcal_undo), twin.undo());
        check(cal, twin, c, rust);
    }
    let (c, rust) = (get!(cal, selfcal_apply), twin.apply());
    check(cal, twin, c, rust);
}

/// Solves and fuses the batch in both, and compares estimate, verdict and details.
pub(crate) fn take_pair(cal: &mut Cal, twin: &mut Twin) {
    solve(cal, twin);
    assert_same_estimate(cal, twin);
    assert_same_verdict(cal, twin);
    assert_same_details(cal, twin);
}

/// Runs both over the whole set, and compares them after each pair; returns the final state.
pub(crate) fn run(cal: &mut Cal, twin: &mut Twin, set: &Dataset) -> State {
    for index in 0..set.pairs.len() {
        push(cal, twin, set, index);
        take_pair(cal, twin);
        change_what_is_in_use(cal, twin);
        if twin.proposal().is_some() {
            assert_same_rectification(cal, twin, &set.cameras().unwrap());
        }
    }
    twin.state()
}

pub(crate) fn twins(set: &Dataset, c: &selfcal_config_t, rust: Config) -> (Cal, Box<Twin>) {
    let factory = FactoryCalibration::guess(set.cameras().unwrap());
    (Cal::of(set, Some(c)), Box::new(Twin::new(rust, &factory)))
}

#[test]
fn a_run_is_bit_identical_to_rust() {
    let set = recorded();
    let (mut cal, mut twin) = twins(&set, &defaults(), Config::default());
    assert_eq!(run(&mut cal, &mut twin, &set), State::Locked);
    assert!(twin.in_use().generation > 0);
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_reset(cal.ptr()) }, SELFCAL_OK);
    twin.reset();
    assert_same_calibration(&get!(cal, selfcal_in_use).unwrap(), &twin.in_use());
    assert_eq!(run(&mut cal, &mut twin, &set), State::Locked);
}

#[test]
fn factory_extrinsics_are_bit_identical_to_rust() {
    let set = recorded();
    let mut cal = Cal::of(&set, None);
    // Rounded, and t not of unit length: both sides normalise.
    let extrinsics = selfcal_extrinsics_t {
        rotation: [0.9998, 0.02, 0.0, -0.02, 0.9998, 0.0, 0.0, 0.0, 1.0],
        translation: [-0.12, 0.001, 0.0],
    };
    let made = selfcal_factory_t { extrinsics, is_guess: 0, yaw_sd_rad: 0.0, ..factory(&set) };
    // SAFETY: live objects.
    let installed = unsafe {
        selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, ptr::null(), &made)
    };
    assert_eq!(installed, SELFCAL_OK);
    let r = Matrix3::from_row_slice(&extrinsics.rotation);
    let rust = Extrinsics::try_new(&r, &extrinsics.translation.into()).unwrap();
    let cameras = set.cameras().unwrap();
    let mut twin = Box::new(Twin::new(Config::robust(), &FactoryCalibration::new(cameras, rust)));
    let in_use = get!(cal, selfcal_in_use).unwrap();
    assert_eq!(in_use.generation, 0);
    assert_same_calibration(&in_use, &twin.in_use());
    assert_eq!(run(&mut cal, &mut twin, &set), State::Locked);
}

#[test]
fn arrays_single_pushes_and_steps_equal_one_call() {
    let set = recorded();
    let (mut by_call, mut by_array, mut by_one) = (Cal::new(), Cal::new(), Cal::new());
    for index in 0..4 {
        let (all, _) = pair(&set, index);
        let taken = get!(by_call, selfcal_take_pair, all.as_ptr(), all.len());
        get!(by_array, selfcal_push_array, all.as_ptr(), all.len()).unwrap();
        for one in &all {
            // SAFETY: live objects.
            assert_eq!(unsafe { selfcal_push(by_one.ptr(), one, ptr::null_mut()) }, SELFCAL_OK);
        }
        assert_eq!(finish(&mut by_array), taken);
        assert_eq!(get!(by_one, selfcal_solve_pair), taken);
        assert!(taken.unwrap().has_pair);
        let seen = Observed::of(&mut by_call);
        assert_eq!(
            [Observed::of(&mut by_array), Observed::of(&mut by_one)].each_ref(),
            [&seen, &seen]
        );
    }
    assert_eq!(get!(by_one, selfcal_state), Ok(selfcal_state_t::SELFCAL_STATE_LOCKED));
}

#[test]
fn a_frozen_calibrator_changes_nothing_until_it_is_released() {
    let set = recorded();
    let mut cal = Cal::of(&set, None);
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_set_frozen(cal.ptr(), true) }, SELFCAL_OK);
    let (all, _) = pair(&set, 0);
    let taken = get!(cal, selfcal_take_pair, all.as_ptr(), all.len());
    assert_eq!(taken, Err(SELFCAL_ERROR_FROZEN));
    assert_eq!(get!(cal, selfcal_apply), Err(SELFCAL_ERROR_FROZEN));
    assert_eq!(get!(cal, selfcal_undo), Err(SELFCAL_ERROR_FROZEN));
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_set_frozen(cal.ptr(), false) }, SELFCAL_OK);
    let taken = get!(cal, selfcal_take_pair, all.as_ptr(), all.len());
    assert_eq!(taken.unwrap().fused, selfcal_fused_t::SELFCAL_FUSED_ADDED);
}

#[test]
fn a_pair_that_is_solved_and_not_fused_has_a_report() {
    let (mut cal, set) = (Cal::new(), recorded());
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_set_frozen(cal.ptr(), true) }, SELFCAL_OK);
    let (all, _) = pair(&set, 0);
    let mut outcome = std::mem::MaybeUninit::zeroed();
    // SAFETY: live objects; the outcome is written with the errors of a pair.
    let (code, outcome) = unsafe {
        let (from, count) = (all.as_ptr(), all.len());
        let code = selfcal_take_pair(cal.ptr(), from, count, outcome.as_mut_ptr());
        (code, outcome.assume_init())
    };
    assert_eq!((code, outcome.fused), (SELFCAL_ERROR_FROZEN, selfcal_fused_t::SELFCAL_FUSED_NOT));
    assert!(outcome.has_pair && outcome.pair.rms_px_after < outcome.pair.rms_px_before);
}

#[test]
fn header_and_library_state_the_version_of_the_package() {
    // SAFETY: the text is static and ends with a zero.
    let library = unsafe { std::ffi::CStr::from_ptr(selfcal_version()) };
    let package = env!("CARGO_PKG_VERSION");
    assert_eq!(library.to_str(), Ok(package));
    let header = include_str!("../../include/stereo_selfcal.h");
    assert!(header.contains(&format!("#define SELFCAL_VERSION \"{package}\"\n")), "{package}");
    let number = package.split('.').fold(0, |sum, part| sum * 1000 + part.parse::<u32>().unwrap());
    assert!(header.contains(&format!("#define SELFCAL_HEADER \\\n    ({number}u + ")), "{number}");
}
