//! The two rectifying rotations, and the extrinsics they stand for (eqs 6-8).

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3, Vector5};

use super::extrinsics::Extrinsics;
use super::so3;
use crate::codec::{Reader, Writer};
use crate::error::{ExtrinsicsError, RestoreError};
use crate::scalar::Scalar;
use crate::thresholds::{MAX_STEP_RAD, MIN_LATERAL};

/// What `r_r2 . i_3` of a recorded pose may be off from 0.
const ON_GAUGE: f64 = 1e-4;

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

impl<T: Scalar> core::fmt::Display for RectifyingRotations<T> {
    /// Both as rotation vectors, rad.
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
    /// Of [`Extrinsics::SIDE_BY_SIDE`].
    pub(crate) const SIDE_BY_SIDE: Self = {
        let identity = *Extrinsics::SIDE_BY_SIDE.rotation();
        Self { left: identity, right: identity }
    };

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
    /// `None` if the step turns by more than 1.5 rad or leaves the range in which the gauge is defined.
    #[inline(never)]
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

    /// The five unknowns that lead from this pose to another, to first order: turn of `R` about the
    /// rectified x, y, z, then of the baseline about y and z, rad.
    #[must_use]
    #[inline(never)]
    pub fn unknowns_to(&self, other: &Self) -> Vector5<T> {
        let turned =
            |a: &Rotation3<T>, b: &Rotation3<T>| so3::product(&a.matrix().transpose(), b.matrix());
        let turn =
            so3::product(&turned(&other.right, &other.left), &turned(&self.left, &self.right));
        let w = self.right * so3::log(&Rotation3::from_matrix_unchecked(turn));
        let t = -(self.right.matrix() * other.right.matrix().row(0).transpose());
        // A baseline across the other is as far as it goes.
        let along = (-t.x).max(T::lit(MIN_LATERAL));
        Vector5::new(w.x, w.y, w.z, -t.z / along, t.y / along)
    }

    /// After a step of all five unknowns.
    pub(crate) fn stepped_by(&self, d: &Vector5<T>) -> Option<Self> {
        self.stepped(&Vector3::new(d.x, d.y, d.z), &Vector2::new(d.w, d.a))
    }

    pub(crate) fn write(&self, to: &mut Writer<'_>) {
        to.numbers(self.left.matrix());
        to.numbers(self.right.matrix());
    }

