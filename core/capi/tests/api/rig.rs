//! A calibrator behind its pointer, recorded pairs, and its observable state.

use std::mem::MaybeUninit;
use std::ptr;

use host_tests::data::Dataset;
use stereo_selfcal::{Cameras, Correspondence};
use stereo_selfcal_capi::selfcal_error_t::SELFCAL_OK;
use stereo_selfcal_capi::*;

/// Storage on the heap, zeroed as static storage of C.
pub(crate) struct Cal(Box<MaybeUninit<selfcal_t>>);

impl Cal {
    /// Not initialised.
    pub(crate) fn zeroed() -> Self {
        Self(Box::new(MaybeUninit::zeroed()))
    }

    /// Initialised, without cameras.
    pub(crate) fn new(config: Option<&selfcal_config_t>) -> Self {
        let mut cal = Self::zeroed();
        let config = config.map_or(ptr::null(), ptr::from_ref);
        // SAFETY: live storage of that size.
        assert_eq!(unsafe { selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, config) }, SELFCAL_OK);
        cal
    }

    /// Initialised, with the cameras of a data set.
    pub(crate) fn of(set: &Dataset, config: Option<&selfcal_config_t>) -> Self {
        let mut cal = Self::new(config);
        let [left, right] = cameras(set);
        // SAFETY: live objects.
        assert_eq!(unsafe { selfcal_set_cameras(cal.ptr(), &left, &right) }, SELFCAL_OK);
        cal
    }

    pub(crate) fn ptr(&mut self) -> *mut selfcal_t {
        self.0.as_mut_ptr()
    }
}

/// Calls a function with one result: the result, or the error.
macro_rules! get {
    ($cal:expr, $function:ident $(, $argument:expr)*) => {{
        let mut out = std::mem::MaybeUninit::zeroed();
        // SAFETY: live objects; zeros are a value of every result.
        match unsafe { $function($cal.ptr() $(, $argument)*, out.as_mut_ptr()) } {
            // SAFETY: as above.
            SELFCAL_OK => Ok(unsafe { out.assume_init() }),
            error => Err(error),
        }
    }};
}
pub(crate) use get;

/// Observable state, which a refused call must not change.
#[derive(Debug, PartialEq)]
pub(crate) struct Observed {
    in_use: Result<selfcal_extrinsics_t, selfcal_error_t>,
    calibration: Result<selfcal_calibration_t, selfcal_error_t>,
    generation: Result<u32, selfcal_error_t>,
    batch: Result<selfcal_batch_t, selfcal_error_t>,
    state: Result<selfcal_state_t, selfcal_error_t>,
    report: Result<selfcal_report_t, selfcal_error_t>,
    proposal: Result<selfcal_proposal_t, selfcal_error_t>,
    health: Result<selfcal_health_t, selfcal_error_t>,
    cameras: Result<selfcal_camera_t, selfcal_error_t>,
}

impl Observed {
    pub(crate) fn of(cal: &mut Cal) -> Self {
        let mut left = MaybeUninit::zeroed();
        Self {
            in_use: get!(cal, selfcal_in_use),
            calibration: get!(cal, selfcal_calibration_in_use),
            generation: get!(cal, selfcal_generation),
            batch: get!(cal, selfcal_batch),
            state: get!(cal, selfcal_state),
            report: get!(cal, selfcal_report),
            proposal: get!(cal, selfcal_proposal),
            health: get!(cal, selfcal_health),
            cameras: get!(cal, selfcal_cameras, left.as_mut_ptr()),
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

/// One recorded pair, in the types of C and of Rust.
pub(crate) fn pair(
    set: &Dataset,
    index: usize,
) -> (Vec<selfcal_correspondence_t>, Vec<Correspondence<f32>>) {
    let rust = set.pairs[index].iter().map(host_tests::data::Match::correspondence::<f32>);
    let c = rust.clone().map(|m| selfcal_correspondence_t {
        left_px: m.left,
        right_px: m.right,
        score: m.score,
        grid_step_px: m.grid_step,
    });
    (c.collect(), rust.collect())
}

/// The configuration of a preset.
pub(crate) fn config(
    preset: unsafe extern "C" fn(*mut selfcal_config_t) -> selfcal_error_t,
) -> selfcal_config_t {
    let mut config = MaybeUninit::uninit();
    // SAFETY: a live place that the preset fills.
    unsafe {
        assert_eq!(preset(config.as_mut_ptr()), SELFCAL_OK);
        config.assume_init()
    }
}

/// A locked calibrator with a batch and a report.
pub(crate) fn at_work() -> Cal {
    let set = recorded();
    let mut cal = Cal::of(&set, None);
    for index in 0..5 {
        // SAFETY: live storage.
        assert_eq!(unsafe { selfcal_clear_pair(cal.ptr()) }, SELFCAL_OK);
        let (all, _) = pair(&set, index);
        get!(cal, selfcal_push_array, all.as_ptr(), all.len()).unwrap();
        // SAFETY: live storage.
        assert_eq!(unsafe { selfcal_solve_pair(cal.ptr()) }, SELFCAL_OK);
        get!(cal, selfcal_fuse).unwrap();
    }
    assert_eq!(get!(cal, selfcal_state), Ok(selfcal_state_t::SELFCAL_STATE_LOCKED));
    cal
}
