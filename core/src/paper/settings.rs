//! Parameters of the published method.

use crate::error::ConfigError;

/// Central tendency `s*` of the rotation angles of the pairs (eq 22).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Central {
    /// Arithmetic mean: efficient where no pair is grossly wrong.
    Mean,
    /// Median: a minority of wrong pairs hardly moves it. It is exact up to 31 pairs, then a streaming estimate in
    /// constant memory.
    Median,
}

/// Parameters of the published method. Numbers are `f32`, whether the core computes in `f32` or `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Parts"))]
pub struct Settings {
    pub(super) huber_threshold_px: f32,
    pub(super) max_passes: u16,
    pub(super) min_correspondences: u16,
    pub(super) noise_floor_px: f32,
    pub(super) step_tolerance_rad: f32,
    pub(super) angle: Central,
    pub(super) max_sd_rad: f32,
    pub(super) max_correction_rad: f32,
}

/// Unchecked fields from which settings are deserialised.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Parts {
    huber_threshold_px: f32,
    max_passes: u16,
    min_correspondences: u16,
    noise_floor_px: f32,
    step_tolerance_rad: f32,
    angle: Central,
    max_sd_rad: f32,
    max_correction_rad: f32,
}

#[cfg(feature = "serde")]
impl TryFrom<Parts> for Settings {
    type Error = ConfigError;

    fn try_from(parts: Parts) -> Result<Self, ConfigError> {
        Self::DEFAULT
            .with_angle(parts.angle)
            .with_huber_threshold_px(parts.huber_threshold_px)?
            .with_max_passes(parts.max_passes)?
            .with_min_correspondences(parts.min_correspondences)?
            .with_noise_floor_px(parts.noise_floor_px)?
            .with_step_tolerance_rad(parts.step_tolerance_rad)?
            .with_max_sd_rad(parts.max_sd_rad)?
            .with_max_correction_rad(parts.max_correction_rad)
    }
}

impl Default for Settings {
    /// Returns [`Settings::DEFAULT`].
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Settings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        huber_threshold_px: 1.0,
        max_passes: 100,
        min_correspondences: 12,
        noise_floor_px: 0.02,
        step_tolerance_rad: 1e-9,
        angle: Central::Mean,
        max_sd_rad: 0.12,
        max_correction_rad: 0.5,
    };

    /// Sets the Huber threshold `c_t` of eq 18, px of row offset. Default 1.
    ///
    /// A larger value lets outliers bias the result; a smaller one discards the information of good matches and slows
    /// convergence from a start that is far off.
    ///
    /// # Errors
    /// [`ConfigError::HuberThreshold`] unless the value is finite and above 0.
    pub const fn with_huber_threshold_px(mut self, px: f32) -> Result<Self, ConfigError> {
        if px > 0.0 && px.is_finite() {
            self.huber_threshold_px = px;
            Ok(self)
        } else {
            Err(ConfigError::HuberThreshold)
        }
    }

    /// Sets the number of passes over the batch that the solver may take, without the evaluation pass. Default 100.
    ///
    /// The limit bounds the time of a pair. With fewer passes the solver may stop before the optimum; the report says
    /// so.
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

    /// Sets the least number of usable correspondences that a pair needs. Default 12.
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

    /// Sets the lower bound of the estimated noise of a row offset, px. Default 0.02. The bound keeps the information
    /// finite on data without noise.
    ///
    /// # Errors
    /// [`ConfigError::NoiseFloor`] if the value is outside 0.001 to 100: the square of a much smaller one is 0 in `f32`.
    pub const fn with_noise_floor_px(mut self, px: f32) -> Result<Self, ConfigError> {
        if px >= 1e-3 && px <= 100.0 {
            self.noise_floor_px = px;
            Ok(self)
        } else {
            Err(ConfigError::NoiseFloor)
        }
    }

    /// Sets the step tolerance, rad: the solver has converged if the largest component of an accepted step with low
    /// damping is at most this. Default 1e-9.
    ///
    /// The solver uses at least 8 units in the last place of 1: 1e-6 rad in `f32`.
    ///
    /// # Errors
    /// [`ConfigError::StepTolerance`] if the value is outside 0 to 0.1.
    pub const fn with_step_tolerance_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad >= 0.0 && rad <= 0.1 {
            self.step_tolerance_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::StepTolerance)
        }
    }

    /// Sets the average of the rotation angles in fusion (eq 22): mean or median. Default mean.
    #[must_use]
    pub const fn with_angle(mut self, angle: Central) -> Self {
        self.angle = angle;
        self
    }

    /// Sets the largest standard deviation of the weakest direction of a pair, rad. The gate refuses pairs above it.
    /// Default 0.12.
    ///
    /// # Errors
    /// [`ConfigError::MaxStandardDeviation`] unless the value is finite and above 0.
    pub const fn with_max_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad > 0.0 && rad.is_finite() {
            self.max_sd_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::MaxStandardDeviation)
        }
    }

    /// Sets the correction limit, rad. A pair is not fused if `R` or `t` of the pair alone, or of the estimate with the
    /// pair, differs from the start by a larger angle. Default 0.5.
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
}