    pub(crate) fn read(from: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let read = Self { left: so3::read(from)?, right: so3::read(from)? };
        let off_gauge = read.right.matrix().m23.abs() > T::lit(ON_GAUGE);
        if off_gauge || read.extrinsics().is_err() {
            return Err(RestoreError::Absurd);
        }
        Ok(read)
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

    /// Rectifying rotations of a rig turned by a rotation vector, rad, with a baseline `(-1, y, z)`.
    pub(crate) fn pose(rotation: [f64; 3], t: [f64; 2]) -> RectifyingRotations<f64> {
        RectifyingRotations::from(&extrinsics(rotation, t))
    }

    fn extrinsics(rotation: [f64; 3], t: [f64; 2]) -> Extrinsics<f64> {
        let r = so3::exp(&Vector3::from(rotation)).unwrap();
        let [y, z] = t;
        Extrinsics::try_new(r.matrix(), &Vector3::new(-1.0, y, z)).unwrap()
    }

    proptest! {
        #[test]
        fn extrinsics_go_to_rotations_and_back(
            rotation in [-0.4..0.4, -0.4..0.4, -0.4..0.4], t in [-0.7..0.7, -0.7..0.7],
        ) {
            let truth = extrinsics(rotation, t);
            let rotations = RectifyingRotations::from(&truth);
            let back = Deviation::between(&rotations.extrinsics().unwrap(), &truth);
            prop_assert!(back.translation < 1e-14 && back.rotation < 1e-14, "{back:?}");
        }

        #[test]
        fn rows_coincide_and_the_gauge_holds(
            rotation in [-0.4..0.4, -0.4..0.4, -0.4..0.4], t in [-0.7..0.7, -0.7..0.7],
            p in [-1.0..1.0, -1.0..1.0, 3.0..80.0],
        ) {
            let truth = extrinsics(rotation, t);
            let rotations = RectifyingRotations::from(&truth);
            let p_l = Vector3::from(p);
            let p_r = truth.rotation() * p_l + truth.translation().into_inner();
            let (l, r) = (rotations.left() * p_l, rotations.right() * p_r);
            // p_l' = p_r' + i_1 (eq 6).
            prop_assert!((l - r - Vector3::x()).norm() < 1e-12);
            prop_assert!(rotations.right().matrix().m23.abs() < 1e-15);
            prop_assert!(rotations.right().matrix().m33 > 0.0);
        }

        #[test]
        fn a_step_moves_rotation_and_baseline_as_documented_and_keeps_the_gauge(
            rotation in [-0.4..0.4, -0.4..0.4, -0.4..0.4], t in [-0.5..0.5, -0.5..0.5],
            step in [-1e-6..1e-6, -1e-6..1e-6, -1e-6..1e-6], turn in [-1e-6..1e-6, -1e-6..1e-6],
        ) {
            let before = RectifyingRotations::from(&extrinsics(rotation, t));
            let after = before.stepped(&Vector3::from(step), &Vector2::from(turn)).unwrap();
            let [old, new] = [before, after].map(|r| r.extrinsics().unwrap());
            let in_rectified = before.right();
            let moved = new.rotation() * old.rotation().inverse();
            let got = in_rectified * so3::log(&moved);
            prop_assert!((got - Vector3::from(step)).norm() < 1e-11);
            let shift = in_rectified * (new.translation().into_inner() - old.translation().into_inner());
            let [y, z] = turn;
            prop_assert!((shift - Vector3::new(0.0, z, -y)).norm() < 1e-11);
            prop_assert!(after.right().matrix().m23.abs() < 1e-15);
        }

        #[test]
        fn unknowns_lead_where_a_step_went_but_for_the_square_of_its_length(
            rotation in [-0.4..0.4, -0.4..0.4, -0.4..0.4], t in [-0.5..0.5, -0.5..0.5],
            step in [-1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0], size in 1e-5..0.05,
        ) {
            let before = RectifyingRotations::from(&extrinsics(rotation, t));
            let d = Vector5::from(step) * size;
            let found = before.unknowns_to(&before.stepped_by(&d).unwrap());
            // 1e-15: rounding.
            prop_assert!((found - d).norm() <= d.norm_squared() + 1e-15, "{found} {d}");
            prop_assert!(before.unknowns_to(&before).norm() < 1e-15);
        }

        #[test]
        fn steps_along_the_unknowns_close_in_on_any_other_pose(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            goal in [-0.2..0.2, -0.2..0.2, -0.2..0.2], goal_t in [-0.3..0.3, -0.3..0.3],
        ) {
            let goal = RectifyingRotations::from(&extrinsics(goal, goal_t));
            let mut pose = RectifyingRotations::from(&extrinsics(rotation, t));
            for _ in 0..6 {
                pose = pose.stepped_by(&pose.unknowns_to(&goal)).unwrap();
            }
            prop_assert!(pose.unknowns_to(&goal).norm() < 1e-13);
        }
    }

    #[test]
    fn the_baseline_points_from_right_to_left_for_a_plain_side_by_side_rig() {
        let plain = RectifyingRotations::from(&Extrinsics::<f64>::SIDE_BY_SIDE);
        assert_eq!(plain.left().matrix(), &Matrix3::identity());
        assert_eq!(plain.right().matrix(), &Matrix3::identity());
        let t = plain.extrinsics().unwrap().translation().into_inner();
        assert_eq!(t, -Vector3::x());
    }

    #[test]
    fn a_baseline_along_an_optical_axis_is_refused() {
        let refused = |r: &Rotation3<f64>, t: [f64; 3]| {
            Extrinsics::try_new(r.matrix(), &Vector3::from(t)).unwrap_err()
        };
        let identity = Rotation3::identity();
        let sideways = so3::exp(&Vector3::new(0.0, 1.57, 0.0)).unwrap();
        assert_eq!(refused(&identity, [-0.05, 0.0, 1.0]), ExtrinsicsError::AlongOpticalAxis);
        assert_eq!(refused(&sideways, [-1.0, 0.0, 0.0]), ExtrinsicsError::AlongOpticalAxis);
        assert_eq!(refused(&identity, [0.0; 3]), ExtrinsicsError::NoDirection);
        assert_eq!(refused(&identity, [f64::NAN, 0.0, 0.0]), ExtrinsicsError::NoDirection);
        assert_eq!(refused(&identity, [0.0, f64::INFINITY, 0.0]), ExtrinsicsError::NoDirection);
    }

    #[test]
    fn tiny_and_huge_baselines_keep_their_direction_in_f32() {
        for scale in [1e-38_f32, 1e38] {
            let t = Vector3::new(-3.0, 0.0, 1.5) * scale;
            let e = Extrinsics::try_new(&Matrix3::identity(), &t).unwrap();
            let miss = e.translation().into_inner() - Vector3::new(-2.0, 0.0, 1.0) / 5.0_f32.sqrt();
            assert!(miss.norm() < 2e-7);
        }
    }

    #[test]
    fn the_gauge_slope_keeps_the_gauge_to_first_order() {
        let before = RectifyingRotations::from(&extrinsics([0.1, -0.2, 0.3], [0.3, -0.4]));
        let off = |h: f64| {
            let turn = Vector3::new(before.gauge_slope() * h, 0.0, h);
            (so3::exp(&turn).unwrap() * before.right()).matrix().m23
        };
        let slope = (off(1e-5) - off(-1e-5)) / 2e-5;
        assert!(slope.abs() < 1e-9 && before.gauge_slope().abs() > 0.1, "{slope}");
    }
}
