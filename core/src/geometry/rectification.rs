//! The two rectifying rotations, and their conversion from and to extrinsics (eqs 6-8).
//!
//! The rotations have six parameters, the extrinsics five: a common rotation about the baseline leaves all row offsets
//! as they are. The gauge `r_r2 . i_3 = 0` (eq 8) fixes this rotation.

use nalgebra::{ArrayStorage, Matrix3, Rotation3, Vector2, Vector3, Vector5};

use super::extrinsics::Extrinsics;
use super::so3;
use crate::error::ExtrinsicsError;
use crate::scalar::Scalar;
use crate::thresholds::{MAX_STEP_RAD, MIN_LATERAL};

/// `R_l`, `R_r` with `p_l' = R_l p_l`, `p_r' = R_r p_r`: corresponding rays have equal rows.
///
/// Invariant: the gauge of eq 8, `r_r2 . i_3 = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectifyingRotations<T: Scalar> {
    left: Rotation3<T>,
    right: Rotation3<T>,
}

impl<T: Scalar> From<&Extrinsics<T>> for RectifyingRotations<T> {
    /// Returns `R_r` with the rows `-t`, `normalize(i_3 x r_r1)`, `r_r1 x r_r2` (eq 8; the paper omits the
    /// normalisation), and `R_l = R_r R` (eq 7).
    #[inline(never)]
    fn from(extrinsics: &Extrinsics<T>) -> Self {
        let r1 = -extrinsics.translation().into_inner();
        let r2 = Vector3::z().cross(&r1).normalize();
        let r3 = r1.cross(&r2);
        let rows = Matrix3::from_columns(&[r1, r2, r3]).transpose();
        let right = Rotation3::from_matrix_unchecked(rows);
        let left = so3::product(&rows, extrinsics.rotation().matrix());
        Self { left: Rotation3::from_matrix_unchecked(left), right }
    }
}

impl<T: Scalar> core::fmt::Display for RectifyingRotations<T> {
    /// Writes both rotations as rotation vectors, rad.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let [[[a, b, c]], [[x, y, z]]] = [self.left, self.right].map(|r| so3::log(&r).data.0);
        write!(f, "R_l {a:.5} {b:.5} {c:.5} rad, R_r {x:.5} {y:.5} {z:.5} rad")
    }
}

#[cfg(feature = "defmt")]
impl<T: Scalar + defmt::Format> defmt::Format for RectifyingRotations<T> {
    fn format(&self, f: defmt::Formatter<'_>) {
        let [[left], [right]] = [self.left, self.right].map(|r| so3::log(&r).data.0);
        defmt::write!(f, "R_l {} rad, R_r {} rad", left, right);
    }
}

impl<T: Scalar> RectifyingRotations<T> {
    /// Both rotations are the identity: the rectification of [`Extrinsics::SIDE_BY_SIDE`].
    pub(crate) const SIDE_BY_SIDE: Self = {
        let identity = *Extrinsics::SIDE_BY_SIDE.rotation();
        Self { left: identity, right: identity }
    };

    /// Placeholder, which is overwritten before it is read. All elements are 0, because other initial values would take
    /// a table in flash.
    pub(crate) const UNSET: Self = {
        let zeros = Matrix3::from_array_storage(ArrayStorage([[T::ZERO; 3]; 3]));
        let rotation = Rotation3::from_matrix_unchecked(zeros);
        Self { left: rotation, right: rotation }
    };

    /// Returns `R_l`, left camera frame to rectified frame.
    pub fn left(&self) -> &Rotation3<T> {
        &self.left
    }

    /// Returns `R_r`, right camera frame to rectified frame.
    pub fn right(&self) -> &Rotation3<T> {
        &self.right
    }

    /// Returns `R = R_r^T R_l`, `t = -r_r1` (eq 7).
    ///
    /// # Errors
    /// [`ExtrinsicsError::AlongOpticalAxis`]: the baseline is within 6 degrees of an optical axis.
    pub fn extrinsics(&self) -> Result<Extrinsics<T>, ExtrinsicsError> {
        let m = self.right.matrix();
        let t = Vector3::new(-m.m11, -m.m12, -m.m13);
        Extrinsics::try_new(&so3::product(&m.transpose(), self.left.matrix()), &t)
    }

