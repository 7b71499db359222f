//! Parameters, and the effect of larger and smaller values.

mod context;
mod lens_prior;
mod lens_tracking;
#[cfg(feature = "paper")]
pub(crate) mod paper;

pub(crate) use context::Context;
pub use lens_prior::LensPrior;
pub use lens_tracking::LensTracking;

use crate::error::ConfigError;
#[cfg(feature = "paper")]
use crate::paper::Settings;
use crate::scalar::Scalar;

impl Default for Config {
    /// [`Config::robust`].
    fn default() -> Self {
        Self::robust()
    }
}

/// How a pair is solved and how pairs are fused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Method {
    /// Huber weights, mean directions.
    #[cfg(feature = "paper")]
    Paper,
    /// Whitened residuals, redescending loss, fusion by moments, change detection.
    Robust,
}

/// Parameters of the whole calibrator. Numbers are `f32` whatever the scalar of the core.
///
/// # Examples
///
/// `const` throughout: a bad value can fail the build.
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
#[cfg_attr(feature = "serde", serde(remote = "Self"))]
pub struct Config {
    pub(crate) method: Method,
    pub(crate) prior_sd_rad: f32,
    pub(crate) huber_threshold_px: f32,
    pub(crate) max_passes: u16,
    pub(crate) min_correspondences: u16,
    pub(crate) noise_floor_px: f32,
    pub(crate) max_correction_rad: f32,
    pub(crate) memory_pairs: u32,
    pub(crate) lens_prior: LensPrior,
    pub(crate) lens_tracking: LensTracking,
    pub(crate) lens_yaw_sd_rad: f32,
    #[cfg(feature = "paper")]
    pub(crate) paper: Settings,
}

impl Config {
    /// The published method: Huber weights on plain row offsets, each pair from the factory extrinsics, mean-direction
    /// fusion (eqs 16-22).
    ///
    /// Its only defence against outliers is the Huber weight: see the limits in the README.
    #[cfg(feature = "paper")]
    #[must_use]
    pub const fn paper() -> Self {
        Self { method: Method::Paper, max_passes: 100, noise_floor_px: 0.02, ..Self::robust() }
    }

    /// An M-estimator of whitened row offsets, its redescending loss annealed until the inliers form a peak, fusion of
    /// moments, and change detection: half of the matches may be outliers, and a step is followed within three pairs.
    ///
    /// The first pairs start at the factory extrinsics, of standard deviation [`Config::with_prior_sd_rad`], the others
    /// at the estimate.
    #[must_use]
    pub const fn robust() -> Self {
        Self {
            method: Method::Robust,
            prior_sd_rad: 0.1,
            huber_threshold_px: 1.0,
            max_passes: 24,
            min_correspondences: 12,
            noise_floor_px: 0.15,
            max_correction_rad: 0.5,
            memory_pairs: 1000,
            lens_prior: LensPrior::WIDE,
            lens_tracking: LensTracking::Report,
            lens_yaw_sd_rad: 4.6e-3,
            #[cfg(feature = "paper")]
            paper: Settings::DEFAULT,
        }
    }

    /// Standard deviation of the factory extrinsics about each axis, rad. Default 0.1. Robust preset only.
    ///
    /// A larger value follows a rig that is further off; a smaller one stabilises pairs with little information.
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

    /// Huber threshold `c_t` of eq 18, px of row offset. Default 1. Paper preset; in both presets [`crate::Health`] counts a
    /// match as fitting within three thresholds.
    ///
    /// A larger value trusts more matches and bends to outliers; a smaller one discards the information of good matches and
    /// slows convergence from a start that is far off.
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

    /// Passes over the batch that one pair may take. Paper preset: 100, without that of the evaluation.
    /// Robust preset: 24 in all; a search in good data takes 9 to 12, a track 4.
    ///
    /// The robust preset counts the evaluation, and takes up to 9 passes where the limit is lower: a few for each estimate
    /// that the pair is compared with. Below 20 no turned baseline is tried before the first lock.
    ///
    /// This bounds the time of a pair. With fewer passes a solve may stop before the optimum; the report says so.
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

