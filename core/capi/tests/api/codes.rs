//! Each error of the core has the number of an error code, errors with the same remedy share a number, and every value
//! has a text.

use std::collections::BTreeSet;
use std::ffi::{CStr, c_char};
use std::fmt::Debug;

use stereo_selfcal::batch::Pushed;
use stereo_selfcal::depth::{MotionError, RangeError, Witnessed};
use stereo_selfcal::geometry::{ProjectError, RectifyError, Side, UndistortError};
use stereo_selfcal::link::{EncodeError, FrameRefusal, HeaderError, ReceiveError};
use stereo_selfcal::outcome::{Direction, Stop};
use stereo_selfcal::{ApplyError, Cause, Fused, PushError, Reason, Rejection, RestoreError, State};
use stereo_selfcal_capi::selfcal_error_t::{self, *};
use stereo_selfcal_capi::*;

use crate::source::{variants_of_c, variants_of_core};

const UNDISTORT: [UndistortError; 3] =
    [UndistortError::NotFinite, UndistortError::OutsideImage, UndistortError::NotInvertible];
const SIDES: [Side; 2] = [Side::Left, Side::Right];
const PAIR: [Rejection; 7] = [
    Rejection::TooFew { usable: 1, needed: 2 },
    Rejection::NoConsensus,
    Rejection::Unobservable,
    Rejection::Behind,
    Rejection::Columns,
    Rejection::NoDepth,
    Rejection::RowsNotMeasured,
];
const REFUSALS: [Rejection; 5] = [
    Rejection::TooUncertain,
    Rejection::CorrectionLimit,
    Rejection::NoRig,
    Rejection::Disagrees,
    Rejection::Frozen,
];

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
const PROJECT: [ProjectError; 2] = [ProjectError::NotFinite, ProjectError::BeyondLens];
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

/// Error codes of errors of the core; checks that the numbers are equal.
fn codes<E: Copy + Into<selfcal_error_t>>(
    all: &[E],
    number: impl Fn(&E) -> u16,
) -> Vec<selfcal_error_t> {
    let codes = all.iter().map(|error| (*error).into()).collect::<Vec<_>>();
    let numbers = all.iter().map(|error| u32::from(number(error)));
    assert_eq!(
        codes.iter().map(|code| *code as u32).collect::<Vec<_>>(),
        numbers.collect::<Vec<_>>()
    );
    codes
}

