//! Configuration and rig, which each call of the estimator reads.

use super::Config;
use crate::algebra::block_variances::BlockVariances;
use crate::algebra::lens_terms::LENS_PARAMETERS;
use crate::algebra::normal_equations::NormalEquations;
use crate::error::Rejection;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::metrics::{baseline_angle, rotation_angle};
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{CALIBRATED_YAW_SD_RAD, MAX_IN_USE};

/// Configuration and rig of a call.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Context<'a, T: Scalar> {
    pub(crate) config: &'a Config,
    pub(crate) factory: &'a Extrinsics<T>,
    /// Standard deviation of the yaw of the factory extrinsics, rad; `None` if they are a guess.
    pub(crate) factory_yaw_sd_rad: Option<f32>,
    /// Mean focal length of the cameras, px.
    pub(crate) focal: T,
    /// Rectifying rotations of the factory extrinsics.
    pub(crate) factory_pose: RectifyingRotations<T>,
    /// Information of the factory extrinsics on each unknown, 1/rad^2.
    pub(crate) prior: T,
    /// Variances of the vibration: of single pairs about the mean rig, rad^2.
    pub(crate) vibration: BlockVariances<T>,
    /// Share of the information of the present pair that is new, above 0 to 1.
    pub(crate) share: T,
    /// Factor of the variance of the gradient of the present pair in sums of successive pairs, at least 1.
    pub(crate) scatter: T,
}

impl<'a, T: Scalar> Context<'a, T> {
    pub(crate) fn new(config: &'a Config, factory: &'a Extrinsics<T>, focal: T) -> Self {
        let factory_pose = RectifyingRotations::from(factory);
        let vibration = BlockVariances::ZERO;
        let (factory_yaw_sd_rad, prior) = (Some(CALIBRATED_YAW_SD_RAD), config.prior());
        let [share, scatter] = [T::ONE; 2];
        Self {
            config,
            factory,
            factory_yaw_sd_rad,
            focal,
            factory_pose,
            prior,
            vibration,
            share,
            scatter,
        }
    }

    /// Returns the context with the standard deviation of the factory yaw, rad; `None` for an unknown yaw.
    pub(crate) fn knowing_yaw(self, factory_yaw_sd_rad: Option<f32>) -> Self {
        Self { factory_yaw_sd_rad, ..self }
    }

    /// Returns the context with the variances of a vibration.
    pub(crate) fn vibrating(self, vibration: BlockVariances<T>) -> Self {
        Self { vibration, ..self }
    }

    /// Returns the context of a pair of which only a share is new, and whose gradient scatters by a factor more.
    pub(crate) fn counting(self, [share, scatter]: [T; 2]) -> Self {
        Self { share, scatter, ..self }
    }

    /// Returns the standard deviations of the lens parameters, in the order of [`crate::algebra::lens_terms`].
    pub(crate) fn lens_prior(&self) -> [T; LENS_PARAMETERS] {
        self.config.lens_prior.of_terms(self.focal)
    }

    /// Returns whether any lens parameter except `p2` is uncertain.
    pub(crate) fn has_lens_prior(&self) -> bool {
        self.lens_prior().iter().any(|sd| *sd > T::ZERO)
    }

    /// Returns the variances of the factory yaw and of the apparent yaw of the lens, rad^2. The first is `None` if the
    /// factory yaw is unknown, or if the lens is exact.
    pub(crate) fn yaw_variances(&self) -> (Option<T>, T) {
        let square = |sd: f32| T::single(sd) * T::single(sd);
        let lens_yaw_sd_rad = self.config.lens_yaw_sd_rad;
        // Exact lenses have no apparent yaw, so the rows determine the yaw of the mount.
        if !self.has_lens_prior() {
            return (None, T::ZERO);
        }
        (self.factory_yaw_sd_rad.map(square), square(lens_yaw_sd_rad))
    }

    /// Returns the factor that multiplies the sums over `pairs` pairs when the share of a further pair is added; it is
    /// below 1 once the memory is full.
    pub(crate) fn fading(&self, pairs: u32) -> T {
        let memory = self.config.memory_pairs;
        if pairs >= memory { T::ONE - self.share / T::count(memory) } else { T::ONE }
    }

    /// Adds the prior at the factory extrinsics to the normal equations at a pose.
    pub(crate) fn add_prior(&self, pose: &RectifyingRotations<T>, normal: &mut NormalEquations<T>) {
        normal.information.0.add_diagonal(self.prior);
        normal.gradient -= pose.unknowns_to(&self.factory_pose) * self.prior;
    }

    /// Returns whether extrinsics are within the correction limit of the factory extrinsics.
    pub(crate) fn allows(&self, found: &Extrinsics<T>) -> bool {
        self.allows_times(T::ONE, found)
    }

    /// Returns whether extrinsics may be in use. Their limit is [`MAX_IN_USE`] times that of an estimate, because
    /// keeping the baseline in use moves the applied extrinsics away from the estimate.
    pub(crate) fn allows_in_use(&self, found: &Extrinsics<T>) -> bool {
        self.allows_times(T::lit(MAX_IN_USE), found)
    }

    /// Returns whether extrinsics are within `factor` times the correction limit of the factory extrinsics.
    #[inline(never)]
    pub(crate) fn allows_times(&self, factor: T, found: &Extrinsics<T>) -> bool {
        let limit = T::single(self.config.max_correction_rad) * factor;
        baseline_angle(found.translation(), self.factory.translation()) <= limit
            && rotation_angle(found.rotation(), self.factory.rotation()) <= limit
    }

    /// Checks that a pose can be rectified and is within the correction limit.
    ///
    /// # Errors
    /// [`Rejection::NoRig`], [`Rejection::CorrectionLimit`].
    pub(crate) fn check(&self, pose: &RectifyingRotations<T>) -> Result<(), Rejection> {
        let found = pose.extrinsics().map_err(|_| Rejection::NoRig)?;
        if self.allows(&found) { Ok(()) } else { Err(Rejection::CorrectionLimit) }
    }
}