    /// Fewest usable correspondences that a pair is solved from. Default 12.
    ///
    /// # Errors
    /// [`ConfigError::MinCorrespondences`] below 6: five unknowns, and one for a residual.
    pub const fn with_min_correspondences(mut self, count: u16) -> Result<Self, ConfigError> {
        if count >= 6 {
            self.min_correspondences = count;
            Ok(self)
        } else {
            Err(ConfigError::MinCorrespondences)
        }
    }

    /// Lower bound on the estimated noise, px. Robust preset: of a coordinate, default 0.15. Paper preset: of a row offset,
    /// default 0.02.
    ///
    /// Keeps the information finite on data without noise.
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

    /// Parameters of the published method alone. Default [`Settings::DEFAULT`].
    #[cfg(feature = "paper")]
    #[must_use]
    pub const fn with_paper(mut self, settings: Settings) -> Self {
        self.paper = settings;
        self
    }

    /// Memory `n`, pairs: once there are `n`, each further pair multiplies the weight of the older ones by `1 - 1 / n`.
    /// Default 1000. Robust preset only.
    ///
    /// Larger averages longer. Smaller follows a drift that change detection misses, and keeps the reported standard deviation
    /// above the error of the lens models.
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

    /// Standard deviations of the given lens models. Default [`LensPrior::WIDE`]. Robust preset only.
    ///
    /// A larger value widens the deviations with the lens uncertain; a smaller one trusts the lens models more.
    ///
    /// # Errors
    /// [`ConfigError::LensPrior`] unless each is finite, 0 or more, and at most 0.1, of the principal point 100 px.
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

    /// Whether errors of the given lens models are reported or compensated. Default [`LensTracking::Report`]. Robust preset with a
    /// lens prior only.
    #[must_use]
    pub const fn with_lens_tracking(mut self, tracking: LensTracking) -> Self {
        self.lens_tracking = tracking;
        self
    }

    /// Standard deviation of the apparent yaw of the lenses, rad: of `a`, where rows are off by `a x y` at unit depth.
    /// Default 4.6e-3, the RMS of five recordings of two rectified vehicle rigs; eleven recordings in all have 1.5e-3.
    /// Robust preset with a lens prior only.
    ///
    /// A larger value attributes more of the yaw that rows show to the lens; a smaller one attributes more to the mount.
    ///
    /// # Errors
    /// [`ConfigError::LensYaw`] unless from 0 to 0.1.
    pub const fn with_lens_yaw_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad >= 0.0 && rad <= 0.1 {
            self.lens_yaw_sd_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::LensYaw)
        }
    }

    /// Correction limit, rad: a pair whose `R` or `t` is further from the factory values is not fused. Default 0.5.
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

    /// The same parameters, if each is within its range.
    #[cfg(feature = "serde")]
    fn checked(self) -> Result<Self, ConfigError> {
        #[cfg(feature = "paper")]
        let checked = self.with_paper(self.paper.checked()?);
        #[cfg(not(feature = "paper"))]
        let checked = self;
        checked
            .with_prior_sd_rad(self.prior_sd_rad)?
            .with_huber_threshold_px(self.huber_threshold_px)?
            .with_max_passes(self.max_passes)?
            .with_min_correspondences(self.min_correspondences)?
            .with_noise_floor_px(self.noise_floor_px)?
            .with_max_correction_rad(self.max_correction_rad)?
            .with_lens_prior(self.lens_prior)?
            .with_lens_yaw_sd_rad(self.lens_yaw_sd_rad)?
            .with_memory_pairs(self.memory_pairs)
    }

    /// Information of the prior about each unknown, 1/rad^2.
    pub(crate) fn prior<T: Scalar>(&self) -> T {
        let sd = T::single(self.prior_sd_rad);
        T::ONE / (sd * sd)
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Config {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, to)
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Config {
    /// Refuses a parameter out of its range.
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::deserialize(from)?.checked().map_err(serde::de::Error::custom)
    }
}
