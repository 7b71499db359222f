//! Parameters of the calibrator, and the effects of larger and smaller values.

mod context;
mod lens_tracking;

pub(crate) use context::Context;
pub use lens_tracking::LensTracking;

use crate::algebra::lens_prior::LensPrior;
use crate::error::ConfigError;
use crate::scalar::Scalar;

impl Default for Config {
    /// Returns [`Config::robust`].
    fn default() -> Self {
        Self::robust()
    }
}

/// Parameters of the whole calibrator. Numbers are `f32`, whether the core computes in `f32` or `f64`.
///
/// # Examples
///
/// All functions are `const`, so a bad value can fail the build.
///
/// ```
/// use stereo_selfcal::Config;
/// const CONFIG: Config = match Config::robust().with_max_correction_rad(0.2) {
///     Ok(config) => config,
///     Err(_) => panic!("correction limit"),
/// };
/// # let _ = CONFIG;
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Parts"))]
pub struct Config {
    pub(crate) prior_sd_rad: f32,
    pub(crate) fit_limit_px: f32,
    pub(crate) max_passes: u16,
    pub(crate) min_correspondences: u16,
    pub(crate) noise_floor_px: f32,
    pub(crate) max_correction_rad: f32,
    pub(crate) memory_pairs: u32,
    pub(crate) lens_prior: LensPrior,
    pub(crate) lens_tracking: LensTracking,
    pub(crate) lens_yaw_sd_rad: f32,
    pub(crate) rows_limit_px: f32,
    pub(crate) depth_limit_px: f32,
    pub(crate) coverage_limit: f32,
}

/// Unchecked fields from which a configuration is deserialised.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Parts {
    prior_sd_rad: f32,
    fit_limit_px: f32,
    max_passes: u16,
    min_correspondences: u16,
    noise_floor_px: f32,
    max_correction_rad: f32,
    memory_pairs: u32,
    lens_prior: LensPrior,
    lens_tracking: LensTracking,
    lens_yaw_sd_rad: f32,
    rows_limit_px: f32,
    depth_limit_px: f32,
    coverage_limit: f32,
}

#[cfg(feature = "serde")]
impl TryFrom<Parts> for Config {
    type Error = ConfigError;

    fn try_from(parts: Parts) -> Result<Self, ConfigError> {
        Self::robust()
            .with_lens_tracking(parts.lens_tracking)
            .with_prior_sd_rad(parts.prior_sd_rad)?
            .with_fit_limit_px(parts.fit_limit_px)?
            .with_max_passes(parts.max_passes)?
            .with_min_correspondences(parts.min_correspondences)?
            .with_noise_floor_px(parts.noise_floor_px)?
            .with_max_correction_rad(parts.max_correction_rad)?
            .with_lens_prior(parts.lens_prior)?
            .with_lens_yaw_sd_rad(parts.lens_yaw_sd_rad)?
            .with_rows_limit_px(parts.rows_limit_px)?
            .with_depth_limit_px(parts.depth_limit_px)?
            .with_coverage_limit(parts.coverage_limit)?
            .with_memory_pairs(parts.memory_pairs)
    }
}

impl Config {
    /// Returns the parameters of the robust method: an M-estimator of whitened row offsets, fusion of moments, and
    /// change detection. The redescending loss is annealed until the inliers form a peak. Half of the matches may be
    /// outliers, and the estimate follows a step of the extrinsics within three pairs.
    ///
    /// The first pairs start at the factory extrinsics, whose standard deviation [`Config::with_prior_sd_rad`] sets.
    /// Later pairs start at the estimate.
    #[must_use]
    pub const fn robust() -> Self {
        Self {
            prior_sd_rad: 0.1,
            fit_limit_px: 3.0,
            max_passes: 24,
            min_correspondences: 12,
            noise_floor_px: 0.15,
            max_correction_rad: 0.5,
            memory_pairs: 1000,
            lens_prior: LensPrior::WIDE,
            lens_tracking: LensTracking::Report,
            lens_yaw_sd_rad: 4.6e-3,
            rows_limit_px: 1.0,
            depth_limit_px: 2.0,
            coverage_limit: 0.7,
        }
    }

