//! Witness of rigid motion: with a wrong yaw, near and far points seem to move by different motions (`ESTIMATOR.md`,
//! section 20).
//!
//! A tracked match has four views, two in each pair. The two views in the first pair give a point. The motion of the
//! rig predicts column, row and disparity of this point in the second pair. They are compared with the two views there.
//! The unknowns are the rotation and translation of the rig, and the turn of the mount, which adds nearly the same to
//! all disparities.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::batch::correspondence::RayPair;
use crate::geometry::lens_correction::{LensCorrection, RayChange};
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3;
use crate::scalar::Scalar;
use crate::thresholds::{
    BEHIND_INFINITY, MAX_TRACKED, MIN_DEPTH, MOTION_GATE, MOTION_INLIERS, MOTION_SCALE,
    MOTION_STEPS, MOTION_TURN_RAD,
};

/// Unknowns: rotation (3), translation (3), turn of the mount.
const UNKNOWNS: usize = 7;
/// Number of columns of an equation: its unknowns, then its residual.
const COLUMNS: usize = UNKNOWNS + 1;

/// Unknowns: motion of the rig between two pairs, and turn of the mount from the pose, rad.
#[derive(Debug, Clone, Copy)]
struct Motion<T: Scalar> {
    rotation: Rotation3<T>,
    /// Translation in baselines.
    translation: Vector3<T>,
    turn: T,
}

/// The turn of the mount that the motion of the rig shows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TurnByMotion<T> {
    /// Turn of the mount from the pose, rad.
    pub(crate) turn: T,
    /// Variance of the turn, rad^2.
    pub(crate) variance: T,
}

/// Sums over the tracked matches.
struct Sums<T> {
    /// Normal equations, each row with its right-hand side.
    rows: [[T; COLUMNS]; UNKNOWNS],
    /// Number of inliers, and number of all matches read.
    inliers: [u32; 2],
    /// Sum of the squared residuals of the inliers over their variances.
    squared: T,
}

impl<T: Scalar> TurnByMotion<T> {
    /// Returns the turn of the mount that tracked matches show; `None` if the matches agree on no motion, or if the
    /// equations have no solution.
    ///
    /// * `pose`: rectifying rotations that the row offsets give.
    /// * `correction`: correction of the cameras that the pose belongs to.
    /// * `tracked`: rays of each match in the first and in the second pair, with the factory cameras.
    /// * `noise`: standard deviation of a coordinate at unit depth.
    #[inline(never)]
    pub(crate) fn of(
        pose: &RectifyingRotations<T>,
        correction: &LensCorrection<T>,
        tracked: &[[RayPair<T>; 2]],
        noise: T,
    ) -> Option<Self> {
        let frame = &Frame { pose, change: LensCorrection::NONE.change_to(correction) };
        let mut motion = Motion {
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
            turn: T::ZERO,
        };
        let mut scale = T::lit(MOTION_SCALE);
        for _ in 0..MOTION_STEPS {
            let mut sums = motion.sums(frame, tracked, noise, scale);
            motion = motion.stepped(&solution(&mut sums.rows)?.0)?;
            scale = (scale * T::HALF).max(T::ONE);
        }
        let mut sums = motion.sums(frame, tracked, noise, T::ONE);
        let (_, information) = solution(&mut sums.rows)?;
        let [inliers, all] = sums.inliers;
        let enough = T::count(inliers) >= T::lit(MOTION_INLIERS) * T::count(all);
        let freedom = (T::count(inliers) * T::lit(3.0) - T::count(7)).max(T::ONE);
        let scatter = (sums.squared / freedom).max(T::ONE);
        let found = Self { turn: motion.turn, variance: scatter / information };
        (enough && found.turn.is_finite() && found.variance > T::ZERO).then_some(found)
    }
}

impl<T: Scalar> Motion<T> {
    fn stepped(&self, step: &[T; UNKNOWNS]) -> Option<Self> {
        let [a, b, c, x, y, z, turn] = *step;
        let turned = so3::exp(&Vector3::new(a, b, c))?;
        let rotation = so3::product(turned.matrix(), self.rotation.matrix());
        Some(Self {
            rotation: Rotation3::from_matrix_unchecked(rotation),
            translation: self.translation + Vector3::new(x, y, z),
            turn: self.turn + turn,
        })
    }

    /// Returns the sums over the tracked matches at this motion.
    ///
    /// * `noise`: standard deviation of a coordinate at unit depth.
    /// * `scale`: scale of the loss, in standard deviations.
    fn sums(
        &self,
        frame: &Frame<'_, T>,
        tracked: &[[RayPair<T>; 2]],
        noise: T,
        scale: T,
    ) -> Sums<T> {
        let mut sums =
            Sums { rows: [[T::ZERO; COLUMNS]; UNKNOWNS], inliers: [0; 2], squared: T::ZERO };
        // Damping for the rotation and the translation; a prior for the turn, because no mount turns by more than a few
        // degrees.
        let prior = T::ONE / T::lit(MOTION_TURN_RAD * MOTION_TURN_RAD);
        for (i, row) in sums.rows.iter_mut().enumerate() {
            row.iter_mut().skip(i).take(1).for_each(|own| *own = T::ONE);
        }
        let [.., [.., own, right]] = &mut sums.rows;
        (*own, *right) = (prior, -prior * self.turn);
        // The matches that are read are spread over the whole list, because a tracker may sort it by column.
        let step = tracked.len().div_ceil(MAX_TRACKED).max(1);
        for [before, after] in tracked.iter().step_by(step) {
            let views = frame.view(before).zip(frame.view(after));
            let seen = views.and_then(|(one, two)| self.seen(&one, &two, noise));
            sums.add(seen, scale);
        }
        sums
    }

