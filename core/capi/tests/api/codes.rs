//! Every error of the core has a code of its own, and every code its words.

use std::collections::BTreeSet;
use std::ffi::{CStr, c_char};
use std::fmt::Debug;

use stereo_selfcal::link::FrameRefusal;
use stereo_selfcal::{
    ApplyError, ConfigError, Doubt, ExtrinsicsError, Fused, PairError, ProjectError, PushError,
    RectifyError, Refusal, Rejection, RestoreError, Side, SnapshotError, State, Stop,
    UndistortError,
};
use stereo_selfcal_capi::selfcal_error_t::{self, *};
use stereo_selfcal_capi::*;

use crate::rig::{Cal, cameras, recorded};
use crate::source::{variants_of_c, variants_of_core};

const UNDISTORT: [UndistortError; 3] =
    [UndistortError::NotFinite, UndistortError::OutsideImage, UndistortError::NotInvertible];
const SIDES: [Side; 2] = [Side::Left, Side::Right];
const PAIR: [PairError; 5] = [
    PairError::NoCameras,
    PairError::NotBegun,
    PairError::TooFew { usable: 1, needed: 2 },
    PairError::NoConsensus,
    PairError::Unobservable,
];
const REFUSALS: [Refusal; 6] = [
    Refusal::TooUncertain,
    Refusal::CorrectionLimit,
    Refusal::NoRig,
    Refusal::Disagrees,
    Refusal::NothingSolved,
    Refusal::Frozen,
];
const STATES: [State; 4] = [State::Acquiring, State::Locked, State::Suspect, State::Lost];

fn by_side<E>(of: impl Fn(Side, UndistortError) -> E) -> Vec<E> {
    SIDES.iter().flat_map(|side| UNDISTORT.map(|error| of(*side, error))).collect()
}

fn push_errors() -> Vec<PushError> {
    let plain = [PushError::NoCameras, PushError::Busy, PushError::Score, PushError::GridStep];
    plain.into_iter().chain(by_side(PushError::Pixel)).collect()
}

fn rectify_errors() -> Vec<RectifyError> {
    let plain = [RectifyError::Alpha, RectifyError::NoCommonView];
    let behind = SIDES.map(RectifyError::Behind);
    plain.into_iter().chain(behind).chain(by_side(RectifyError::Border)).collect()
}

const APPLY: [ApplyError; 6] = [
    ApplyError::NoProposal,
    ApplyError::Inconsistent,
    ApplyError::NotLocked(State::Lost),
    ApplyError::Doubtful,
    ApplyError::Frozen,
    ApplyError::NothingToUndo,
];
const EXTRINSICS: [ExtrinsicsError; 3] = [
    ExtrinsicsError::NotARotation,
    ExtrinsicsError::NoDirection,
    ExtrinsicsError::AlongOpticalAxis,
];
const PROJECT: [ProjectError; 2] = [ProjectError::NotFinite, ProjectError::BeyondLens];
const CONFIG: [ConfigError; 9] = [
    ConfigError::HuberThreshold,
    ConfigError::MaxPasses,
    ConfigError::StepTolerance,
    ConfigError::MinCorrespondences,
    ConfigError::NoiseFloor,
    ConfigError::PriorStandardDeviation,
    ConfigError::MaxStandardDeviation,
    ConfigError::Memory,
    ConfigError::MaxCorrection,
];
const SNAPSHOT: [SnapshotError; 2] = [SnapshotError::Room { needed: 1 }, SnapshotError::NoCameras];
const RESTORE: [RestoreError; 10] = [
    RestoreError::Damaged,
    RestoreError::Foreign,
    RestoreError::Version(3),
    RestoreError::Scalar,
    RestoreError::Preset,
    RestoreError::OtherRig,
    RestoreError::Absurd,
    RestoreError::CorrectionLimit,
    RestoreError::NotFresh,
    RestoreError::NoCameras,
];
const FRAME: [FrameRefusal; 3] =
    [FrameRefusal::Busy, FrameRefusal::NoCameras, FrameRefusal::ImageSize([1, 2])];

/// The list has every variant that the source of the core has.
fn assert_complete<E: Debug>(name: &str, all: &[E]) {
    let listed = all.iter().map(|error| {
        let text = format!("{error:?}");
        let end = text.find(|c: char| !c.is_alphanumeric()).unwrap_or(text.len());
        text[..end].to_owned()
    });
    assert_eq!(listed.collect::<BTreeSet<_>>(), variants_of_core(name), "{name}");
}

fn codes<E: Copy + Into<selfcal_error_t>>(all: &[E]) -> Vec<selfcal_error_t> {
    all.iter().map(|error| (*error).into()).collect()
}

/// Those of both cameras, by way of cameras that are wrong.
fn camera_codes() -> Vec<selfcal_error_t> {
    let [good, _] = cameras(&recorded());
    let fisheye = selfcal_lens_t::SELFCAL_LENS_FISHEYE as u32;
    let bad = [
        selfcal_camera_t { focal_px: [0.5, 500.0], ..good },
        selfcal_camera_t { principal_px: [1e6, 0.0], ..good },
        selfcal_camera_t { size_px: [640, 1], ..good },
        selfcal_camera_t { distortion: [0.0, 0.0, 0.0, 0.0, 1e4], ..good },
        selfcal_camera_t { lens: 3, ..good },
        selfcal_camera_t { lens: fisheye, ..good },
    ];
    let mut cal = Cal::new(None);
    bad.iter()
        .flat_map(|bad| {
            // SAFETY: live objects.
            unsafe {
                [
                    selfcal_set_cameras(cal.ptr(), bad, &good),
                    selfcal_set_cameras(cal.ptr(), &good, bad),
                ]
            }
        })
        .collect()
}

