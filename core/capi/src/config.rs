//! The configuration: plain fields. 0 in a field stands for its default.

use core::ffi::CStr;

use stereo_selfcal::{Config, ConfigError, LensTracking};
use zerocopy::FromBytes;

use crate::error::selfcal_error_t::{self, *};
use crate::lens::selfcal_lens_prior_t;

/// Treatment of errors of the given lens models.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_lens_tracking_t {
    /// Errors are estimated and reported, and they increase the reported deviations that include the lens. The
    /// extrinsics belong to the given lens models.
    SELFCAL_LENS_TRACKING_REPORT = 0,
    /// Differences of focal length and of `k1` are compensated, if that halves the standard deviation of `t`; see
    /// `SELFCAL_FUSED_LENS_CORRECTED`. This is for callers that rectify with the cameras of the calibration in use, as
    /// the functions of this API do.
    SELFCAL_LENS_TRACKING_COMPENSATE = 1,
}

/// Parameters of a calibrator. 0 in a field stands for its default: `selfcal_config_t config = {0}` is the default
/// configuration, and `{.memory_pairs = 300}` changes one parameter. `selfcal_init` checks all fields.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_config_t {
    /// Largest number of passes over the batch that a pair may take, which bounds its time: 2 or more; default 24. A
    /// pair takes up to 9 passes even if the limit is lower. With a limit below 20 it does not test before the first lock
    /// whether a turned baseline fits better.
    pub max_passes: u16,
    /// Least number of usable correspondences that a pair needs: 6 or more; default 12.
    pub min_correspondences: u16,
    /// Number `n` of fused pairs after which each further pair multiplies the weight of the older pairs by `1 - 1 / n`:
    /// 20 or more; default 1000. A larger number averages longer; a smaller one follows a slow drift.
    pub memory_pairs: u32,
    /// Correction limit, rad: above 0 and below 1.5; default 0.5. A pair is not fused if `R` or `t` of the estimate
    /// with the pair differs from the factory value by a larger angle.
    pub max_correction_rad: f32,
    /// Standard deviation of the factory extrinsics about each axis, rad: 1e-4 to 1; default 0.1. A larger value
    /// follows a rig that is further off; a smaller one stabilises pairs with little information.
    pub prior_sd_rad: f32,
    /// Lower bound of the estimated noise of a coordinate, px: 0.001 to 100; default 0.15. The bound keeps the
    /// information finite on data without noise.
    pub noise_floor_px: f32,
    /// Limit of row offsets, px: finite and above 0; default 3. A match fits a calibration if its row offset is within
    /// the limit, or within 4.2 times the noise of a coordinate if that is more.
    pub fit_limit_px: f32,
    /// Largest row offset in use at which a rig may arm, px: above 0, or infinite; default 1.
    pub rows_limit_px: f32,
    /// Largest expected error of disparity at which a rig may arm, px: above 0, or infinite for a rig that uses no metric
    /// depth, such as one that started from a guess; default 2.
    pub depth_limit_px: f32,
    /// Least share of the matches that fit the pair's own pose that must fit the calibration in use: up to 1; default
    /// 0.7.
    pub coverage_limit: f32,
    /// A `selfcal_lens_tracking_t`, which acts only with a lens prior.
    pub lens_tracking: u32,
    /// 1 if `lens_prior` replaces the default deviations of the lens models, otherwise 0.
    pub has_lens_prior: u32,
    /// Standard deviations of the given lens models, which `sd_lens` of the proposal covers. All 0 take the lens models
    /// as exact; disagreeing image halves then forbid to apply the estimate (`SELFCAL_REASON_BIASED`).
    pub lens_prior: selfcal_lens_prior_t,
}

