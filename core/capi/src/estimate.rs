//! State and proposal: the estimate over all pairs.

use stereo_selfcal::outcome::{Direction, Finding, LensEstimate, StandardDeviations, Vibration};
use stereo_selfcal::{Proposal, State};

use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::extrinsics::selfcal_extrinsics_t;
use crate::instance::{selfcal_t, shared};
use crate::lens::selfcal_lens_correction_t;
use crate::pointer::Out;
use crate::verdict::bits;

c_enum! {
    /// Reliability of the estimate.
    #[repr(u32)]
    pub enum selfcal_state_t {
        /// acquiring
        ///
        /// Too few pairs agree yet.
        SELFCAL_STATE_ACQUIRING = 13000,
        /// locked
        ///
        /// The last pair agrees with the estimate, and `R` is certain. `t` may still be the start value; see
        /// `baseline_observed`.
        SELFCAL_STATE_LOCKED = 13001,
        /// suspect
        ///
        /// The last pair that was compared with the estimate disagrees, a challenger gathers pairs, or no pair has
        /// supported a restored estimate yet.
        SELFCAL_STATE_SUSPECT = 13002,
        /// lost
        ///
        /// At least ten pairs in a row disagree with the estimate, and no three of them agree well enough with each
        /// other.
        SELFCAL_STATE_LOST = 13003,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_STATE_UNKNOWN = 13255,
    }
}

from_core!(State => selfcal_state_t from 13000, else SELFCAL_STATE_UNKNOWN);

c_enum! {
    /// One of the five unknowns, in the rectified frame (x along the baseline, z forward).
    #[repr(u32)]
    pub enum selfcal_direction_t {
        /// pitch
        ///
        /// Rotation of `R` about x: shifts all rows alike.
        SELFCAL_DIRECTION_PITCH = 15001,
        /// yaw
        ///
        /// Rotation of `R` about y: moves rows by the product of column and row.
        SELFCAL_DIRECTION_YAW = 15002,
        /// roll
        ///
        /// Rotation of `R` about z: tilts rows.
        SELFCAL_DIRECTION_ROLL = 15003,
        /// baseline forward
        ///
        /// Rotation of the baseline about y: `t_z`.
        SELFCAL_DIRECTION_BASELINE_FORWARD = 15004,
        /// baseline down
        ///
        /// Rotation of the baseline about z: `t_y`.
        SELFCAL_DIRECTION_BASELINE_DOWN = 15005,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_DIRECTION_UNKNOWN = 15255,
    }
}

from_core!(Direction => selfcal_direction_t from 15000, else SELFCAL_DIRECTION_UNKNOWN);

/// Reported standard deviations of an estimate: the expected sizes of its errors.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_sd_t {
    /// Deviation of `R`, rad: root of the sum of the variances about the three axes.
    pub rotation_rad: f32,
    /// Deviation of the direction of `t`, rad: root of the sum of the variances of its two angles.
    pub translation_rad: f32,
}

impl From<StandardDeviations<f32>> for selfcal_sd_t {
    fn from(sd: StandardDeviations<f32>) -> Self {
        Self { rotation_rad: sd.rotation, translation_rad: sd.translation }
    }
}

/// Motion of the rig from one pair to the next about a constant mean, which is the estimate; 0 if the pairs show no
/// vibration. The extrinsics of a single pair differ from the estimate by this much. No calibration can follow a
/// vibration.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct selfcal_vibration_t {
    /// Vibration of `R` about each axis, rad RMS.
    pub rotation_rad: f32,
    /// Vibration of the direction of `t` about each of its two angles, rad RMS.
    pub translation_rad: f32,
}

impl From<Vibration<f32>> for selfcal_vibration_t {
    fn from(vibration: Vibration<f32>) -> Self {
        Self { rotation_rad: vibration.rotation, translation_rad: vibration.baseline }
    }
}

/// Error of a lens parameter, with its standard deviation.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct selfcal_finding_t {
    /// Estimated error: the true value minus the given value.
    pub value: f32,
    /// Standard deviation; at first the standard deviation of the prior.
    pub sd: f32,
}

impl From<Finding<f32>> for selfcal_finding_t {
    fn from(found: Finding<f32>) -> Self {
        Self { value: found.value, sd: found.sd }
    }
}

/// Errors of the given lens models that pairs show: right camera minus left camera, except for the mean. Only
/// `SELFCAL_LENS_TRACKING_COMPENSATE` corrects the extrinsics for them, namely for the differences of focal length and
/// `k1`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct selfcal_lens_estimate_t {
    /// Relative focal length: 0.001 if the right one is 0.1 % longer than given.
    pub focal: selfcal_finding_t,
    /// Radial coefficient `k1`.
    pub k1: selfcal_finding_t,
    /// Radial coefficient `k1`, mean of both cameras. Half of a `k1` that is compensated is not included.
    pub k1_mean: selfcal_finding_t,
    /// Tangential coefficient `p1`.
    pub p1: selfcal_finding_t,
    /// Column of the principal point, px.
    pub principal_x_px: selfcal_finding_t,
}

