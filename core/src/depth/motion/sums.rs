//! A motion, the equations of one tracked match at it, and their sums over all matches.
//!
//! A match gives three equations in `(u, v, d)`: column, row and disparity in the second pair. The derivative of
//! `(u, v, d)` by a point `w` in the frame of the second pair is `Q w / z`, where `Q` has the rows `(1, 0, -u)`,
//! `(0, 1, -v)`, `(0, 0, -d)`. So the derivative by the translation is `d Q`, and the derivative by the rotation is
//! `-Q [k]x` with the turned ray `k`, divided by `z`. The sums need only the symmetric matrix `Q^T W Q` with the inverse
//! `W` of the covariance, and its products with `k`.

use nalgebra::{Rotation3, Vector3};

use crate::batch::correspondence::RayPair;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::RayChange;
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3;
use crate::scalar::Scalar;
use crate::thresholds::{
    BEHIND_INFINITY, MAX_TRACKED, MIN_DEPTH, MOTION_GATE, MOTION_INLIERS, MOTION_TURN_RAD,
};

/// Unknowns: rotation (3), translation (3), turn of the mount.
pub(super) const UNKNOWNS: usize = 7;
/// Number of columns of an equation: its unknowns, then its residual.
pub(super) const COLUMNS: usize = UNKNOWNS + 1;

/// Motion of the rig between two pairs, and turn of the mount from the pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion<T: Scalar> {
    rotation: Rotation3<T>,
    /// Translation in baselines.
    translation: [T; 3],
    /// Turn of the mount, rad.
    pub(super) turn: T,
}

impl<T: Scalar> Motion<T> {
    pub(super) const NONE: Self = Self {
        rotation: *Extrinsics::SIDE_BY_SIDE.rotation(),
        translation: [T::ZERO; 3],
        turn: T::ZERO,
    };

    /// Moves by a step; `None` if the rotation is not finite.
    pub(super) fn take(&mut self, step: &[T; UNKNOWNS]) -> Option<()> {
        let [a, b, c, x, y, z, turn] = *step;
        let turned = so3::exp(&Vector3::new(a, b, c))?;
        let rotation = so3::product(turned.matrix(), self.rotation.matrix());
        self.rotation = Rotation3::from_matrix_unchecked(rotation);
        let [t_x, t_y, t_z] = self.translation;
        self.translation = [t_x + x, t_y + y, t_z + z];
        self.turn += turn;
        Some(())
    }
}

/// Pose of the rectified frame, change of right rays to the cameras that the pose belongs to, and standard deviation of
/// a coordinate at unit depth.
pub(crate) struct Views<'a, T: Scalar> {
    pub(crate) pose: &'a RectifyingRotations<T>,
    pub(crate) change: RayChange<T>,
    pub(crate) noise: T,
}

/// A rectified match: left ray of unit depth, and disparity (left column minus right column).
struct View<T> {
    ray: [T; 2],
    disparity: T,
}

impl<T: Scalar> Views<'_, T> {
    /// Returns the rotation of the left camera into the rectified frame after a turn of the mount, rad; `None` if the
    /// turn is not finite.
    fn left_after(&self, turn: T) -> Option<Rotation3<T>> {
        let turn = so3::exp(&Vector3::new(T::ZERO, turn, T::ZERO))?;
        let left = so3::product(turn.matrix(), self.pose.left().matrix());
        Some(Rotation3::from_matrix_unchecked(left))
    }

    /// Returns the rectified match; `None` if a ray has a rectified depth below [`MIN_DEPTH`].
    ///
    /// * `left`: rotation of the left camera into the rectified frame, after the turn of the mount.
    #[inline(always)]
    fn of(&self, left: &Rotation3<T>, pair: &RayPair<T>) -> Option<View<T>> {
        let [x_a, y_a, z_a] = turned(left, pair.left());
        let [x_b, _, z_b] = turned(self.pose.right(), self.change.of(pair.right).into());
        let least = T::lit(MIN_DEPTH);
        let over = T::ONE / z_a;
        let ray @ [x, _] = [x_a * over, y_a * over];
        (z_a >= least && z_b >= least).then(|| View { ray, disparity: x - x_b / z_b })
    }
}