    /// Sets the standard deviation of the factory extrinsics about each axis, rad. Default 0.1.
    ///
    /// A larger value follows a rig that is further off; a smaller one stabilises pairs with little information.
    ///
    /// # Errors
    /// [`ConfigError::PriorStandardDeviation`] if the value is outside 1e-4 to 1.
    pub const fn with_prior_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad >= 1e-4 && rad <= 1.0 {
            self.prior_sd_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::PriorStandardDeviation)
        }
    }

    /// Sets the limit of row offsets, px. Default 3. A match fits a calibration if its row offset is within the limit, or
    /// within 4.2 times the noise of a coordinate if that is more.
    ///
    /// A larger value counts more matches as fitting; a smaller one counts fewer.
    ///
    /// # Errors
    /// [`ConfigError::FitLimit`] unless the value is finite and above 0.
    pub const fn with_fit_limit_px(mut self, px: f32) -> Result<Self, ConfigError> {
        if px > 0.0 && px.is_finite() {
            self.fit_limit_px = px;
            Ok(self)
        } else {
            Err(ConfigError::FitLimit)
        }
    }

    /// Sets the number of passes over the batch that one pair may take. Default 24. A search in good data takes 9 to 12
    /// passes, a track takes 4.
    ///
    /// A pair takes up to 9 passes even if the limit is lower: a track, a search of 4 passes and a
    /// comparison. With a limit below 20 it does not test before the first lock whether a turned baseline fits better.
    ///
    /// The limit bounds the time of a pair. With fewer passes a solve may stop before the optimum; the report says so.
    ///
    /// # Errors
    /// [`ConfigError::MaxPasses`] if the value is below 2.
    pub const fn with_max_passes(mut self, passes: u16) -> Result<Self, ConfigError> {
        if passes >= 2 {
            self.max_passes = passes;
            Ok(self)
        } else {
            Err(ConfigError::MaxPasses)
        }
    }

    /// Sets the least number of usable correspondences that a pair needs. Default 12. A calibrator of a
    /// smaller capacity refuses every pair ([`crate::Rejection::TooFew`]).
    ///
    /// # Errors
    /// [`ConfigError::MinCorrespondences`] if the value is below 6: the five unknowns need five correspondences, and a
    /// residual needs one more.
    pub const fn with_min_correspondences(mut self, count: u16) -> Result<Self, ConfigError> {
        if count >= 6 {
            self.min_correspondences = count;
            Ok(self)
        } else {
            Err(ConfigError::MinCorrespondences)
        }
    }

    /// Sets the lower bound of the estimated noise of a coordinate, px. Default 0.15.
    ///
    /// The bound keeps the information finite on data without noise.
    ///
    /// # Errors
    /// [`ConfigError::NoiseFloor`] if the value is outside 0.001 to 5: the square of a much smaller one is 0 in `f32`, and
    /// above the largest noise of a pair (5.5 px) no pair would be solved.
    pub const fn with_noise_floor_px(mut self, px: f32) -> Result<Self, ConfigError> {
        if px >= 1e-3 && px <= 5.0 {
            self.noise_floor_px = px;
            Ok(self)
        } else {
            Err(ConfigError::NoiseFloor)
        }
    }

    /// Sets the memory `n`, pairs. Once `n` pairs are fused, each further pair multiplies the weight of the older pairs
    /// by `1 - 1 / n`. Default 1000.
    ///
    /// A larger value averages longer; a smaller one follows a drift that change detection misses, and keeps the
    /// reported standard deviation above the error of the lens models.
    ///
    /// # Errors
    /// [`ConfigError::Memory`] if the value is below 20.
    pub const fn with_memory_pairs(mut self, pairs: u32) -> Result<Self, ConfigError> {
        if pairs >= 20 {
            self.memory_pairs = pairs;
            Ok(self)
        } else {
            Err(ConfigError::Memory)
        }
    }

    /// Sets the standard deviations of the given lens models. Default [`LensPrior::WIDE`].
    ///
    /// A larger value increases the reported deviations that include the lens; a smaller one trusts the lens models
    /// more.
    ///
    /// # Errors
    /// [`ConfigError::LensPrior`] if a value is not finite, negative, or above its limit: 100 px for the principal
    /// point, 0.1 for all others.
    pub const fn with_lens_prior(mut self, prior: LensPrior) -> Result<Self, ConfigError> {
        if prior.is_valid() {
            self.lens_prior = prior;
            Ok(self)
        } else {
            Err(ConfigError::LensPrior)
        }
    }

    /// Takes the given lens models as exact: [`LensPrior::NONE`].
    #[must_use]
    pub const fn without_lens_prior(mut self) -> Self {
        self.lens_prior = LensPrior::NONE;
        self
    }

    /// Sets whether errors of the given lens models are reported or compensated. Default [`LensTracking::Report`]. It
    /// acts only with a lens prior.
    #[must_use]
    pub const fn with_lens_tracking(mut self, tracking: LensTracking) -> Self {
        self.lens_tracking = tracking;
        self
    }

    /// Sets the standard deviation of the apparent yaw `a` of the lenses, rad. An apparent yaw `a` shifts rows by
    /// `a x y` at unit depth. Default 4.6e-3, the RMS over five recordings of two rectified vehicle rigs; data sets
    /// that were calibrated jointly with boards have nearly none. It acts only with a lens prior.
    ///
    /// A larger value attributes more of the yaw that rows show to the lens; a smaller one attributes more to the
    /// mount.
    ///
    /// # Errors
    /// [`ConfigError::LensYaw`] if the value is outside 0 to 0.1.
    pub const fn with_lens_yaw_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad >= 0.0 && rad <= 0.1 {
            self.lens_yaw_sd_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::LensYaw)
        }
    }

    /// Sets the largest row offset in use at which a rig may arm, px ([`crate::Verdict::rows_px`]). Default 1: beyond it
    /// a matcher that searches along rows misses. A matcher that searches across rows tolerates as much as it searches;
    /// a match within three limits fits the calibration in use.
    /// Infinity is allowed: a rig whose rows nobody uses.
    ///
    /// # Errors
    /// [`ConfigError::RowsLimit`] unless the value is above 0.
    pub const fn with_rows_limit_px(mut self, px: f32) -> Result<Self, ConfigError> {
        if px > 0.0 {
            self.rows_limit_px = if px < f32::MAX { px } else { f32::MAX };
            Ok(self)
        } else {
            Err(ConfigError::RowsLimit)
        }
    }

    /// Sets the largest expected error of disparity at which a rig may arm, px ([`crate::Verdict::depth_px`]). Default
    /// 2. Infinity is allowed: a rig that uses rows and no metric depth, such as one that started from a guess.
    ///
    /// # Errors
    /// [`ConfigError::DepthLimit`] unless the value is above 0.
    pub const fn with_depth_limit_px(mut self, px: f32) -> Result<Self, ConfigError> {
        if px > 0.0 {
            self.depth_limit_px = if px < f32::MAX { px } else { f32::MAX };
            Ok(self)
        } else {
            Err(ConfigError::DepthLimit)
        }
    }

    /// Sets the least coverage at which a rig may arm ([`crate::Verdict::coverage`]). Default 0.7.
    ///
    /// # Errors
    /// [`ConfigError::CoverageLimit`] if the value is outside 0 to 1.
    pub const fn with_coverage_limit(mut self, share: f32) -> Result<Self, ConfigError> {
        if share >= 0.0 && share <= 1.0 {
            self.coverage_limit = share;
            Ok(self)
        } else {
            Err(ConfigError::CoverageLimit)
        }
    }

    /// Sets the correction limit, rad. A pair is not fused if `R` or `t` of the estimate with the pair differs from the
    /// factory value by a larger angle. Default 0.5.
    ///
    /// # Errors
    /// [`ConfigError::MaxCorrection`] unless the value is above 0 and below 1.5.
    pub const fn with_max_correction_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad > 0.0 && rad < 1.5 {
            self.max_correction_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::MaxCorrection)
        }
    }

    /// Returns the information of the prior on each unknown, 1/rad^2.
    pub(crate) fn prior<T: Scalar>(&self) -> T {
        let sd = T::single(self.prior_sd_rad);
        T::ONE / (sd * sd)
    }
}