/// Why a configuration is refused.
pub(crate) enum ConfigFault {
    /// A parameter is out of its range.
    Parameter(ConfigError),
    /// A field has no value of its enumeration.
    Enumeration(&'static CStr),
}

impl From<ConfigError> for ConfigFault {
    fn from(error: ConfigError) -> Self {
        Self::Parameter(error)
    }
}

impl From<ConfigFault> for selfcal_error_t {
    fn from(_: ConfigFault) -> Self {
        SELFCAL_ERROR_CONFIG
    }
}

impl ConfigFault {
    pub(crate) fn text(&self) -> &'static CStr {
        match self {
            Self::Enumeration(text) => text,
            Self::Parameter(error) => match error {
                ConfigError::FitLimit => c"fit_limit_px is not finite or not above 0",
                ConfigError::MaxPasses => c"max_passes is below 2",
                ConfigError::MinCorrespondences => c"min_correspondences is below 6",
                ConfigError::NoiseFloor => c"noise_floor_px is outside 0.001 to 100",
                ConfigError::PriorStandardDeviation => c"prior_sd_rad is not within 1e-4 to 1",
                ConfigError::Memory => c"memory_pairs is below 20",
                ConfigError::MaxCorrection => c"max_correction_rad is not above 0 and below 1.5",
                ConfigError::LensPrior => {
                    c"a deviation of lens_prior is not within 0 to 0.1, of the principal point 0 to 100 px"
                }
                ConfigError::LensYaw => c"yaw_rad of lens_prior is not within 0 to 0.1",
                ConfigError::FactoryYaw => c"yaw_sd_rad is not within 1e-6 to 1",
                ConfigError::RowsLimit => c"rows_limit_px is not above 0",
                ConfigError::DepthLimit => c"depth_limit_px is not above 0",
                ConfigError::CoverageLimit => c"coverage_limit is not within 0 to 1",
                ConfigError::BaselineLength => c"baseline_m is not within 1e-3 to 1e3",
                _ => c"unknown",
            },
        }
    }
}

impl selfcal_config_t {
    /// Returns the configuration of the core, or the fault. It checks all fields, because the caller may have written
    /// any bits.
    pub(crate) fn core(&self) -> Result<Config, ConfigFault> {
        const COMPENSATE: u32 = selfcal_lens_tracking_t::SELFCAL_LENS_TRACKING_COMPENSATE as u32;
        let config = Config::robust();
        let config = match self.lens_tracking {
            0 => config,
            COMPENSATE => config.with_lens_tracking(LensTracking::Compensate),
            _ => {
                let text = c"lens_tracking is no value of selfcal_lens_tracking_t";
                return Err(ConfigFault::Enumeration(text));
            }
        };
        let config = given(config, self.max_passes, Config::with_max_passes)?;
        let config = given(config, self.min_correspondences, Config::with_min_correspondences)?;
        let config = given(config, self.memory_pairs, Config::with_memory_pairs)?;
        let config = given(config, self.max_correction_rad, Config::with_max_correction_rad)?;
        let config = given(config, self.prior_sd_rad, Config::with_prior_sd_rad)?;
        let config = given(config, self.noise_floor_px, Config::with_noise_floor_px)?;
        let config = given(config, self.fit_limit_px, Config::with_fit_limit_px)?;
        let config = given(config, self.rows_limit_px, Config::with_rows_limit_px)?;
        let config = given(config, self.depth_limit_px, Config::with_depth_limit_px)?;
        let config = given(config, self.coverage_limit, Config::with_coverage_limit)?;
        match self.has_lens_prior {
            0 => Ok(config),
            1 => {
                let config = config.with_lens_prior(self.lens_prior.into())?;
                Ok(config.with_lens_yaw_sd_rad(self.lens_prior.yaw_rad)?)
            }
            _ => Err(ConfigFault::Enumeration(c"has_lens_prior is neither 0 nor 1")),
        }
    }
}

/// Returns the configuration with a parameter set, unless the parameter is 0.
pub(crate) fn given<C, N: Default + PartialEq>(
    config: C,
    value: N,
    with: impl FnOnce(C, N) -> Result<C, ConfigError>,
) -> Result<C, ConfigError> {
    if value == N::default() { Ok(config) } else { with(config, value) }
}