impl<T: Scalar> View<T> {
    /// Returns the derivatives of column, row and disparity by a turn of the mount. The right ray stays.
    #[inline(always)]
    fn by_turn_of_mount(&self) -> [T; 3] {
        let [x, y] = self.ray;
        let along = T::ONE + x * x;
        [along, x * y, along]
    }
}

/// The three equations of a tracked match at a motion.
struct Equations<T> {
    /// `k`: ray of the first pair, turned by the motion, divided by the depth `z` in the second pair.
    turned: [T; 3],
    /// Predicted column, row and disparity: `u`, `v`, `d`.
    predicted: [T; 3],
    by_turn_of_mount: [T; 3],
    off: [T; 3],
    /// Covariance of `off` in units of the variance of a coordinate.
    covariance: Symmetric3<T>,
}

impl<T: Scalar> Equations<T> {
    /// Returns the equations; `None` if the point is behind the left camera of the second pair, or behind infinity by
    /// more than [`BEHIND_INFINITY`] times the noise.
    #[inline(always)]
    fn of(motion: &Motion<T>, one: &View<T>, two: &View<T>, noise: T) -> Option<Self> {
        let depth = one.disparity;
        let [x, y, z] = turned(&motion.rotation, one.ray);
        let [t_x, t_y, t_z] = motion.translation;
        let ahead = z + t_z * depth;
        if !(ahead > T::lit(MIN_DEPTH) && depth > -noise * T::lit(BEHIND_INFINITY)) {
            return None;
        }
        let over = T::ONE / ahead;
        let [u, v, d] = [(x + t_x * depth) * over, (y + t_y * depth) * over, depth * over];
        // Derivatives by the inverse depth, by the column and by the row in the first pair. An error of a left column
        // changes the disparity, too.
        let by = |[x, y, z]: [T; 3]| [(x - u * z) * over, (y - v * z) * over, -d * z * over];
        let [b_x, b_y, b_z] = by(motion.translation);
        let by_depth @ [b_x, b_y, b_z] = [b_x, b_y, b_z + over];
        let m = motion.rotation.matrix();
        let [c_x, c_y, c_z] = by([m.m11, m.m21, m.m31]);
        let by_column @ [c_x, c_y, c_z] = [b_x + c_x, b_y + c_y, b_z + c_z];
        let by_row @ [r_x, r_y, r_z] = by([m.m12, m.m22, m.m32]);
        let mut covariance = Symmetric3::of_view();
        covariance.add_outer(by_column);
        covariance.add_outer(by_row);
        covariance.add_outer(by_depth);
        let ([along, across, _], of_two) = (one.by_turn_of_mount(), two.by_turn_of_mount());
        let of_one =
            [c_x * along + r_x * across, c_y * along + r_y * across, c_z * along + r_z * across];
        let [u_2, v_2] = two.ray;
        Some(Self {
            turned: [x * over, y * over, z * over],
            predicted: [u, v, d],
            by_turn_of_mount: difference(of_one, of_two),
            off: difference([u_2, v_2, two.disparity], [u, v, d]),
            covariance,
        })
    }
}

/// Sums over the tracked matches.
pub(super) struct Sums<T> {
    /// Normal equations, each row with its right-hand side. Nothing left of the diagonal is read.
    pub(super) rows: [[T; COLUMNS]; UNKNOWNS],
    /// Number of inliers, and number of all matches read.
    inliers: [u32; 2],
    /// Sum of the squared residuals of the inliers over their variances.
    squared: T,
}