    /// Returns the three whitened equations of a tracked match. `None` if its point is behind the left camera of the
    /// second pair, or behind infinity by more than [`BEHIND_INFINITY`] times the noise, or if its covariance has no
    /// inverse.
    fn seen(&self, one: &View<T>, two: &View<T>, noise: T) -> Option<[[T; COLUMNS]; 3]> {
        let depth = one.disparity + self.turn * one.slope();
        let turned = self.rotation * one.ray();
        let moved = turned + self.translation * depth;
        let z = moved.z;
        if !(z > T::lit(MIN_DEPTH) && depth > -noise * T::lit(BEHIND_INFINITY)) {
            return None;
        }
        let [u, v, d] = [moved.x / z, moved.y / z, depth / z];
        // Derivatives of (u, v, d) by the moved ray, and by the inverse depth in the first pair.
        let by = |w: &Vector3<T>| Vector3::new(w.x - u * w.z, w.y - v * w.z, -d * w.z) / z;
        let by_depth = by(&self.translation) + Vector3::z() / z;
        let off = Vector3::new(two.x - u, two.y - v, two.disparity + self.turn * two.slope() - d);
        // Noise of the second pair, then of the first pair. An error of a left column changes the disparity, too.
        let mut covariance = Matrix3::new(
            T::ONE,
            T::ZERO,
            T::ONE,
            T::ZERO,
            T::ONE,
            T::ZERO,
            T::ONE,
            T::ZERO,
            T::ONE + T::ONE,
        );
        let [by_column, by_row] =
            [Vector3::x(), Vector3::y()].map(|axis| by(&(self.rotation * axis)));
        for moved in [by_column + by_depth, by_row, by_depth] {
            covariance += moved * moved.transpose();
        }
        let whitening = Whitening::of(&covariance, noise)?;
        let by_turn = |axis: Vector3<T>| whitening.times(&by(&axis.cross(&turned)));
        let by_move = |axis: Vector3<T>| whitening.times(&(by(&axis) * depth));
        let by_yaw = by_depth * one.slope() - Vector3::z() * two.slope();
        let columns = [
            by_turn(Vector3::x()),
            by_turn(Vector3::y()),
            by_turn(Vector3::z()),
            by_move(Vector3::x()),
            by_move(Vector3::y()),
            by_move(Vector3::z()),
            whitening.times(&by_yaw),
            whitening.times(&off),
        ];
        Some([columns.map(|c| c.x), columns.map(|c| c.y), columns.map(|c| c.z)])
    }
}

impl<T: Scalar> Sums<T> {
    fn add(&mut self, seen: Option<[[T; COLUMNS]; 3]>, scale: T) {
        let [inliers, all] = &mut self.inliers;
        *all = all.saturating_add(1);
        let Some(equations) = seen else { return };
        let squared = equations.iter().fold(T::ZERO, |sum, [.., off]| sum + *off * *off);
        let gate = T::lit(MOTION_GATE);
        if squared <= gate {
            *inliers = inliers.saturating_add(1);
            self.squared += squared;
        }
        // Geman-McClure.
        let root = T::ONE / (T::ONE + squared / (gate * scale * scale));
        let weight = root * root;
        for equation in &equations {
            for (row, own) in self.rows.iter_mut().zip(equation) {
                row.iter_mut().zip(equation).for_each(|(sum, x)| *sum += weight * *own * *x);
            }
        }
    }
}

/// Pose of the rectified frame, and the change of right rays to the cameras that the pose belongs to.
struct Frame<'a, T: Scalar> {
    pose: &'a RectifyingRotations<T>,
    change: RayChange<T>,
}

impl<T: Scalar> Frame<'_, T> {
    /// Returns the rectified match; `None` if the point is behind a camera.
    fn view(&self, pair: &RayPair<T>) -> Option<View<T>> {
        let a = self.pose.left() * pair.left.push(T::ONE);
        let b = self.pose.right() * self.change.of(pair.right).push(T::ONE);
        let ahead = a.z > T::EPSILON && b.z > T::EPSILON;
        let [x, y] = [a.x / a.z, a.y / a.z];
        ahead.then(|| View { x, y, disparity: x - b.x / b.z })
    }
}

/// A rectified match.
struct View<T> {
    x: T,
    y: T,
    /// Left column minus right column.
    disparity: T,
}

