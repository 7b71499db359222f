//! Every error of the core has the number of an error code, and every error code a text.

use std::collections::BTreeSet;
use std::ffi::{CStr, c_char};
use std::fmt::Debug;

use stereo_selfcal::link::{
    Damage, EncodeError, FrameRefusal, HeaderError, ReceiveError, RecordError,
};
use stereo_selfcal::{
    ApplyError, Arming, Band, Cause, ConfigError, Direction, Doubt, ExtrinsicsError, Fused,
    MotionError, ProjectError, PushError, Pushed, RangeError, Reason, RectifyError, Rejection,
    RestoreError, Side, State, Stop, UndistortError, Witnessed,
};
use stereo_selfcal_capi::selfcal_error_t::{self, *};
use stereo_selfcal_capi::*;

use crate::rig::{Cal, cameras, recorded};
use crate::source::{variants_of_c, variants_of_core};

const UNDISTORT: [UndistortError; 3] =
    [UndistortError::NotFinite, UndistortError::OutsideImage, UndistortError::NotInvertible];
const SIDES: [Side; 2] = [Side::Left, Side::Right];
const PAIR: [Rejection; 7] = [
    Rejection::NotBegun,
    Rejection::TooFew { usable: 1, needed: 2 },
    Rejection::NoConsensus,
    Rejection::Unobservable,
    Rejection::Behind,
    Rejection::Columns,
    Rejection::NoDepth,
];
const REFUSALS: [Rejection; 5] = [
    Rejection::TooUncertain,
    Rejection::CorrectionLimit,
    Rejection::NoRig,
    Rejection::Disagrees,
    Rejection::Frozen,
];
const STATES: [State; 4] = [State::Acquiring, State::Locked, State::Suspect, State::Lost];

const HEADER: [HeaderError; 6] = [
    HeaderError::Magic,
    HeaderError::Crc,
    HeaderError::Version(2),
    HeaderError::Flags(4),
    HeaderError::FractionBits(9),
    HeaderError::PyramidRatio(1),
];
const ENCODE: [EncodeError; 5] = [
    EncodeError::Coordinate,
    EncodeError::Score,
    EncodeError::GridStep,
    EncodeError::Full,
    EncodeError::Missing(1),
];

fn by_side<E>(of: impl Fn(Side, UndistortError) -> E) -> Vec<E> {
    SIDES.iter().flat_map(|side| UNDISTORT.map(|error| of(*side, error))).collect()
}

fn push_errors() -> Vec<PushError> {
    let plain = [PushError::Busy, PushError::Score, PushError::GridStep];
    plain.into_iter().chain(by_side(PushError::Pixel)).collect()
}

