//! A rotation and a translation, which take points from one frame to another.

use anyhow::{Result, ensure};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Largest deviation of an element of `R^T R` from the identity: a matrix with two decimals passes, as numpy may print
/// it.
const ROTATION: f64 = 2e-2;

/// Largest deviation of a quaternion's length from 1.
const UNIT: f64 = 1e-2;

/// `p -> R p + t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rigid {
    pub(super) r: Matrix3<f64>,
    pub(super) t: Vector3<f64>,
}

impl Rigid {
    pub(super) const NONE: Self =
        Self { r: Matrix3::new(1., 0., 0., 0., 1., 0., 0., 0., 1.), t: Vector3::new(0., 0., 0.) };

    /// The transform of a quaternion of about unit length, `w x y z`, and a translation.
    pub(super) fn of_quaternion([w, x, y, z]: [f64; 4], t: [f64; 3]) -> Result<Self> {
        let q = Quaternion::new(w, x, y, z);
        ensure!(
            (q.norm() - 1.0).abs() <= UNIT,
            "not a rotation: expected a quaternion of length 1, not {}",
            q.norm()
        );
        let r = UnitQuaternion::from_quaternion(q).to_rotation_matrix();
        Ok(Self { r: *r.matrix(), t: t.into() })
    }

    /// An error unless `R` is a rotation.
    pub(super) fn check(&self) -> Result<()> {
        ensure!(
            self.r.iter().any(|x| *x != 0.0),
            "R is all zeros: the rig was never calibrated; calibrate it"
        );
        let off = (self.r.transpose() * self.r - Matrix3::identity()).amax();
        ensure!(
            off <= ROTATION,
            "R is not a rotation: R^T R differs from the identity by {off:.1e}; give the R of the calibration as it was written"
        );
        ensure!(
            self.r.determinant() > 0.0,
            "R is a reflection, not a rotation: one of its frames is left-handed, as those of Unity and Unreal; write R and t \
             for the axes x right, y down, z forward"
        );
        Ok(())
    }

    /// The inverse transform.
    pub(super) fn inverse(&self) -> Self {
        let r = self.r.transpose();
        Self { r, t: -(r * self.t) }
    }

    /// The transform that applies this one, then `next`.
    pub(super) fn then(&self, next: &Self) -> Self {
        Self { r: next.r * self.r, t: next.r * self.t + next.t }
    }

    /// The transform from the left camera to the right one, if both given transforms lead to a common frame.
    pub(super) fn left_to_right([left, right]: [Self; 2]) -> Self {
        left.then(&right.inverse())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_and_its_inverse_cancel_and_two_frames_meet_in_a_third() {
        let q = [0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt(), 0.0];
        let one = Rigid::of_quaternion(q, [1.0, 2.0, 3.0]).unwrap();
        let back = one.then(&one.inverse());
        assert!((back.r - Matrix3::identity()).amax() < 1e-15 && back.t.amax() < 1e-15);
        // A quarter turn about y takes z to x.
        assert!((one.r * Vector3::z() - Vector3::x()).amax() < 1e-15);
        // The right camera stands 0.1 to the right of the left one: its points are further left.
        let right = Rigid { t: Vector3::new(0.1, 0.0, 0.0), ..Rigid::NONE };
        let way = Rigid::left_to_right([Rigid::NONE, right]);
        assert!((way.t.x + 0.1).abs() < 1e-15, "{way:?}");
        assert!(Rigid::of_quaternion([0.0; 4], [0.0; 3]).is_err());
    }
}
