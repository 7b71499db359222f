//! The two rectifying rotations, and the extrinsics they stand for (eqs 6-8).

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};

use crate::error::ExtrinsicsError;
use crate::extrinsics::{Extrinsics, MIN_LATERAL};
use crate::scalar::Scalar;
use crate::so3;

/// `R_l`, `R_r` with `p_l' = R_l p_l`, `p_r' = R_r p_r`: rows of both rectified views coincide.
///
/// Always in the gauge of eq 8, `r_r2 . i_3 = 0`: the pair may turn together about the baseline,
/// and this fixes that turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectifyingRotations<T: Scalar> {
    left: Rotation3<T>,
    right: Rotation3<T>,
}

impl<T: Scalar> From<&Extrinsics<T>> for RectifyingRotations<T> {
    /// `R_r` = rows `-t`, `normalize(i_3 x r_r1)`, `r_r1 x r_r2` (eq 8; the print leaves out the
    /// normalization); `R_l = R_r R` (eq 7).
    fn from(extrinsics: &Extrinsics<T>) -> Self {
        let r1 = -extrinsics.translation().into_inner();
        let r2 = Vector3::z().cross(&r1).normalize();
        let r3 = r1.cross(&r2);
        let rows = Matrix3::from_columns(&[r1, r2, r3]).transpose();
        let right = Rotation3::from_matrix_unchecked(rows);
        Self { left: right * extrinsics.rotation(), right }
    }
}

impl<T: Scalar> RectifyingRotations<T> {
    /// `R_l`, left camera frame to rectified frame.
    pub fn left(&self) -> &Rotation3<T> {
        &self.left
    }

    /// `R_r`, right camera frame to rectified frame.
    pub fn right(&self) -> &Rotation3<T> {
        &self.right
    }

    /// `R = R_r^T R_l`, `t = -r_r1` (eq 7).
    ///
    /// # Errors
    /// [`ExtrinsicsError::AlongOpticalAxis`] if the left camera has turned towards the baseline.
    pub fn extrinsics(&self) -> Result<Extrinsics<T>, ExtrinsicsError> {
        let m = self.right.matrix();
        let t = Vector3::new(-m.m11, -m.m12, -m.m13);
        Extrinsics::try_new((self.right.inverse() * self.left).matrix(), &t)
    }

    /// Both rotations after a step of the five unknowns (left perturbations, eq 19).
    ///
    /// * `rotation`: turn of `R` in the rectified frame, rad; it moves `R_l` alone.
    /// * `baseline`: turn of both views about the rectified y and z axes, rad; it moves `t` by
    ///   `(0, baseline_z, -baseline_y)` in the rectified frame.
    ///
    /// `None` if the step leaves the range in which the gauge is defined.
    pub(crate) fn stepped(&self, rotation: &Vector3<T>, baseline: &Vector2<T>) -> Option<Self> {
        let common = Vector3::new(baseline.y * self.gauge_slope(), baseline.x, baseline.y);
        Self {
            left: so3::left_update(&(rotation + common), &self.left),
            right: so3::left_update(&common, &self.right),
        }
        .regauged()
    }

    /// Turn about the baseline that keeps eq 8 when both views turn by 1 about the rectified z.
    pub(crate) fn gauge_slope(&self) -> T {
        let m = self.right.matrix();
        m.m13 / m.m33
    }

    /// Turns both views about the baseline until `r_r2 . i_3 = 0` holds exactly.
    fn regauged(&self) -> Option<Self> {
        let m = self.right.matrix();
        let lateral = (m.m23 * m.m23 + m.m33 * m.m33).sqrt();
        // Not `<`: a NaN must fail this test.
        if !(lateral >= T::lit(MIN_LATERAL)) {
            return None;
        }
        let (cos, sin) = (m.m33 / lateral, m.m23 / lateral);
        let (zero, one) = (T::ZERO, T::ONE);
        let turn = Matrix3::new(one, zero, zero, zero, cos, -sin, zero, sin, cos);
        let turned = |r: &Rotation3<T>| Rotation3::from_matrix_unchecked(turn * r.matrix());
        Some(Self { left: turned(&self.left), right: turned(&self.right) })
    }
}