impl<T: Scalar> Sums<T> {
    /// Returns the sums over the tracked matches at a motion; `None` if the turn of the mount is not finite.
    ///
    /// * `scale`: scale of the loss, in standard deviations.
    #[inline(never)]
    pub(super) fn over(
        motion: &Motion<T>,
        views: &Views<'_, T>,
        tracked: &[[RayPair<T>; 2]],
        scale: T,
    ) -> Option<Self> {
        let left = &views.left_after(motion.turn)?;
        let mut sums = Self::of_prior(motion.turn);
        let precision = T::ONE / (views.noise * views.noise);
        let of_loss = T::ONE / (T::lit(MOTION_GATE) * scale * scale);
        // The matches that are read are spread over the whole list, because a tracker may sort it by column.
        let step = tracked.len().div_ceil(MAX_TRACKED).max(1);
        for [one, two] in tracked.iter().step_by(step) {
            let [_, all] = &mut sums.inliers;
            *all = all.saturating_add(1);
            let both = views.of(left, one).zip(views.of(left, two));
            let of = both.and_then(|(one, two)| Equations::of(motion, &one, &two, views.noise));
            if let Some(equations) = of {
                sums.add(&equations, precision, of_loss);
            }
        }
        Some(sums)
    }

    /// Returns the sums before the first match: damping for the rotation and the translation; a prior for the turn of
    /// the mount, because no mount turns by more than a few degrees.
    fn of_prior(turn: T) -> Self {
        let mut rows = [[T::ZERO; COLUMNS]; UNKNOWNS];
        for (i, row) in rows.iter_mut().enumerate() {
            row.iter_mut().skip(i).take(1).for_each(|own| *own = T::ONE);
        }
        let prior = T::ONE / T::lit(MOTION_TURN_RAD * MOTION_TURN_RAD);
        let [.., [.., own, right]] = &mut rows;
        (*own, *right) = (prior, -prior * turn);
        Self { rows, inliers: [0; 2], squared: T::ZERO }
    }

    /// Adds the equations of a match, with the weight of Geman-McClure.
    ///
    /// * `precision`: inverse of the variance of a coordinate.
    /// * `of_loss`: inverse of the squared residual at which the weight is 1/4.
    #[inline(always)]
    fn add(&mut self, of: &Equations<T>, precision: T, of_loss: T) {
        let Some(inverse) = of.covariance.inverse(precision) else { return };
        let off = inverse.times(of.off);
        let squared = dot(of.off, off);
        // A covariance that rounding has made indefinite.
        if !(squared >= T::ZERO) {
            return;
        }
        if squared <= T::lit(MOTION_GATE) {
            let [inliers, _] = &mut self.inliers;
            *inliers = inliers.saturating_add(1);
            self.squared += squared;
        }
        let root = T::ONE / (T::ONE + squared * of_loss);
        let weight = root * root;
        let inverse = inverse.scaled(weight);
        let off = off.map(|x| x * weight);
        let [u, v, d] = of.predicted;
        // `Q^T W Q`, column by column.
        let [last_x, last_y, last_z] = inverse.times(of.predicted).map(|x| -x);
        let last = -(u * last_x + v * last_y + d * last_z);
        let by_q = |w: [T; 3]| {
            let [x, y, _] = w;
            [x, y, -dot(of.predicted, w)]
        };
        let [c_1, c_2, c_3] = [
            [inverse.xx, inverse.xy, last_x],
            [inverse.xy, inverse.yy, last_y],
            [last_x, last_y, last],
        ];
        let of_mount = inverse.times(of.by_turn_of_mount);
        let [mount, right] = [by_q(of_mount), by_q(off)];
        let k = of.turned;
        let [[a_11, a_21, a_31], [a_12, a_22, a_32], [a_13, a_23, a_33]] =
            [cross(k, c_1), cross(k, c_2), cross(k, c_3)];
        let [k_mount, k_right] = [cross(k, mount), cross(k, right)];
        let [r_1, r_2, r_3, t_1, t_2, t_3, own] = &mut self.rows;
        let of_rotation = [[a_11, a_12, a_13], [a_21, a_22, a_23], [a_31, a_32, a_33]];
        let both = k_mount.into_iter().zip(k_right);
        for ((row, a), (mount, right)) in [r_1, r_2, r_3].into_iter().zip(of_rotation).zip(both) {
            let ([x, y, z], [p, q, r]) = (cross(k, a), a);
            accumulate(row, [x, y, z, d * p, d * q, d * r, mount, right]);
        }
        let both = mount.into_iter().zip(right);
        for ((row, c), (mount, right)) in [t_1, t_2, t_3].into_iter().zip([c_1, c_2, c_3]).zip(both)
        {
            let [_, _, _, rest @ ..] = row;
            let [x, y, z] = c.map(|c| d * d * c);
            accumulate(rest, [x, y, z, d * mount, d * right]);
        }
        let [.., last, right] = own;
        *last += dot(of.by_turn_of_mount, of_mount);
        *right += dot(of.by_turn_of_mount, off);
    }

