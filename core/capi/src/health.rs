//! Health: what a rig's user asks of it before it moves.

use core::ffi::c_char;

use stereo_selfcal::{Arming, Band, Health};

use crate::code::code;
use crate::code::selfcal_error_t::{self, *};
use crate::estimate::{selfcal_doubt_t, selfcal_sd_t, selfcal_state_t, selfcal_weakest_t};
use crate::instance::{Instance, shared};
use crate::pointer::Out;
use crate::storage::selfcal_t;
use crate::text::{Text, find};

/// What to make of the extrinsics in use, by the RMS row offset.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_band_t {
    /// Below 1 px, and the estimate would not improve it by a tenth.
    SELFCAL_BAND_GOOD = 0,
    /// Below 1 px, but the estimate fits better by a tenth or more.
    SELFCAL_BAND_IMPROVABLE = 1,
    /// 1 px or more: a matcher that searches along rows will miss.
    SELFCAL_BAND_RECALIBRATE = 2,
}

use selfcal_band_t::*;

const BANDS: &[Text<u32>] = &[
    (SELFCAL_BAND_GOOD as u32, c"good"),
    (SELFCAL_BAND_IMPROVABLE as u32, c"improvable"),
    (SELFCAL_BAND_RECALIBRATE as u32, c"recalibrate"),
];

impl From<Band> for selfcal_band_t {
    fn from(band: Band) -> Self {
        match band {
            Band::Good => SELFCAL_BAND_GOOD,
            Band::Improvable => SELFCAL_BAND_IMPROVABLE,
            Band::Recalibrate => SELFCAL_BAND_RECALIBRATE,
        }
    }
}

/// Yes or no to an arming check, and the reason.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_arming_t {
    /// The extrinsics in use fit a confirmed estimate.
    SELFCAL_ARMING_YES = 0,
    /// The estimate is not confirmed, or the last pairs disagree with it.
    SELFCAL_ARMING_NOT_LOCKED = 1,
    /// Image halves disagree too much to trust any estimate.
    SELFCAL_ARMING_DOUBTFUL = 2,
    /// The extrinsics in use do not fit the matches.
    SELFCAL_ARMING_MISALIGNED = 3,
}

use selfcal_arming_t::*;

const ARMINGS: &[Text<u32>] = &[
    (SELFCAL_ARMING_YES as u32, c"yes"),
    (SELFCAL_ARMING_NOT_LOCKED as u32, c"no: not locked"),
    (SELFCAL_ARMING_DOUBTFUL as u32, c"no: doubtful"),
    (SELFCAL_ARMING_MISALIGNED as u32, c"no: misaligned"),
];

impl From<Arming> for selfcal_arming_t {
    fn from(arming: Arming) -> Self {
        match arming {
            Arming::Yes => SELFCAL_ARMING_YES,
            Arming::NotLocked => SELFCAL_ARMING_NOT_LOCKED,
            Arming::Doubtful => SELFCAL_ARMING_DOUBTFUL,
            Arming::Misaligned => SELFCAL_ARMING_MISALIGNED,
        }
    }
}

/// How what is in use and the estimate fit the batch at hand. The two RMS are over the same matches:
/// those that fit the estimate.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_health_t {
    /// RMS row offset of the extrinsics in use, px; 0 is perfect.
    pub in_use_px: f32,
    /// RMS row offset of the proposed extrinsics, px.
    pub proposed_px: f32,
    /// Matches that fit the extrinsics in use.
    pub fit_in_use: u32,
    /// Matches that fit the proposed extrinsics.
    pub fit_proposed: u32,
    /// Share of the cells of an 8 x 6 grid over the left image with a match that fits, 0 to 1.
    pub coverage: f32,
    /// What to make of the two RMS.
    pub band: selfcal_band_t,
    /// Whether the estimate is confirmed.
    pub state: selfcal_state_t,
    /// What speaks against it.
    pub doubt: selfcal_doubt_t,
    /// Expected size of the error of the estimate.
    pub sd: selfcal_sd_t,
    /// Its least certain direction.
    pub weakest: selfcal_weakest_t,
    /// Expected error of the yaw in use, rad.
    pub yaw_rad: f32,
    /// Why the last pair was not taken in; `SELFCAL_OK` if it was.
    pub rejection: selfcal_error_t,
    /// Yes or no to an arming check.
    pub arming: selfcal_arming_t,
}

impl From<&Health<f32>> for selfcal_health_t {
    fn from(health: &Health<f32>) -> Self {
        Self {
            in_use_px: health.in_use_px,
            proposed_px: health.proposed_px,
            fit_in_use: health.fit_in_use,
            fit_proposed: health.fit_proposed,
            coverage: health.coverage,
            band: health.band.into(),
            state: health.state.into(),
            doubt: health.doubt.into(),
            sd: health.sd.into(),
            weakest: health.weakest.into(),
            yaw_rad: health.yaw,
            rejection: health.rejection.map_or(SELFCAL_OK, Into::into),
            arming: health.arming.into(),
        }
    }
}

fn core(instance: &Instance) -> Result<Health<f32>, selfcal_error_t> {
    instance.calibrator.health().ok_or(SELFCAL_ERROR_NO_HEALTH)
}

/// How what is in use and the estimate fit the batch at hand: ask before the batch is cleared. One
/// pass over it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_health(
    cal: *const selfcal_t,
    health: *mut selfcal_health_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, health) = unsafe { (shared(cal)?, Out::checked(health)?) };
        health.set((&core(instance)?).into());
        Ok(())
    })
}

/// Expected error of depth with the extrinsics in use, at 1, 2, 5 and 10 m in the middle of the
/// image. One pass over the batch. A matcher's own noise is not in it.
///
/// * `baseline_m`: length of the baseline, m; finite and above 0.
/// * `errors`: m.
///
/// cbindgen:ptrs-as-arrays=[[errors; 4]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_depth_errors(
    cal: *const selfcal_t,
    baseline_m: f32,
    errors: *mut f32,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::<[f32; 4]>::checked(errors.cast())?) };
        if !(baseline_m > 0.0 && baseline_m.is_finite()) {
            return Err(SELFCAL_ERROR_BASELINE);
        }
        let found = core(instance)?.depth_errors(baseline_m);
        out.set(found.ok_or(SELFCAL_ERROR_NO_DEPTH_ERROR)?);
        Ok(())
    })
}

/// A `selfcal_band_t` in words, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_band_string(band: u32) -> *const c_char {
    find(BANDS, band)
}

/// A `selfcal_arming_t` in words, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_arming_string(arming: u32) -> *const c_char {
    find(ARMINGS, arming)
}