impl From<LensEstimate<f32>> for selfcal_lens_estimate_t {
    fn from(lens: LensEstimate<f32>) -> Self {
        Self {
            focal: lens.focal.into(),
            k1: lens.k1.into(),
            k1_mean: lens.k1_mean.into(),
            p1: lens.p1.into(),
            principal_x_px: lens.principal_x_px.into(),
        }
    }
}

/// The least certain direction of an estimate.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_weakest_t {
    /// The direction.
    pub direction: selfcal_direction_t,
    /// Its standard deviation, rad.
    pub sd_rad: f32,
}

impl From<(Direction, f32)> for selfcal_weakest_t {
    fn from((direction, sd_rad): (Direction, f32)) -> Self {
        Self { direction: direction.into(), sd_rad }
    }
}

/// The estimate over all pairs so far.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_proposal_t {
    /// The best `R`, `t`.
    pub extrinsics: selfcal_extrinsics_t,
    /// Correction of the cameras that the extrinsics belong to; 0 without `SELFCAL_LENS_TRACKING_COMPENSATE`.
    pub correction: selfcal_lens_correction_t,
    /// Extrinsics that `selfcal_apply` puts into use: the best `R`, `t`, or the `t` in use with the best `R` for it.
    /// The `t` in use is kept in three cases: the baseline is not observed; it is observed, but still uncertain, and
    /// the `t` in use does not differ from it significantly; or image halves disagree with exact lens models. In the
    /// first two cases the best `R`, `t` are applied nevertheless if pairs determine the baseline with the lens models
    /// as given, and their row offsets are clearly smaller. If no `R` fits the `t` in use, this is the calibration in
    /// use.
    pub applicable: selfcal_extrinsics_t,
    /// Correction of the cameras that `applicable` belongs to.
    pub applicable_correction: selfcal_lens_correction_t,
    /// Number of pairs in the estimate; pairs of a repeated scene count once.
    pub pairs: u32,
    /// Reported standard deviations, with the lens models as given.
    pub sd: selfcal_sd_t,
    /// Reported standard deviations with the lens models uncertain by `lens_prior` of `selfcal_config_t`.
    pub sd_lens: selfcal_sd_t,
    /// Whether `lens` is valid; false without a lens prior.
    pub has_lens: bool,
    /// Errors of the lens models; 0 if they are not valid.
    pub lens: selfcal_lens_estimate_t,
    /// Covariance, rad^2, symmetric. Order: rotation of `R` about x, y, z,
    /// rotation of the baseline about y, z, in the rectified frame.
    pub covariance: [[f32; 5]; 5],
    /// Apparent yaw `a` of the lenses, rad: the right row is below the left one by `a x y`, at unit depth.
    pub lens_yaw: selfcal_finding_t,
    /// The least certain direction, with the lens models uncertain as in `sd_lens`.
    pub weakest: selfcal_weakest_t,
    /// Motion of the rig about the estimate.
    pub vibration: selfcal_vibration_t,
    /// State of the estimate.
    pub state: selfcal_state_t,
    /// Reasons not to rely on the estimate: sum of `selfcal_reason_t`.
    pub reasons: u32,
    /// Whether pairs have determined the baseline direction. Points more than some thousand baselines away do not
    /// determine it.
    pub baseline_observed: bool,
}

impl From<&Proposal<f32>> for selfcal_proposal_t {
    fn from(proposal: &Proposal<f32>) -> Self {
        Self {
            extrinsics: (&proposal.extrinsics).into(),
            correction: proposal.correction.into(),
            applicable: (&proposal.applicable).into(),
            applicable_correction: proposal.applicable_correction.into(),
            pairs: proposal.pairs,
            sd: proposal.sd.into(),
            sd_lens: proposal.sd_lens.into(),
            has_lens: proposal.lens.is_some(),
            lens: proposal.lens.map(Into::into).unwrap_or_default(),
            // nalgebra stores columns.
            covariance: proposal.covariance.transpose().into(),
            lens_yaw: proposal.lens_yaw.into(),
            weakest: proposal.weakest().into(),
            vibration: proposal.vibration.into(),
            state: proposal.state.into(),
            reasons: bits(proposal.reasons()),
            baseline_observed: proposal.baseline_observed,
        }
    }
}

/// Reads the state of the estimate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_state(
    cal: *const selfcal_t,
    state: *mut selfcal_state_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, state) = unsafe { (shared(cal)?, Out::checked(state)?) };
        state.set(instance.calibrator.state().into());
        Ok(())
    })
}

/// Reads the estimate over all fused pairs. Without an estimate it returns `SELFCAL_ERROR_NO_ESTIMATE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_proposal(
    cal: *const selfcal_t,
    proposal: *mut selfcal_proposal_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::checked(proposal)?) };
        let proposal = instance.calibrator.proposal().ok_or(SELFCAL_ERROR_NO_ESTIMATE)?;
        out.set((&proposal).into());
        Ok(())
    })
}
