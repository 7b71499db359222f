//! Parameters, with what larger and smaller values do. `const` throughout: a bad value can fail
//! the build.
//!
//! ```
//! use stereo_selfcal::Config;
//! const CONFIG: Config = match Config::paper().with_huber_threshold_px(1.5) {
//!     Ok(config) => config,
//!     Err(_) => panic!("huber threshold"),
//! };
//! ```

use crate::error::ConfigError;
use crate::scalar::Scalar;

impl Default for Config {
    /// [`Config::robust`].
    fn default() -> Self {
        Self::robust()
    }
}

/// Central tendency of the angles of the pairs' rotations, `s*` of eq 22.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Central {
    /// Arithmetic mean: efficient where no pair is grossly wrong.
    Mean,
    /// Median: unmoved by a minority of wrong pairs; exact up to 31 pairs, then a streaming
    /// estimate in constant memory.
    Median,
}

/// How a pair is solved and how pairs are fused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    /// Huber weights, mean directions.
    Paper,
    /// Whitened residuals, redescending loss, fusion by moments, watched.
    Robust,
}

/// Parameters of the whole calibrator. Numbers are `f32` whatever the scalar of the core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    pub(crate) method: Method,
    pub(crate) prior_sd_rad: f32,
    pub(crate) huber_threshold_px: f32,
    pub(crate) max_passes: u16,
    pub(crate) step_tolerance_rad: f32,
    pub(crate) min_correspondences: u16,
    pub(crate) noise_floor_px: f32,
    pub(crate) angle: Central,
    pub(crate) max_sd_rad: f32,
    pub(crate) max_correction_rad: f32,
    pub(crate) memory_pairs: u32,
    pub(crate) applies_itself: bool,
}

impl Config {
    /// The method as published: Huber weights on plain row offsets, each pair from the factory
    /// extrinsics, mean-direction fusion (eqs 16-22).
    ///
    /// Its only defence against mismatches is the Huber weight: see the limits in the README.
    #[must_use]
    pub const fn paper() -> Self {
        Self {
            method: Method::Paper,
            prior_sd_rad: 0.1,
            huber_threshold_px: 1.0,
            max_passes: 100,
            step_tolerance_rad: 1e-9,
            min_correspondences: 12,
            noise_floor_px: 0.02,
            angle: Central::Mean,
            max_sd_rad: 0.12,
            max_correction_rad: 0.5,
            memory_pairs: 1000,
            applies_itself: false,
        }
    }

    /// Row offsets over their own standard deviation, a redescending loss annealed from 120 px, fusion
    /// of moments and a watch over the rig: survives half of the matches being wrong, follows a knock in
    /// three pairs.
    ///
    /// The first pairs start at the factory extrinsics, which count as known to
    /// [`Config::with_prior_sd_rad`], the others at the estimate.
    #[must_use]
    pub const fn robust() -> Self {
        Self { method: Method::Robust, max_passes: 12, noise_floor_px: 0.15, ..Self::paper() }
    }