impl<T: Scalar> View<T> {
    fn ray(&self) -> Vector3<T> {
        Vector3::new(self.x, self.y, T::ONE)
    }

    /// Returns the derivative of the disparity by a turn of the mount.
    fn slope(&self) -> T {
        T::ONE + self.x * self.x
    }
}

/// Inverse of the Cholesky factor of a covariance, by forward substitution.
struct Whitening<T> {
    /// Reciprocals of the diagonal of the factor.
    diagonal: [T; 3],
    /// `l_21`, `l_31`, `l_32`.
    below: [T; 3],
}

impl<T: Scalar> Whitening<T> {
    /// Returns the whitening for the covariance `noise^2 c`; `None` unless `c` is positive definite.
    ///
    /// * `c`: covariance in units of `noise^2`.
    /// * `noise`: standard deviation of a coordinate.
    fn of(c: &Matrix3<T>, noise: T) -> Option<Self> {
        let root = |x: T| Some(x).filter(|x| *x > T::ZERO).map(|x| T::ONE / x.sqrt());
        let a = root(c.m11)?;
        let [l_21, l_31] = [c.m21 * a, c.m31 * a];
        let b = root(c.m22 - l_21 * l_21)?;
        let l_32 = (c.m32 - l_31 * l_21) * b;
        let d = root(c.m33 - l_31 * l_31 - l_32 * l_32)?;
        let below = [l_21, l_31, l_32].map(|l| l * noise);
        Some(Self { diagonal: [a, b, d].map(|x| x / noise), below })
    }

    fn times(&self, v: &Vector3<T>) -> Vector3<T> {
        let ([a, b, d], [l_21, l_31, l_32]) = (self.diagonal, self.below);
        let x = v.x * a;
        let y = (v.y - l_21 * x) * b;
        Vector3::new(x, y, (v.z - l_31 * x - l_32 * y) * d)
    }
}

/// Solves normal equations in place. Returns the solution, and the information on the last unknown with all other
/// unknowns free; `None` if the equations have no solution.
fn solution<T: Scalar>(rows: &mut [[T; COLUMNS]; UNKNOWNS]) -> Option<([T; UNKNOWNS], T)> {
    for i in 0..UNKNOWNS {
        let (above, below) = rows.split_at_mut_checked(i.saturating_add(1))?;
        let pivot_row = above.last()?;
        let pivot = *pivot_row.get(i)?;
        // Not `<=`: a NaN must fail this test.
        if !(pivot > T::ZERO) {
            return None;
        }
        for row in below {
            let factor = *row.get(i)? / pivot;
            row.iter_mut().zip(pivot_row).for_each(|(x, p)| *x -= factor * *p);
        }
    }
    let mut found = [T::ZERO; UNKNOWNS];
    for (i, row) in rows.iter().enumerate().rev() {
        let [coefficients @ .., right] = row;
        let known = coefficients.iter().zip(&found).skip(i.saturating_add(1));
        let rest = known.fold(*right, |rest, (c, x)| rest - *c * *x);
        *found.get_mut(i)? = rest / *coefficients.get(i)?;
    }
    let information = *rows.last()?.get(UNKNOWNS.saturating_sub(1))?;
    Some((found, information))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_equations_are_solved_and_the_last_unknown_is_known_by_its_schur_complement() {
        let place = |i: usize| f64::from(u8::try_from(i).unwrap());
        let h = |i: usize, j: usize| if i == j { 4.0 } else { 1.0 / (1.0 + place(i + j)) };
        let x = [1.0, -2.0, 0.5, 3.0, 0.0, -1.0, 2.0];
        let mut rows = [[0.0; COLUMNS]; UNKNOWNS];
        for (i, row) in rows.iter_mut().enumerate() {
            for j in 0..UNKNOWNS {
                row[j] = h(i, j);
                row[UNKNOWNS] += h(i, j) * x[j];
            }
        }
        let full = nalgebra::SMatrix::<f64, 7, 7>::from_fn(h);
        let (found, information) = solution(&mut rows).unwrap();
        for (a, b) in found.into_iter().zip(x) {
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
        assert!((information - 1.0 / full.try_inverse().unwrap()[(6, 6)]).abs() < 1e-12);
        assert!(solution(&mut [[0.0; COLUMNS]; UNKNOWNS]).is_none());
        assert!(solution(&mut [[f64::NAN; COLUMNS]; UNKNOWNS]).is_none());
    }

    #[test]
    fn whitened_noise_has_unit_covariance() {
        let c = Matrix3::new(1.3, 0.2, 0.9, 0.2, 1.1, -0.1, 0.9, -0.1, 2.4);
        let whitening = Whitening::of(&c, 0.5).unwrap();
        let columns = [Vector3::x(), Vector3::y(), Vector3::z()].map(|v| whitening.times(&v));
        let w = Matrix3::from_columns(&columns);
        assert!((w * c * 0.25 * w.transpose() - Matrix3::identity()).norm() < 1e-12);
        assert!(Whitening::of(&-c, 0.5).is_none());
    }
}