    /// Returns the scatter of the inliers, at least 1. `None` if they are too few of all matches read.
    pub(super) fn scatter(&self) -> Option<T> {
        let [inliers, all] = self.inliers.map(T::count);
        let freedom = (inliers * T::lit(3.0) - T::lit(7.0)).max(T::ONE);
        (inliers >= T::lit(MOTION_INLIERS) * all).then(|| (self.squared / freedom).max(T::ONE))
    }
}

/// Adds `terms` to `sums`.
#[inline(always)]
fn accumulate<T: Scalar, const K: usize>(sums: &mut [T; K], terms: [T; K]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}

/// Returns a ray of unit depth after a rotation. The product is written out, because the generic product is a loop over
/// slices at opt-level "s".
#[inline(always)]
fn turned<T: Scalar>(by: &Rotation3<T>, [x, y]: [T; 2]) -> [T; 3] {
    let m = by.matrix();
    [
        m.m11 * x + (m.m12 * y + m.m13),
        m.m21 * x + (m.m22 * y + m.m23),
        m.m31 * x + (m.m32 * y + m.m33),
    ]
}

#[inline(always)]
fn dot<T: Scalar>([a, b, c]: [T; 3], [x, y, z]: [T; 3]) -> T {
    a * x + b * y + c * z
}

#[inline(always)]
fn difference<T: Scalar>([a, b, c]: [T; 3], [x, y, z]: [T; 3]) -> [T; 3] {
    [a - x, b - y, c - z]
}

#[inline(always)]
fn cross<T: Scalar>([a, b, c]: [T; 3], [x, y, z]: [T; 3]) -> [T; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// A symmetric matrix.
#[derive(Debug, Clone, Copy)]
struct Symmetric3<T> {
    xx: T,
    xy: T,
    xz: T,
    yy: T,
    yz: T,
    zz: T,
}

impl<T: Scalar> Symmetric3<T> {
    /// Covariance of column, row and disparity of a view in units of the variance of a coordinate. The disparity has
    /// the noise of both columns.
    fn of_view() -> Self {
        let (one, zero) = (T::ONE, T::ZERO);
        Self { xx: one, xy: zero, xz: one, yy: one, yz: zero, zz: one + one }
    }

    fn add_outer(&mut self, [x, y, z]: [T; 3]) {
        self.xx += x * x;
        self.xy += x * y;
        self.xz += x * z;
        self.yy += y * y;
        self.yz += y * z;
        self.zz += z * z;
    }

    fn scaled(&self, by: T) -> Self {
        let Self { xx, xy, xz, yy, yz, zz } = *self;
        Self { xx: xx * by, xy: xy * by, xz: xz * by, yy: yy * by, yz: yz * by, zz: zz * by }
    }

    fn times(&self, v: [T; 3]) -> [T; 3] {
        let Self { xx, xy, xz, yy, yz, zz } = *self;
        [dot([xx, xy, xz], v), dot([xy, yy, yz], v), dot([xz, yz, zz], v)]
    }

    /// Returns `by` times the inverse, by cofactors; `None` unless the determinant is positive.
    fn inverse(&self, by: T) -> Option<Self> {
        let Self { xx, xy, xz, yy, yz, zz } = *self;
        let of = Self {
            xx: yy * zz - yz * yz,
            xy: xz * yz - xy * zz,
            xz: xy * yz - xz * yy,
            yy: xx * zz - xz * xz,
            yz: xy * xz - xx * yz,
            zz: xx * yy - xy * xy,
        };
        let determinant = xx * of.xx + xy * of.xy + xz * of.xz;
        (determinant > T::ZERO).then(|| of.scaled(by / determinant))
    }
}

#[cfg(test)]
mod tests;
