//! State and proposal: what the pairs come to.

use core::ffi::c_char;

use stereo_selfcal::{Direction, Doubt, Proposal, StandardDeviations, State};

use crate::code::code;
use crate::code::selfcal_error_t::{self, *};
use crate::extrinsics::selfcal_extrinsics_t;
use crate::instance::shared;
use crate::pointer::Out;
use crate::storage::selfcal_t;
use crate::text::{Text, find};

/// How far the estimate can be relied on.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_state_t {
    /// Not enough pairs agree yet.
    SELFCAL_STATE_ACQUIRING = 0,
    /// The last pair agrees with the estimate.
    SELFCAL_STATE_LOCKED = 1,
    /// The last pairs disagree with the estimate, or some did and speak for another.
    SELFCAL_STATE_SUSPECT = 2,
    /// Ten pairs in a row disagree with the estimate, and no three with each other.
    SELFCAL_STATE_LOST = 3,
    /// The core gave a state that this API does not know yet.
    SELFCAL_STATE_UNKNOWN = 255,
}

use selfcal_state_t::*;

const STATES: &[Text<u32>] = &[
    (SELFCAL_STATE_ACQUIRING as u32, c"acquiring"),
    (SELFCAL_STATE_LOCKED as u32, c"locked"),
    (SELFCAL_STATE_SUSPECT as u32, c"suspect"),
    (SELFCAL_STATE_LOST as u32, c"lost"),
];

impl From<State> for selfcal_state_t {
    fn from(state: State) -> Self {
        match state {
            State::Acquiring => SELFCAL_STATE_ACQUIRING,
            State::Locked => SELFCAL_STATE_LOCKED,
            State::Suspect => SELFCAL_STATE_SUSPECT,
            State::Lost => SELFCAL_STATE_LOST,
            _ => SELFCAL_STATE_UNKNOWN,
        }
    }
}

/// What speaks against an estimate.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_doubt_t {
    /// Nothing.
    SELFCAL_DOUBT_NONE = 0,
    /// Image halves disagree by more than 3 standard deviations: `t` is not applied.
    SELFCAL_DOUBT_BASELINE = 1,
    /// They disagree by more than 5: nothing is applied.
    SELFCAL_DOUBT_EVERYTHING = 2,
    /// Paper preset: the rotation is so near the identity, or a half turn, that its axis is noise.
    SELFCAL_DOUBT_AXIS = 3,
    /// The core gave a doubt that this API does not know yet.
    SELFCAL_DOUBT_UNKNOWN = 255,
}

use selfcal_doubt_t::*;

const DOUBTS: &[Text<u32>] = &[
    (SELFCAL_DOUBT_NONE as u32, c"none"),
    (SELFCAL_DOUBT_BASELINE as u32, c"image halves disagree: t held"),
    (SELFCAL_DOUBT_EVERYTHING as u32, c"image halves disagree: not applied"),
    (SELFCAL_DOUBT_AXIS as u32, c"axis uncertain"),
];

impl From<Option<Doubt>> for selfcal_doubt_t {
    fn from(doubt: Option<Doubt>) -> Self {
        match doubt {
            None => SELFCAL_DOUBT_NONE,
            Some(Doubt::Baseline) => SELFCAL_DOUBT_BASELINE,
            Some(Doubt::Everything) => SELFCAL_DOUBT_EVERYTHING,
            Some(Doubt::Axis) => SELFCAL_DOUBT_AXIS,
            Some(_) => SELFCAL_DOUBT_UNKNOWN,
        }
    }
}

/// One of the five unknowns, in the rectified frame (x along the baseline, z forward).
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_direction_t {
    /// None: the paper preset does not tell.
    SELFCAL_DIRECTION_NONE = 0,
    /// Turn of `R` about x: shifts all rows alike.
    SELFCAL_DIRECTION_PITCH = 1,
    /// Turn of `R` about y: shears rows with the product of column and row.
    SELFCAL_DIRECTION_YAW = 2,
    /// Turn of `R` about z: tilts rows.
    SELFCAL_DIRECTION_ROLL = 3,
    /// Turn of the baseline about y: `t_z`.
    SELFCAL_DIRECTION_BASELINE_FORWARD = 4,
    /// Turn of the baseline about z: `t_y`.
    SELFCAL_DIRECTION_BASELINE_DOWN = 5,
}

use selfcal_direction_t::*;

const DIRECTIONS: &[Text<u32>] = &[
    (SELFCAL_DIRECTION_NONE as u32, c"none"),
    (SELFCAL_DIRECTION_PITCH as u32, c"pitch"),
    (SELFCAL_DIRECTION_YAW as u32, c"yaw"),
    (SELFCAL_DIRECTION_ROLL as u32, c"roll"),
    (SELFCAL_DIRECTION_BASELINE_FORWARD as u32, c"baseline forward"),
    (SELFCAL_DIRECTION_BASELINE_DOWN as u32, c"baseline down"),
];