    /// Standard deviation of the factory extrinsics about each axis, rad. Default 0.1. Robust preset
    /// only.
    ///
    /// Larger follows a rig that is further off; smaller steadies pairs that say little.
    ///
    /// # Errors
    /// [`ConfigError::PriorStandardDeviation`] unless from 1e-4 to 1.
    pub const fn with_prior_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad >= 1e-4 && rad <= 1.0 {
            self.prior_sd_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::PriorStandardDeviation)
        }
    }

    /// Huber threshold `c_t` of eq 18, px of row offset. Default 1. Paper preset only, but for the
    /// screening of [`crate::Health`].
    ///
    /// Larger trusts more matches and bends to mismatches; smaller discards the information of good
    /// matches and slows convergence from a start that is far off.
    ///
    /// # Errors
    /// [`ConfigError::HuberThreshold`] unless finite and above 0.
    pub const fn with_huber_threshold_px(mut self, px: f32) -> Result<Self, ConfigError> {
        if px > 0.0 && px.is_finite() {
            self.huber_threshold_px = px;
            Ok(self)
        } else {
            Err(ConfigError::HuberThreshold)
        }
    }

    /// Passes over the batch that one pair may take. Paper preset: 100, the judging one not counted.
    /// Robust preset: 12 in all; twice as many with at most 128 matches.
    ///
    /// The robust preset counts the judging one, and takes up to 9 where the limit is lower: a few for
    /// each hypothesis that is asked.
    ///
    /// The bound on the time of a pair. Fewer may stop short of the optimum (reported).
    ///
    /// # Errors
    /// [`ConfigError::MaxPasses`] below 2.
    pub const fn with_max_passes(mut self, passes: u16) -> Result<Self, ConfigError> {
        if passes >= 2 {
            self.max_passes = passes;
            Ok(self)
        } else {
            Err(ConfigError::MaxPasses)
        }
    }

    /// The solver has converged when its step is below this, rad. Default 1e-9.
    ///
    /// Never taken as smaller than 8 units in the last place of 1: 1e-6 rad in `f32`.
    ///
    /// # Errors
    /// [`ConfigError::StepTolerance`] unless from 0 to 0.1.
    pub const fn with_step_tolerance_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad >= 0.0 && rad <= 0.1 {
            self.step_tolerance_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::StepTolerance)
        }
    }

    /// Fewest usable correspondences that a pair is solved from. Default 12.
    ///
    /// # Errors
    /// [`ConfigError::MinCorrespondences`] below 6: five unknowns, and one to judge them by.
    pub const fn with_min_correspondences(mut self, count: u16) -> Result<Self, ConfigError> {
        if count >= 6 {
            self.min_correspondences = count;
            Ok(self)
        } else {
            Err(ConfigError::MinCorrespondences)
        }
    }

    /// Smallest noise believed, px: of a row offset, default 0.02; robust preset, of a coordinate, 0.15.
    ///
    /// Keeps the reported certainty finite on data without noise.
    ///
    /// # Errors
    /// [`ConfigError::NoiseFloor`] unless finite and above 0.
    pub const fn with_noise_floor_px(mut self, px: f32) -> Result<Self, ConfigError> {
        if px > 0.0 && px.is_finite() {
            self.noise_floor_px = px;
            Ok(self)
        } else {
            Err(ConfigError::NoiseFloor)
        }
    }

    /// Mean or median of the angles in fusion (eq 22). Default mean.
    #[must_use]
    pub const fn with_angle(mut self, angle: Central) -> Self {
        self.angle = angle;
        self
    }

    /// The gate refuses a pair whose weakest direction is less certain than this, rad. Default 0.12.
    /// Paper preset only: the robust one takes from a pair what it knows.
    ///
    /// # Errors
    /// [`ConfigError::MaxStandardDeviation`] unless finite and above 0.
    pub const fn with_max_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad > 0.0 && rad.is_finite() {
            self.max_sd_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::MaxStandardDeviation)
        }
    }

    /// Pairs after which the oldest fade: the weight of a pair falls by one part in so many with each
    /// further one. Default 1000. Robust preset only.
    ///
    /// Larger averages longer; smaller follows a rig that drifts by less than the watch over it can tell,
    /// and keeps the claimed deviation from falling below what a lens model is worth.
    ///
    /// # Errors
    /// [`ConfigError::Memory`] below 20.
    pub const fn with_memory_pairs(mut self, pairs: u32) -> Result<Self, ConfigError> {
        if pairs >= 20 {
            self.memory_pairs = pairs;
            Ok(self)
        } else {
            Err(ConfigError::Memory)
        }
    }

    /// Lets [`crate::Calibrator::fuse`] put the estimate into use whenever
    /// [`crate::Calibrator::apply`] would. Default: only `apply` does.
    #[must_use]
    pub const fn with_automatic_apply(mut self, automatic: bool) -> Self {
        self.applies_itself = automatic;
        self
    }

    /// The gate refuses a pair whose `R` or `t` is further from the factory values than this, rad.
    /// Default 0.5.
    ///
    /// # Errors
    /// [`ConfigError::MaxCorrection`] unless above 0 and below 1.5.
    pub const fn with_max_correction_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad > 0.0 && rad < 1.5 {
            self.max_correction_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::MaxCorrection)
        }
    }

    /// Information of the prior about each axis, 1/rad^2.
    pub(crate) fn prior<T: Scalar>(&self) -> T {
        let sd = T::single(self.prior_sd_rad);
        T::ONE / (sd * sd)
    }
}
