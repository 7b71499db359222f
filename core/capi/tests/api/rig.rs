//! A calibrator behind its pointer, recorded pairs, and its observable state.

use std::mem::MaybeUninit;
use std::ptr;

use rigs::data::Dataset;
use stereo_selfcal::{Cameras, Correspondence, FactoryCalibration};
use stereo_selfcal_capi::selfcal_error_t::{SELFCAL_ERROR_UNKNOWN, SELFCAL_OK};
use stereo_selfcal_capi::*;

/// Storage on the heap, zeroed as static storage of C.
pub(crate) struct Cal(Box<MaybeUninit<selfcal_t>>);

impl Cal {
    /// Not initialised.
    pub(crate) fn zeroed() -> Self {
        Self(Box::new(MaybeUninit::zeroed()))
    }

    /// Initialised, with the cameras of the recorded set.
    pub(crate) fn new() -> Self {
        Self::of(&recorded(), None)
    }

    /// Initialised, with the cameras of a data set.
    pub(crate) fn of(set: &Dataset, config: Option<&selfcal_config_t>) -> Self {
        Self::made(config, &factory(set))
    }

    /// Initialised at a factory calibration.
    pub(crate) fn made(config: Option<&selfcal_config_t>, factory: &selfcal_factory_t) -> Self {
        let mut cal = Self::zeroed();
        let config = config.map_or(ptr::null(), ptr::from_ref);
        // SAFETY: live objects, and storage of that size.
        let code = unsafe {
            selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, config, factory)
        };
        assert_eq!(code, SELFCAL_OK);
        cal
    }

    pub(crate) fn ptr(&mut self) -> *mut selfcal_t {
        self.0.as_mut_ptr()
    }
}

/// Calls a function with one result; returns the result, or the error.
macro_rules! get {
    ($cal:expr, $function:ident $(, $argument:expr)*) => {{
        let mut out = std::mem::MaybeUninit::zeroed();
        // SAFETY: live objects.
        match unsafe { $function($cal.ptr() $(, $argument)*, out.as_mut_ptr()) } {
            // SAFETY: written without an error.
            SELFCAL_OK => Ok(unsafe { out.assume_init() }),
            error => Err(error),
        }
    }};
}
pub(crate) use get;

/// Observable state, which a refused call must not change.
#[derive(Debug, PartialEq)]
pub(crate) struct Observed {
    in_use: Result<selfcal_calibration_t, selfcal_error_t>,
    batch: Result<selfcal_batch_t, selfcal_error_t>,
    state: Result<selfcal_state_t, selfcal_error_t>,
    proposal: Result<selfcal_proposal_t, selfcal_error_t>,
    verdict: Result<selfcal_verdict_t, selfcal_error_t>,
    details: Result<selfcal_details_t, selfcal_error_t>,
}

impl Observed {
    pub(crate) fn of(cal: &mut Cal) -> Self {
        Self {
            in_use: get!(cal, selfcal_in_use),
            batch: get!(cal, selfcal_batch),
            state: get!(cal, selfcal_state),
            proposal: get!(cal, selfcal_proposal),
            verdict: get!(cal, selfcal_verdict),
            details: get!(cal, selfcal_details),
        }
    }
}

/// The recorded set of the C examples; a third of its matches are outliers.
pub(crate) fn recorded() -> Dataset {
    Dataset::load(&Dataset::shipped().join("opencv_chess_sift")).unwrap()
}

pub(crate) fn cameras(set: &Dataset) -> [selfcal_camera_t; 2] {
    let Cameras { left, right } = set.cameras::<f32>().unwrap();
    [(&left).into(), (&right).into()]
}

/// Factory calibration of a data set: its cameras, and a guess of the extrinsics, side by side.
pub(crate) fn factory(set: &Dataset) -> selfcal_factory_t {
    (&FactoryCalibration::guess(set.cameras().unwrap())).into()
}

/// A configuration of defaults.
pub(crate) fn defaults() -> selfcal_config_t {
    // SAFETY: zeros are a configuration.
    unsafe { MaybeUninit::zeroed().assume_init() }
}

/// Takes a step of a pair; returns whether the pair has ended, and its outcome or error.
pub(crate) fn advance(cal: &mut Cal) -> (bool, Result<selfcal_outcome_t, selfcal_error_t>) {
    let (mut ended, mut outcome) = (false, MaybeUninit::zeroed());
    // SAFETY: live objects; zeros are no outcome, and are not read before one is written.
    let code = unsafe { selfcal_advance_pair(cal.ptr(), &mut ended, outcome.as_mut_ptr()) };
    if !ended {
        assert_eq!(code, SELFCAL_OK);
        return (false, Err(SELFCAL_ERROR_UNKNOWN));
    }
    // SAFETY: written once the pair has ended.
    let outcome = unsafe { outcome.assume_init() };
    let fused = outcome.fused != selfcal_fused_t::SELFCAL_FUSED_NOT;
    assert_eq!(fused, code == SELFCAL_OK);
    (true, if fused { Ok(outcome) } else { Err(code) })
}

/// Begins a pair.
pub(crate) fn begin(cal: &mut Cal) {
    assert!(!advance(cal).0);
}

/// Takes all steps of a pair.
pub(crate) fn finish(cal: &mut Cal) -> Result<selfcal_outcome_t, selfcal_error_t> {
    loop {
        if let (true, outcome) = advance(cal) {
            return outcome;
        }
    }
}

/// One recorded pair, in the types of C and of Rust.
pub(crate) fn pair(
    set: &Dataset,
    index: usize,
) -> (Vec<selfcal_correspondence_t>, Vec<Correspondence<f32>>) {
    let rust = set.pairs[index].iter().map(rigs::data::Match::correspondence::<f32>);
    let c = rust.clone().map(|m| selfcal_correspondence_t {
        left_px: m.left,
        right_px: m.right,
        score: m.score,
        grid_step_px: m.grid_step,
    });
    (c.collect(), rust.collect())
}

/// A locked calibrator after five pairs; the last pair is still in the batch.
pub(crate) fn at_work() -> Cal {
    let set = recorded();
    let mut cal = Cal::of(&set, None);
    for index in 0..5 {
        let (all, _) = pair(&set, index);
        get!(cal, selfcal_take_pair, all.as_ptr(), all.len()).unwrap();
    }
    assert_eq!(get!(cal, selfcal_state), Ok(selfcal_state_t::SELFCAL_STATE_LOCKED));
    cal
}