impl From<Direction> for selfcal_direction_t {
    fn from(direction: Direction) -> Self {
        match direction {
            Direction::Pitch => SELFCAL_DIRECTION_PITCH,
            Direction::Yaw => SELFCAL_DIRECTION_YAW,
            Direction::Roll => SELFCAL_DIRECTION_ROLL,
            Direction::BaselineForward => SELFCAL_DIRECTION_BASELINE_FORWARD,
            Direction::BaselineDown => SELFCAL_DIRECTION_BASELINE_DOWN,
        }
    }
}

/// Expected size of the error of an estimate.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_sd_t {
    /// Of `R`, rad.
    pub rotation_rad: f32,
    /// Of the direction of `t`, rad.
    pub translation_rad: f32,
}

impl From<StandardDeviations<f32>> for selfcal_sd_t {
    fn from(sd: StandardDeviations<f32>) -> Self {
        Self { rotation_rad: sd.rotation, translation_rad: sd.translation }
    }
}

/// The least certain direction of an estimate.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_weakest_t {
    /// Which; `SELFCAL_DIRECTION_NONE` in the paper preset.
    pub direction: selfcal_direction_t,
    /// Its standard deviation, rad; 0 in the paper preset.
    pub sd_rad: f32,
}

impl From<Option<(Direction, f32)>> for selfcal_weakest_t {
    fn from(weakest: Option<(Direction, f32)>) -> Self {
        match weakest {
            Some((direction, sd_rad)) => Self { direction: direction.into(), sd_rad },
            None => Self { direction: SELFCAL_DIRECTION_NONE, sd_rad: 0.0 },
        }
    }
}

/// The estimate over all pairs so far.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_proposal_t {
    /// The best `R`, `t`.
    pub extrinsics: selfcal_extrinsics_t,
    /// What `selfcal_apply` puts into use: the same, but where the baseline is doubted `t` is that in
    /// use, and `R` the best there is with it.
    pub applicable: selfcal_extrinsics_t,
    /// Pairs behind it; those of a repeated scene count once.
    pub pairs: u32,
    /// Expected size of the error.
    pub sd: selfcal_sd_t,
    /// Whether there is a covariance: not in the paper preset.
    pub has_covariance: bool,
    /// Covariance, rad^2, symmetric; 0 without. Order: turn of `R` about x, y, z, turn of the baseline
    /// about y, z, in the rectified frame.
    pub covariance: [[f32; 5]; 5],
    /// The least certain direction.
    pub weakest: selfcal_weakest_t,
    /// Whether it is confirmed. The paper preset confirms nothing: locked from the first pair on.
    pub state: selfcal_state_t,
    /// What speaks against it.
    pub doubt: selfcal_doubt_t,
}

impl From<&Proposal<f32>> for selfcal_proposal_t {
    fn from(proposal: &Proposal<f32>) -> Self {
        Self {
            extrinsics: (&proposal.extrinsics).into(),
            applicable: (&proposal.applicable).into(),
            pairs: proposal.pairs,
            sd: proposal.sd.into(),
            has_covariance: proposal.covariance.is_some(),
            // Arrays of columns, otherwise.
            covariance: proposal.covariance.unwrap_or_default().transpose().into(),
            weakest: proposal.weakest().into(),
            state: proposal.state.into(),
            doubt: proposal.doubt.into(),
        }
    }
}

/// How far the estimate can be relied on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_state(
    cal: *const selfcal_t,
    state: *mut selfcal_state_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, state) = unsafe { (shared(cal)?, Out::checked(state)?) };
        state.set(instance.calibrator.state().into());
        Ok(())
    })
}

/// The estimate over all fused pairs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_proposal(
    cal: *const selfcal_t,
    proposal: *mut selfcal_proposal_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::checked(proposal)?) };
        let proposal = instance.calibrator.proposal().ok_or(SELFCAL_ERROR_NO_ESTIMATE)?;
        out.set((&proposal).into());
        Ok(())
    })
}

/// A `selfcal_state_t` in words, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_state_string(state: u32) -> *const c_char {
    find(STATES, state)
}

/// A `selfcal_doubt_t` in words, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_doubt_string(doubt: u32) -> *const c_char {
    find(DOUBTS, doubt)
}

/// A `selfcal_direction_t` in words, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_direction_string(direction: u32) -> *const c_char {
    find(DIRECTIONS, direction)
}