    /// Returns both rotations after a step of the five unknowns (left perturbations, eq 19).
    ///
    /// * `rotation`: rotation vector of `R` in the rectified frame, rad; it changes `R_l` alone.
    /// * `baseline`: rotation of both views about the rectified y and z axes, rad; it moves `t` by
    ///   `(0, baseline_z, -baseline_y)` in the rectified frame.
    ///
    /// `None` if a view turns by more than 1.5 rad, or if the step moves the baseline to within 6 degrees of the right
    /// optical axis.
    pub(crate) fn stepped(&self, rotation: &Vector3<T>, baseline: &Vector2<T>) -> Option<Self> {
        let right = Vector3::new(baseline.y * self.gauge_slope(), baseline.x, baseline.y);
        let left = rotation + right;
        let longest = left.norm_squared().max(right.norm_squared());
        // Not `>`: a NaN must fail this test.
        if !(longest <= T::lit(MAX_STEP_RAD * MAX_STEP_RAD)) {
            return None;
        }
        Self {
            left: so3::left_update(&left, &self.left),
            right: so3::left_update(&right, &self.right),
        }
        .regauged()
    }

    /// Returns the five unknowns that lead from this pose to another, rad, to first order: rotation of `R` about the
    /// rectified x, y, z, then of the baseline about y and z.
    ///
    /// This is the inverse of a step by these unknowns, up to the square of the step length. The magnitude of a
    /// component is at most pi for the rotation, and at most 10 for the baseline. The value 10 occurs if the other
    /// baseline is perpendicular to this one.
    #[must_use]
    pub fn unknowns_to(&self, other: &Self) -> Vector5<T> {
        let turned =
            |a: &Rotation3<T>, b: &Rotation3<T>| so3::product(&a.matrix().transpose(), b.matrix());
        let turn =
            so3::product(&turned(&other.right, &other.left), &turned(&self.left, &self.right));
        let w = self.right * so3::log(&Rotation3::from_matrix_unchecked(turn));
        let t = -(self.right.matrix() * other.right.matrix().row(0).transpose());
        // Bounded, so that the quotients are finite for a baseline perpendicular to this one.
        let along = (-t.x).max(T::lit(MIN_LATERAL));
        Vector5::new(w.x, w.y, w.z, -t.z / along, t.y / along)
    }

    /// Returns [`Self::stepped`] by all five unknowns, rad: `rotation`, then `baseline`.
    pub(crate) fn stepped_by(&self, d: &Vector5<T>) -> Option<Self> {
        self.stepped(&Vector3::new(d.x, d.y, d.z), &Vector2::new(d.w, d.a))
    }

    /// Returns the gauge slope `r_13 / r_33` of `R_r`, dimensionless. It is the rotation about the baseline, per
    /// rotation of both views about the rectified z axis, that keeps the gauge to first order.
    pub(crate) fn gauge_slope(&self) -> T {
        let m = self.right.matrix();
        m.m13 / m.m33
    }

    /// Rotates both views about the baseline so that `r_r2 . i_3 = 0` holds up to rounding. `None` if the baseline is
    /// within 6 degrees of the right optical axis, along which the gauge is not defined.
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
        let turned =
            |r: &Rotation3<T>| Rotation3::from_matrix_unchecked(so3::product(&turn, r.matrix()));
        Some(Self { left: turned(&self.left), right: turned(&self.right) })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geometry::metrics::Deviation;
    use proptest::prelude::*;

    /// Returns the rectifying rotations of a rig with a rotation vector, rad, and a baseline `(-1, y, z)`.
    pub(crate) fn pose(rotation: [f64; 3], t: [f64; 2]) -> RectifyingRotations<f64> {
        RectifyingRotations::from(&extrinsics(rotation, t))
    }

    fn extrinsics(rotation: [f64; 3], t: [f64; 2]) -> Extrinsics<f64> {
        let r = so3::exp(&Vector3::from(rotation)).unwrap();
        let [y, z] = t;
        Extrinsics::try_new(r.matrix(), &Vector3::new(-1.0, y, z)).unwrap()
    }

    /// Generates rigs turned by up to `turn` rad per axis, with baselines `(-1, y, z)` of `|y|` and `|z|` up to
    /// `slope`.
    fn rigs(turn: f64, slope: f64) -> impl Strategy<Value = Extrinsics<f64>> {
        let [turn, slope] = [turn, slope].map(|limit| move || -limit..limit);
        ([turn(), turn(), turn()], [slope(), slope()]).prop_map(|(r, t)| extrinsics(r, t))
    }