fn range_errors() -> Vec<RangeError> {
    RANGE.into_iter().chain(UNDISTORT.map(RangeError::Pixel)).collect()
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
const MOTION: [MotionError; 4] =
    [MotionError::NotLocked, MotionError::TooFew, MotionError::NoMotion, MotionError::Contradicts];
const EXTRINSICS: [ExtrinsicsError; 3] = [
    ExtrinsicsError::NotARotation,
    ExtrinsicsError::NoDirection,
    ExtrinsicsError::AlongOpticalAxis,
];
const PROJECT: [ProjectError; 2] = [ProjectError::NotFinite, ProjectError::BeyondLens];
const CONFIG: [ConfigError; 13] = [
    ConfigError::HuberThreshold,
    ConfigError::MaxPasses,
    ConfigError::StepTolerance,
    ConfigError::MinCorrespondences,
    ConfigError::NoiseFloor,
    ConfigError::PriorStandardDeviation,
    ConfigError::MaxStandardDeviation,
    ConfigError::Memory,
    ConfigError::MaxCorrection,
    ConfigError::LensPrior,
    ConfigError::FactoryYaw,
    ConfigError::LensYaw,
    ConfigError::BaselineLength,
];
const RANGE: [RangeError; 5] = [
    RangeError::NoBaseline,
    RangeError::NotLocked,
    RangeError::Reading,
    RangeError::NoMatch,
    RangeError::Contradicts,
];
const RESTORE: [RestoreError; 6] = [
    RestoreError::Damaged,
    RestoreError::Foreign,
    RestoreError::Layout(3),
    RestoreError::OtherRig,
    RestoreError::Absurd,
    RestoreError::Config,
];
const FRAME: [FrameRefusal; 2] = [FrameRefusal::Busy, FrameRefusal::ImageSize([1, 2])];

/// Checks that the list has every variant in the source of the core.
fn assert_complete<E: Debug>(name: &str, all: &[E]) {
    let listed = all.iter().map(|error| {
        let text = format!("{error:?}");
        let end = text.find(|c: char| !c.is_alphanumeric()).unwrap_or(text.len());
        text[..end].to_owned()
    });
    assert_eq!(listed.collect::<BTreeSet<_>>(), variants_of_core(name), "{name}");
}

/// Error codes, which have the numbers of the core.
fn codes<E: Copy + Into<selfcal_error_t>>(
    all: &[E],
    number: impl Fn(&E) -> u16,
) -> Vec<selfcal_error_t> {
    let codes = all.iter().map(|error| (*error).into()).collect::<Vec<_>>();
    let numbers = all.iter().map(|error| i32::from(number(error)));
    assert_eq!(
        codes.iter().map(|code| *code as i32).collect::<Vec<_>>(),
        numbers.collect::<Vec<_>>()
    );
    codes
}

/// Errors of both cameras, provoked by cameras that are not valid.
fn camera_codes() -> Vec<selfcal_error_t> {
    let [good, _] = cameras(&recorded());
    let fisheye = selfcal_lens_t::SELFCAL_LENS_FISHEYE as u32;
    let bad = [
        selfcal_camera_t { focal_px: [0.5, 500.0], ..good },
        selfcal_camera_t { principal_px: [1e6, 0.0], ..good },
        selfcal_camera_t { size_px: [640, 1], ..good },
        selfcal_camera_t { distortion: [0.0, 0.0, 0.0, 0.0, 1e4, 0.0, 0.0, 0.0], ..good },
        selfcal_camera_t { lens: 4, ..good },
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
fn every_error_of_the_core_has_its_own_error_code() {
    assert_complete("UndistortError", &UNDISTORT);
    assert_complete("ProjectError", &PROJECT);
    assert_complete("ExtrinsicsError", &EXTRINSICS);
    assert_complete("ConfigError", &CONFIG);
    assert_complete("PushError", &push_errors());
    assert_complete("RangeError", &range_errors());
    assert_complete("MotionError", &MOTION);
    assert_complete("ApplyError", &APPLY);
    assert_complete("RectifyError", &rectify_errors());
    assert_complete("RestoreError", &RESTORE);
    assert_complete("FrameRefusal", &FRAME);
    // Two of the six are of this crate: the lens model, and an unused coefficient.
    assert_eq!(variants_of_core("CameraError").len(), camera_codes().len() / 2 - 2);
    let all = [
        camera_codes(),
        codes(&UNDISTORT, UndistortError::code),
        codes(&PROJECT, ProjectError::code),
        codes(&EXTRINSICS, ExtrinsicsError::code),
        codes(&CONFIG, ConfigError::code),
        codes(&push_errors(), PushError::code),
        codes(&range_errors(), RangeError::code),
        codes(&MOTION, MotionError::code),
        codes(&PAIR, Rejection::code),
        codes(&REFUSALS, Rejection::code),
        codes(&APPLY, ApplyError::code),
        codes(&rectify_errors(), RectifyError::code),
        codes(&RESTORE, RestoreError::code),
        codes(&FRAME, FrameRefusal::code),
        codes(&HEADER[3..], HeaderError::code),
        codes(&ENCODE, EncodeError::code),
    ]
    .concat();
    let numbers: BTreeSet<i32> = all.iter().map(|code| *code as i32).collect();
    assert_eq!(numbers.len(), all.len(), "two errors share a code");
    assert!(!all.contains(&SELFCAL_OK) && !all.contains(&SELFCAL_ERROR_UNKNOWN));
    // Every other error code is one of misuse.
    let of_the_core = |number: i64| number >= 100;
    let known = variants_of_c("selfcal_error_t").into_iter().filter(|(_, n)| of_the_core(*n));
    assert_eq!(numbers.len(), known.count());
}

#[test]
fn the_other_errors_of_the_link_have_numbers_of_their_own() {
    let record = [RecordError::Level(16), RecordError::Reserved(1)];
    let damage = [Damage::Crc, Damage::Truncated, Damage::Unsupported];
    let busy = FrameRefusal::Busy;
    let receive: [ReceiveError<u8, u8>; 5] = [
        ReceiveError::Bus(0),
        ReceiveError::Ready(0),
        ReceiveError::Ended,
        busy.into(),
        ReceiveError::TimedOut,
    ];
    assert_complete("HeaderError", &HEADER);
    assert_complete("RecordError", &record);
    assert_complete("EncodeError", &ENCODE);
    assert_complete("Damage", &damage);
    assert_complete("ReceiveError", &receive);
    let numbers = [
        HEADER.map(|error| error.code()).to_vec(),
        record.map(|error| error.code()).to_vec(),
        ENCODE.map(|error| error.code()).to_vec(),
        damage.map(|damage| damage.code()).to_vec(),
        receive.map(|error| error.code()).to_vec(),
    ]
    .concat();
    let refusals = numbers.iter().filter(|number| **number == busy.code()).count();
    assert_eq!(refusals, 1, "a refused frame keeps its number");
    assert_eq!(numbers.iter().collect::<BTreeSet<_>>().len(), numbers.len());
    assert!(numbers.iter().all(|number| *number == busy.code() || *number >= 1110));
}

#[test]
fn a_rejection_has_the_code_of_what_it_carries() {
    let all = PAIR.map(Rejection::from).into_iter().chain(REFUSALS.map(Rejection::from));
    let all: Vec<Rejection> = all.collect();
    assert_complete("Rejection", &all);
    let carried = [codes(&PAIR, Rejection::code), codes(&REFUSALS, Rejection::code)].concat();
    assert_eq!(codes(&all, Rejection::code), carried);
}

/// Checks that the values of C have the numbers of the core, besides one for none or unknown.
fn assert_verdicts<V: Debug + Copy>(names: [&str; 2], all: &[V], numbers: impl Fn(V) -> [u32; 2]) {
    let [core, c] = names;
    assert_complete(core, all);
    for (number, of_c) in all.iter().map(|verdict| numbers(*verdict).into()) {
        assert_eq!(number, of_c, "{core}");
    }
    let known = variants_of_c(c).into_iter();
    let has_unknown = all.iter().any(|verdict| format!("{verdict:?}") == "Unknown");
    let of_c_alone =
        |name: &str| name.ends_with("_NONE") || (!has_unknown && name.ends_with("_UNKNOWN"));
    let known = known.filter(|(name, _)| !of_c_alone(name));
    assert_eq!(known.count(), all.len(), "{c}");
}

#[test]
fn every_verdict_of_the_core_is_known() {
    macro_rules! verdicts {
        ($($core:ident, $c:ident: $($verdict:ident)+;)+) => {$(
            let names = [stringify!($core), stringify!($c)];
            assert_verdicts(names, &[$($core::$verdict),+], |verdict| {
                [verdict.code().into(), $c::from(verdict) as u32]
            });
        )+};
    }
    verdicts! {
        State, selfcal_state_t: Acquiring Locked Suspect Lost;
        Stop, selfcal_stop_t: Converged NoDescent PassesSpent;
        Fused, selfcal_fused_t: Added Repeated KeptApart Renewed TookOver LensCorrected;
        Doubt, selfcal_doubt_t: Baseline Everything Axis SecondMode;
        Direction, selfcal_direction_t: Pitch Yaw Roll BaselineForward BaselineDown;
        Band, selfcal_band_t: Good Improvable Recalibrate Unknown;
        Arming, selfcal_arming_t: Yes NotLocked Doubtful Misaligned Unfit;
        Reason, selfcal_reason_t: NotLocked Misaligned SecondMode ImageHalves Lens Baseline Repeated Axis Unfit Yaw;
        Cause, selfcal_cause_t: Reversed Upright Transposed SameImage SmallerImages LargerImages FocalLength Lens Mismatches;
        Pushed, selfcal_pushed_t: Kept Replaced LeftOut;
        Witnessed, selfcal_witnessed_t: Taken Waiting;
    }
    assert_eq!(selfcal_doubt_t::from(None), selfcal_doubt_t::SELFCAL_DOUBT_NONE);
}

fn string(text: *const c_char) -> String {
    assert!(!text.is_null());
    // SAFETY: a static text.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

fn assert_texts<N: TryFrom<i64>>(name: &str, text: extern "C" fn(N) -> *const c_char) {
    let mut all = BTreeSet::new();
    let of = |number: i64| string(text(N::try_from(number).ok().unwrap()));
    for (variant, number) in variants_of_c(name) {
        let text = of(number);
        let unknown = number == 255 && variant.ends_with("_UNKNOWN");
        assert_eq!(text == "unknown", unknown, "{variant}");
        assert!(text.is_ascii() && !text.starts_with(' ') && !text.ends_with('.'), "{text}");
        assert!(all.insert(text), "{variant} has the text of another");
    }
    assert_eq!(of(1_000_000), "unknown");
}

#[test]
fn every_value_has_its_own_text() {
    assert_texts("selfcal_error_t", selfcal_error_string);
    assert_texts("selfcal_pushed_t", selfcal_pushed_string);
    assert_texts("selfcal_witnessed_t", selfcal_witnessed_string);
    assert_texts("selfcal_stop_t", selfcal_stop_string);
    assert_texts("selfcal_fused_t", selfcal_fused_string);
    assert_texts("selfcal_state_t", selfcal_state_string);
    assert_texts("selfcal_doubt_t", selfcal_doubt_string);
    assert_texts("selfcal_direction_t", selfcal_direction_string);
    assert_texts("selfcal_band_t", selfcal_band_string);
    assert_texts("selfcal_arming_t", selfcal_arming_string);
    assert_texts("selfcal_reason_t", selfcal_reason_string);
    assert_texts("selfcal_cause_t", selfcal_cause_string);
    assert_eq!(string(selfcal_error_string(-1)), "unknown");
}

#[test]
fn the_states_have_the_names_of_the_core() {
    for state in STATES {
        let number = selfcal_state_t::from(state) as u32;
        assert_eq!(string(selfcal_state_string(number)), state.to_string());
    }
}