#[test]
fn every_error_of_the_core_has_an_error_code() {
    assert_complete("UndistortError", &UNDISTORT);
    assert_complete("ProjectError", &PROJECT);
    assert_complete("PushError", &push_errors());
    assert_complete("RangeError", &range_errors());
    assert_complete("MotionError", &MOTION);
    assert_complete("Rejection", &[&PAIR[..], &REFUSALS, &[Rejection::NotBegun]].concat());
    assert_complete("ApplyError", &APPLY);
    assert_complete("RectifyError", &rectify_errors());
    assert_complete("RestoreError", &RESTORE);
    assert_complete("FrameRefusal", &FRAME);
    let all = [
        codes(&UNDISTORT, UndistortError::code),
        codes(&PROJECT, ProjectError::code),
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
    assert!(!all.contains(&SELFCAL_OK) && !all.contains(&SELFCAL_ERROR_UNKNOWN));
    // The error codes below 100 are for misuse of the C API.
    let numbers: BTreeSet<i64> = all.iter().map(|code| i64::from(*code as u32)).collect();
    let declared = variants_of_c("selfcal_error_t").into_iter().map(|(_, number)| number);
    assert_eq!(numbers, declared.filter(|number| *number >= 100).collect());
}

#[test]
fn errors_with_one_remedy_share_a_code_and_others_do_not() {
    let states = [State::Acquiring, State::Lost].map(|state| ApplyError::NotLocked(state).code());
    let locked = [RangeError::NotLocked.code(), MotionError::NotLocked.code()];
    assert_eq!([states, locked], [[SELFCAL_ERROR_NOT_LOCKED as u16; 2]; 2]);
    assert_eq!(ApplyError::Frozen.code(), Rejection::Frozen.code());
    assert_eq!(PushError::Busy.code(), FrameRefusal::Busy.code());
    let rejections: BTreeSet<u16> = PAIR.iter().chain(&REFUSALS).map(Rejection::code).collect();
    assert_eq!(rejections.len(), PAIR.len() + REFUSALS.len());
    let apply: BTreeSet<u16> = APPLY.iter().map(ApplyError::code).collect();
    let restore: BTreeSet<u16> = RESTORE.iter().map(RestoreError::code).collect();
    assert_eq!((apply.len(), restore.len()), (APPLY.len(), RESTORE.len()));
}

#[test]
fn the_other_errors_of_the_link_have_numbers_of_their_own() {
    let busy = FrameRefusal::Busy;
    let receive: [ReceiveError<u8, u8>; 5] = [
        ReceiveError::Bus(0),
        ReceiveError::Ready(0),
        ReceiveError::Ended,
        busy.into(),
        ReceiveError::TimedOut,
    ];
    assert_complete("HeaderError", &HEADER);
    assert_complete("EncodeError", &ENCODE);
    assert_complete("ReceiveError", &receive);
    // Three errors of a header share a number, because the sender must correct each of them. The error of a score has
    // the number that `PushError` uses.
    let numbers = [
        HEADER[..4].iter().map(HeaderError::code).collect(),
        ENCODE.map(|error| error.code()).to_vec(),
        receive.map(|error| error.code()).to_vec(),
    ]
    .concat();
    let refusals = numbers.iter().filter(|number| **number == busy.code()).count();
    assert_eq!(refusals, 1, "a refused frame keeps its number");
    assert_eq!(numbers.iter().collect::<BTreeSet<_>>().len(), numbers.len());
    let shared = [busy.code(), EncodeError::Score.code()];
    assert!(numbers.iter().all(|number| shared.contains(number) || *number >= 1110));
}

/// Checks that the values of an enumeration of C have the numbers of the core plus an offset. Values of C for none, not
/// fused or unknown have no counterpart in the core.
fn assert_verdicts<V: Debug + Copy>(names: [&str; 2], all: &[V], numbers: impl Fn(V) -> [u32; 2]) {
    let [core, c] = names;
    assert_complete(core, all);
    for (number, of_c) in all.iter().map(|verdict| numbers(*verdict).into()) {
        assert_eq!(number, of_c, "{core}");
    }
    let known = variants_of_c(c).into_iter();
    let has_unknown = all.iter().any(|verdict| format!("{verdict:?}") == "Unknown");
    let of_c_alone = |name: &str| {
        name.ends_with("_NONE")
            || name.ends_with("_NOT")
            || (!has_unknown && name.ends_with("_UNKNOWN"))
    };
    let known = known.filter(|(name, _)| !of_c_alone(name));
    assert_eq!(known.count(), all.len(), "{c}");
}

#[test]
fn every_verdict_of_the_core_is_known() {
    macro_rules! verdicts {
        ($($core:ident, $c:ident from $first:literal: $($verdict:ident)+;)+) => {$(
            let names = [stringify!($core), stringify!($c)];
            assert_verdicts(names, &[$($core::$verdict),+], |verdict| {
                [u32::from(verdict.code()) + $first, $c::from(verdict) as u32]
            });
        )+};
    }
    verdicts! {
        State, selfcal_state_t from 13000: Acquiring Locked Suspect Lost;
        Stop, selfcal_stop_t from 11000: Converged NoDescent PassesSpent;
        Fused, selfcal_fused_t from 12000: Added Repeated KeptApart Renewed TookOver LensCorrected;
        Direction, selfcal_direction_t from 15000: Pitch Yaw Roll BaselineForward BaselineDown;
        Cause, selfcal_cause_t from 18000: Reversed Upright Transposed SameImage SmallerImages LargerImages FocalLength Lens Mismatches
            RowsNotMeasured Moments;
        Pushed, selfcal_pushed_t from 10000: Kept Replaced LeftOut;
        Witnessed, selfcal_witnessed_t from 19000: Taken Waiting;
    }
    assert_eq!(selfcal_cause_t::from(None), selfcal_cause_t::SELFCAL_CAUSE_NONE);
}

#[test]
fn every_reason_of_the_core_is_a_bit_of_its_name() {
    assert_complete("Reason", &Reason::ALL);
    let of_core = Reason::ALL.map(|reason| {
        let name = format!("{reason:?}").to_uppercase();
        (name, i64::from(reason.code()) << 16)
    });
    let of_c = variants_of_c("selfcal_reason_t").into_iter().map(|(name, number)| {
        (name.trim_start_matches("SELFCAL_REASON_").replace('_', ""), number)
    });
    assert_eq!(of_c.collect::<BTreeSet<_>>(), of_core.into_iter().collect());
}

pub(crate) fn string(text: *const c_char) -> String {
    assert!(!text.is_null());
    // SAFETY: a static text.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

#[test]
fn every_value_has_its_own_number_and_a_text_that_is_its_own_within_its_enumeration() {
    let mut numbers = BTreeSet::new();
    for name in [
        "selfcal_error_t",
        "selfcal_pushed_t",
        "selfcal_witnessed_t",
        "selfcal_stop_t",
        "selfcal_fused_t",
        "selfcal_state_t",
        "selfcal_direction_t",
        "selfcal_reason_t",
        "selfcal_cause_t",
    ] {
        let mut texts = BTreeSet::new();
        for (variant, number) in variants_of_c(name) {
            assert!(numbers.insert(number), "{variant} has the number of another");
            let text = string(selfcal_string(number.try_into().unwrap()));
            let unknown = name != "selfcal_error_t" && variant.ends_with("_UNKNOWN");
            assert_eq!(text == "unknown", unknown, "{variant}");
            assert!(text.is_ascii() && !text.starts_with(' ') && !text.ends_with('.'), "{text}");
            assert!(texts.insert(text), "{variant} has the text of another");
        }
    }
    assert_eq!(string(selfcal_string(u32::MAX)), "unknown");
}

#[test]
fn the_states_have_the_names_of_the_core() {
    for state in [State::Acquiring, State::Locked, State::Suspect, State::Lost] {
        let number = selfcal_state_t::from(state) as u32;
        assert_eq!(string(selfcal_string(number)), state.to_string());
    }
}
