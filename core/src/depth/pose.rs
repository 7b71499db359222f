//! Poses by what they describe: the mount, or the rows of the images (`ESTIMATOR.md`, section 20). Their yaws differ by
//! the apparent yaw of the lens. Calibrations in use and estimates that are reported are poses of the mount. Pairs and
//! their sums show poses of the rows.

use nalgebra::{Vector2, Vector3};

use crate::config::Context;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Pose of the mount, which depth needs. With it the rows of the images differ by `a x y`, for an apparent yaw `a` of
/// the lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MountPose<T: Scalar>(RectifyingRotations<T>);

/// Pose that makes the rows of the images equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RowsPose<T: Scalar>(RectifyingRotations<T>);

impl<T: Scalar> From<&Extrinsics<T>> for MountPose<T> {
    fn from(extrinsics: &Extrinsics<T>) -> Self {
        Self(RectifyingRotations::from(extrinsics))
    }
}

impl<T: Scalar> From<RectifyingRotations<T>> for RowsPose<T> {
    fn from(rotations: RectifyingRotations<T>) -> Self {
        Self(rotations)
    }
}

impl<T: Scalar> MountPose<T> {
    /// Returns the rectifying rotations.
    pub(crate) fn rotations(&self) -> &RectifyingRotations<T> {
        &self.0
    }

    /// Returns the yaw from the factory extrinsics, rad.
    pub(crate) fn yaw(&self, context: &Context<'_, T>) -> T {
        yaw(&self.0, context)
    }

    /// Returns the pose that makes the rows equal; `None` if the turn is too large.
    ///
    /// * `lens_yaw`: apparent yaw of the lens, rad.
    pub(crate) fn with_lens(&self, lens_yaw: T) -> Option<RowsPose<T>> {
        turned(&self.0, lens_yaw).map(RowsPose)
    }
}

impl<T: Scalar> RowsPose<T> {
    /// Returns the rectifying rotations.
    pub(crate) fn rotations(&self) -> &RectifyingRotations<T> {
        &self.0
    }

    /// Returns the yaw from the factory extrinsics, rad: the sum of the yaw of the mount and that of the lens.
    pub(crate) fn yaw(&self, context: &Context<'_, T>) -> T {
        yaw(&self.0, context)
    }

    /// Returns the pose of the mount; `None` if the turn is too large.
    ///
    /// * `yaw`: yaw of the mount from the factory extrinsics, rad; `None` if the rows alone determine it.
    pub(crate) fn with_mount(
        &self,
        yaw: Option<T>,
        context: &Context<'_, T>,
    ) -> Option<MountPose<T>> {
        let turn = yaw.map_or(T::ZERO, |yaw| yaw - self.yaw(context));
        turned(&self.0, turn).map(MountPose)
    }
}

/// Returns the rotation of a pose about y from the factory extrinsics, rad.
fn yaw<T: Scalar>(pose: &RectifyingRotations<T>, context: &Context<'_, T>) -> T {
    context.factory_pose.unknowns_to(pose).y
}

/// Returns a pose after a rotation of `R` about y, rad.
fn turned<T: Scalar>(pose: &RectifyingRotations<T>, turn: T) -> Option<RectifyingRotations<T>> {
    // A step of 0 would introduce rounding errors.
    if turn == T::ZERO {
        return Some(*pose);
    }
    pose.stepped(&(Vector3::y() * turn), &Vector2::zeros())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::geometry::rectification::tests::pose;

    #[test]
    fn rows_show_the_yaw_of_mount_and_lens_together() {
        let config = Config::robust();
        let context = Context::new(&config, &Extrinsics::SIDE_BY_SIDE, 1400.0_f64);
        let mount = MountPose::from(&pose([1e-3, 2e-3, -3e-3], [4e-3, 1e-3]).extrinsics().unwrap());
        let rows = mount.with_lens(5e-3).unwrap();
        assert!((rows.yaw(&context) - mount.yaw(&context) - 5e-3).abs() < 1e-6);
        let back = rows.with_mount(Some(mount.yaw(&context)), &context).unwrap();
        assert!(back.rotations().unknowns_to(mount.rotations()).norm() < 1e-6);
        assert_eq!(rows.with_mount(None, &context).unwrap().rotations(), rows.rotations());
    }
}