    proptest! {
        #[test]
        fn rows_coincide_in_the_gauge_and_the_rotations_return_the_extrinsics(
            truth in rigs(0.4, 0.7), p in [-1.0..1.0, -1.0..1.0, 3.0..80.0],
        ) {
            let rotations = RectifyingRotations::from(&truth);
            let p_l = Vector3::from(p);
            let p_r = truth.rotation() * p_l + truth.translation().into_inner();
            // p_l' = p_r' + i_1 (eq 6).
            let gap = rotations.left() * p_l - rotations.right() * p_r - Vector3::x();
            prop_assert!(gap.norm() < 1e-12);
            let m = rotations.right().matrix();
            prop_assert!(m.m23.abs() < 1e-15 && m.m33 > 0.0);
            let back = Deviation::between(&rotations.extrinsics().unwrap(), &truth);
            prop_assert!(back.translation < 1e-14 && back.rotation < 1e-14, "{back:?}");
        }

        #[test]
        fn a_step_moves_rotation_and_baseline_as_documented_and_keeps_the_gauge(
            rig in rigs(0.4, 0.5),
            step in [-1e-6..1e-6, -1e-6..1e-6, -1e-6..1e-6], turn in [-1e-6..1e-6, -1e-6..1e-6],
        ) {
            let before = RectifyingRotations::from(&rig);
            let after = before.stepped(&Vector3::from(step), &Vector2::from(turn)).unwrap();
            let [old, new] = [before, after].map(|r| r.extrinsics().unwrap());
            let moved = before.right() * so3::log(&(new.rotation() * old.rotation().inverse()));
            prop_assert!((moved - Vector3::from(step)).norm() < 1e-11);
            let shift = new.translation().into_inner() - old.translation().into_inner();
            let [y, z] = turn;
            prop_assert!((before.right() * shift - Vector3::new(0.0, z, -y)).norm() < 1e-11);
            prop_assert!(after.right().matrix().m23.abs() < 1e-15);
        }

        #[test]
        fn unknowns_match_the_step_up_to_the_square_of_its_length(
            rig in rigs(0.4, 0.5), step in proptest::array::uniform5(-1.0..1.0), size in 1e-5..0.05,
        ) {
            let before = RectifyingRotations::from(&rig);
            let d = Vector5::from(step) * size;
            let found = before.unknowns_to(&before.stepped_by(&d).unwrap());
            // 1e-15 allows for rounding.
            prop_assert!((found - d).norm() <= d.norm_squared() + 1e-15, "{found} {d}");
            prop_assert!(before.unknowns_to(&before).norm() < 1e-15);
        }

        #[test]
        fn steps_along_the_unknowns_converge_to_any_other_pose(
            start in rigs(0.2, 0.3), goal in rigs(0.2, 0.3),
        ) {
            let [start, goal] = [start, goal].map(|rig| RectifyingRotations::from(&rig));
            let step = |pose: RectifyingRotations<_>, _| pose.stepped_by(&pose.unknowns_to(&goal)).unwrap();
            prop_assert!((0..6).fold(start, step).unknowns_to(&goal).norm() < 1e-13);
        }
    }

    #[test]
    fn the_baseline_points_from_right_to_left_for_a_plain_side_by_side_rig() {
        let plain = RectifyingRotations::from(&Extrinsics::<f64>::SIDE_BY_SIDE);
        assert_eq!(plain, RectifyingRotations::SIDE_BY_SIDE);
        assert_eq!(plain.left().matrix(), &Matrix3::identity());
        assert_eq!(plain.extrinsics().unwrap().translation().into_inner(), -Vector3::x());
    }

    #[test]
    fn a_baseline_along_an_optical_axis_or_without_direction_is_refused() {
        let [identity, sideways] =
            [0.0, 1.57].map(|yaw| so3::exp(&Vector3::new(0.0, yaw, 0.0)).unwrap());
        for (r, t, why) in [
            (identity, [-0.05, 0.0, 1.0], ExtrinsicsError::AlongOpticalAxis),
            (sideways, [-1.0, 0.0, 0.0], ExtrinsicsError::AlongOpticalAxis),
            (identity, [0.0; 3], ExtrinsicsError::NoDirection),
            (identity, [f64::NAN, 0.0, 0.0], ExtrinsicsError::NoDirection),
            (identity, [0.0, f64::INFINITY, 0.0], ExtrinsicsError::NoDirection),
        ] {
            assert_eq!(Extrinsics::try_new(r.matrix(), &Vector3::from(t)), Err(why));
        }
    }

    #[test]
    fn tiny_and_huge_baselines_keep_their_direction_in_f32() {
        for scale in [1e-38_f32, 1e38] {
            let t = Vector3::new(-3.0, 0.0, 1.5) * scale;
            let e = Extrinsics::try_new(&Matrix3::identity(), &t).unwrap();
            let error =
                e.translation().into_inner() - Vector3::new(-2.0, 0.0, 1.0) / 5.0_f32.sqrt();
            assert!(error.norm() < 2e-7);
        }
    }

    #[test]
    fn the_gauge_slope_keeps_the_gauge_to_first_order() {
        let before = pose([0.1, -0.2, 0.3], [0.3, -0.4]);
        let off = |h: f64| {
            let turn = Vector3::new(before.gauge_slope() * h, 0.0, h);
            (so3::exp(&turn).unwrap() * before.right()).matrix().m23
        };
        let slope = (off(1e-5) - off(-1e-5)) / 2e-5;
        assert!(slope.abs() < 1e-9 && before.gauge_slope().abs() > 0.1, "{slope}");
    }
}