#[test]
fn every_error_of_the_core_has_a_code_of_its_own() {
    assert_complete("UndistortError", &UNDISTORT);
    assert_complete("ProjectError", &PROJECT);
    assert_complete("ExtrinsicsError", &EXTRINSICS);
    assert_complete("ConfigError", &CONFIG);
    assert_complete("PushError", &push_errors());
    assert_complete("PairError", &PAIR);
    assert_complete("Refusal", &REFUSALS);
    assert_complete("ApplyError", &APPLY);
    assert_complete("RectifyError", &rectify_errors());
    assert_complete("SnapshotError", &SNAPSHOT);
    assert_complete("RestoreError", &RESTORE);
    assert_complete("FrameRefusal", &FRAME);
    // Two of the six are of this crate: the lens model, and a coefficient too many.
    assert_eq!(variants_of_core("CameraError").len(), camera_codes().len() / 2 - 2);
    let all = [
        camera_codes(),
        codes(&UNDISTORT),
        codes(&PROJECT),
        codes(&EXTRINSICS),
        codes(&CONFIG),
        codes(&push_errors()),
        codes(&PAIR),
        codes(&REFUSALS),
        codes(&APPLY),
        codes(&rectify_errors()),
        codes(&SNAPSHOT),
        codes(&RESTORE),
        codes(&FRAME),
    ]
    .concat();
    let numbers: BTreeSet<i32> = all.iter().map(|code| *code as i32).collect();
    assert_eq!(numbers.len(), all.len(), "two errors share a code");
    assert!(!all.contains(&SELFCAL_OK) && !all.contains(&SELFCAL_ERROR_UNKNOWN));
    // And no code but those of misuse is without an error.
    let of_the_core = |number: i64| number >= 100;
    let known = variants_of_c("selfcal_error_t").into_iter().filter(|(_, n)| of_the_core(*n));
    assert_eq!(numbers.len(), known.count());
}

#[test]
fn a_rejection_has_the_code_of_what_it_carries() {
    let all = PAIR.map(Rejection::from).into_iter().chain(REFUSALS.map(Rejection::from));
    let all: Vec<Rejection> = all.collect();
    assert_complete("Rejection", &all);
    assert_eq!(codes(&all), [codes(&PAIR), codes(&REFUSALS)].concat());
}

#[test]
fn every_state_of_the_core_is_known() {
    let stops = [Stop::Converged, Stop::NoDescent, Stop::PassesSpent];
    let fused = [Fused::Added, Fused::Repeated, Fused::KeptApart, Fused::Renewed, Fused::TookOver];
    let doubts = [Doubt::Baseline, Doubt::Everything, Doubt::Axis];
    assert_complete("State", &STATES);
    assert_complete("Stop", &stops);
    assert_complete("Fused", &fused);
    assert_complete("Doubt", &doubts);
    let states = STATES.map(|state| selfcal_state_t::from(state) as u32);
    let stops = stops.map(|stop| selfcal_stop_t::from(stop) as u32);
    let fused = fused.map(|fused| selfcal_fused_t::from(fused) as u32);
    let doubts = [None, Some(doubts[0]), Some(doubts[1]), Some(doubts[2])];
    let doubts = doubts.map(|doubt| selfcal_doubt_t::from(doubt) as u32);
    assert_eq!((states, stops), ([0, 1, 2, 3], [0, 1, 2]));
    assert_eq!((fused, doubts), ([0, 1, 2, 3, 4], [0, 1, 2, 3]));
}

fn words(text: *const c_char) -> String {
    assert!(!text.is_null());
    // SAFETY: a static text.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

fn assert_in_words<N: TryFrom<i64>>(name: &str, string: extern "C" fn(N) -> *const c_char) {
    let mut all = BTreeSet::new();
    let of = |number: i64| words(string(N::try_from(number).ok().unwrap()));
    for (variant, number) in variants_of_c(name) {
        let text = of(number);
        let unknown = number == 255 && variant.ends_with("_UNKNOWN");
        assert_eq!(text == "unknown", unknown, "{variant}");
        assert!(all.insert(text), "{variant} has the words of another");
    }
    assert_eq!(of(1_000_000), "unknown");
}

#[test]
fn every_number_has_words_of_its_own() {
    assert_in_words("selfcal_error_t", selfcal_error_string);
    assert_in_words("selfcal_pushed_t", selfcal_pushed_string);
    assert_in_words("selfcal_stop_t", selfcal_stop_string);
    assert_in_words("selfcal_fused_t", selfcal_fused_string);
    assert_in_words("selfcal_state_t", selfcal_state_string);
    assert_in_words("selfcal_doubt_t", selfcal_doubt_string);
    assert_in_words("selfcal_direction_t", selfcal_direction_string);
    assert_in_words("selfcal_band_t", selfcal_band_string);
    assert_in_words("selfcal_arming_t", selfcal_arming_string);
    assert_eq!(words(selfcal_error_string(-1)), "unknown");
}

#[test]
fn the_states_are_called_what_the_core_calls_them() {
    for state in STATES {
        let number = selfcal_state_t::from(state) as u32;
        assert_eq!(words(selfcal_state_string(number)), state.to_string());
    }
}
