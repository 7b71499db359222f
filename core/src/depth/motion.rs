//! Witness of rigid motion: with a wrong yaw, near and far points seem to move by different motions
//! (`docs/witnesses.md`).
//!
//! A tracked match has four views, two in each pair. The two views in the first pair give a point. The motion of the
//! rig predicts column, row and disparity of this point in the second pair. They are compared with the two views there.
//! The unknowns are the rotation and translation of the rig, and the turn of the mount, which adds nearly the same to
//! all disparities.

mod sums;

use crate::batch::correspondence::RayPair;
use crate::error::MotionError;
use crate::scalar::Scalar;
use crate::thresholds::{MOTION_SCALE, MOTION_SETTLED, MOTION_STEPS};
use sums::{COLUMNS, Motion, Sums, UNKNOWNS};

pub(crate) use sums::Views;

/// A motion between two steps of its fit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MotionFit<T: Scalar> {
    motion: Motion<T>,
    /// Scale of the loss in units of [`MOTION_SCALE`].
    scale: T,
    /// Number of steps taken.
    steps: u8,
}

/// The turn of the mount that the motion of the rig shows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TurnByMotion<T> {
    /// Turn of the mount from the pose, rad.
    pub(crate) turn: T,
    /// Variance of the turn, rad^2.
    pub(crate) variance: T,
}

impl<T: Scalar> MotionFit<T> {
    /// No motion, before the first step.
    pub(crate) const START: Self = Self { motion: Motion::NONE, scale: T::ONE, steps: 0 };

    /// Takes one step, with one pass over the tracked matches. Returns the turn of the mount that they show once the
    /// fit has settled, and after [`MOTION_STEPS`] steps; `None` if further steps are needed.
    ///
    /// * `tracked`: rays of each match in the first and in the second pair, with the factory cameras.
    ///
    /// # Errors
    /// [`MotionError::NoMotion`]: the matches agree on no motion, or the equations have no solution.
    #[inline(never)]
    pub(crate) fn advance(
        &mut self,
        views: &Views<'_, T>,
        tracked: &[[RayPair<T>; 2]],
    ) -> Result<Option<TurnByMotion<T>>, MotionError> {
        let scale = (self.scale * T::lit(MOTION_SCALE)).max(T::ONE);
        let mut sums =
            Sums::over(&self.motion, views, tracked, scale).ok_or(MotionError::NoMotion)?;
        let found = solution(&mut sums.rows).ok_or(MotionError::NoMotion)?;
        self.motion.take(&found.step).ok_or(MotionError::NoMotion)?;
        self.scale *= T::HALF;
        self.steps = self.steps.saturating_add(1);
        let is_settled = scale <= T::ONE && found.fall <= T::lit(MOTION_SETTLED);
        if !is_settled && usize::from(self.steps) < MOTION_STEPS {
            return Ok(None);
        }
        let scatter = sums.scatter().ok_or(MotionError::NoMotion)?;
        let turn = TurnByMotion { turn: self.motion.turn, variance: scatter / found.information };
        let is_valid = turn.turn.is_finite() && turn.variance > T::ZERO;
        is_valid.then_some(Some(turn)).ok_or(MotionError::NoMotion)
    }
}

/// Solution of the normal equations.
struct Solution<T> {
    step: [T; UNKNOWNS],
    /// Fall of the sum of squared residuals by the step, to first order: squared length of the step in deviations.
    fall: T,
    /// Information on the last unknown with all other unknowns free.
    information: T,
}

/// Solves normal equations in place, reading nothing left of the diagonal. `None` if the equations have no solution.
fn solution<T: Scalar>(rows: &mut [[T; COLUMNS]; UNKNOWNS]) -> Option<Solution<T>> {
    let mut fall = T::ZERO;
    for i in 0..UNKNOWNS {
        let (above, below) = rows.split_at_mut_checked(i.saturating_add(1))?;
        let pivot_row = above.last()?;
        let pivot = *pivot_row.get(i)?;
        // Not `<=`: a NaN must fail this test.
        if !(pivot > T::ZERO) {
            return None;
        }
        let [.., right] = *pivot_row;
        fall += right * right / pivot;
        let ahead = pivot_row.iter().enumerate().skip(i.saturating_add(1));
        for (row, (from, of_row)) in below.iter_mut().zip(ahead) {
            let factor = *of_row / pivot;
            let both = row.iter_mut().zip(pivot_row).skip(from);
            both.for_each(|(x, p)| *x -= factor * *p);
        }
    }
    let mut step = [T::ZERO; UNKNOWNS];
    for (i, row) in rows.iter().enumerate().rev() {
        let [coefficients @ .., right] = row;
        let known = coefficients.iter().zip(&step).skip(i.saturating_add(1));
        let rest = known.fold(*right, |rest, (c, x)| rest - *c * *x);
        *step.get_mut(i)? = rest / *coefficients.get(i)?;
    }
    let [.., [.., information, _]] = *rows;
    Some(Solution { step, fall, information })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::normal_equations::tests::normal;
    use crate::geometry::lens_correction::LensCorrection;
    use crate::geometry::rectification::RectifyingRotations;
    use crate::geometry::so3;
    use nalgebra::Vector3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    extern crate std;
    use std::vec::Vec;

    /// Standard deviation of a coordinate at unit depth.
    const NOISE: f64 = 2e-4;

    /// Returns 150 tracked matches of a rig whose left camera is turned, with points from `near` to ten times as far.
    /// Every tenth match is wrong.
    fn tracked(turn: f64, translation: [f64; 3], near: f64, seed: u64) -> Vec<[RayPair<f32>; 2]> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [mount, rig] = [turn, 0.05].map(|y| so3::exp(&Vector3::new(0.0, y, 0.0)).unwrap());
        let mut found = Vec::new();
        while found.len() < 150 {
            let [x, y] = [rng.random_range(-0.6..0.6), rng.random_range(-0.4..0.4)];
            let one = Vector3::new(x, y, 1.0) * near * 10_f64.powf(rng.random());
            let mut noise = || NOISE * normal(&mut rng);
            let mut seen = |p: Vector3<f64>| {
                let (left, right) = (mount.inverse() * p, p - Vector3::x());
                let [left, right] =
                    [left, right].map(|p| [p.x / p.z + noise(), p.y / p.z + noise()]);
                (p.z > 1.0).then(|| RayPair::try_new(left.map(f32::lit), right.map(f32::lit)))?
            };
            let two = rig * one + Vector3::from(translation);
            found.extend(seen(one).zip(seen(two)).map(|(one, two)| [one, two]));
        }
        for i in (0..found.len() - 1).step_by(10) {
            found[i][1] = found[i + 1][1];
        }
        found
    }

    #[test]
    fn the_error_of_a_turn_is_its_deviation_whether_the_turn_is_large_or_the_points_are_near() {
        let views = Views {
            pose: &RectifyingRotations::SIDE_BY_SIDE,
            change: LensCorrection::NONE.change_to(&LensCorrection::NONE),
            noise: f32::lit(NOISE),
        };
        for (turn, translation, near) in [
            (0.001, [0.5, 0.1, -4.0], 10.0),
            (0.02, [0.5, 0.1, -4.0], 10.0),
            (-0.005, [0.5, 0.1, -4.0], 3.0),
            (0.005, [0.5, 0.1, -1.5], 2.0),
            (0.005, [4.0, 0.1, 0.0], 5.0),
        ] {
            let mut over = Vec::new();
            for seed in 0..40 {
                let (mut fit, quads) = (MotionFit::START, tracked(turn, translation, near, seed));
                let found = (0..MOTION_STEPS).find_map(|_| fit.advance(&views, &quads).transpose());
                // A start at rest leads to nine of ten motions to the side, and to all motions ahead.
                let Some(Ok(found)) = found else { continue };
                over.push((f64::from(found.turn) - turn).powi(2) / f64::from(found.variance));
            }
            let mean = over.iter().sum::<f64>() / f64::from(u32::try_from(over.len()).unwrap());
            // 99.9 % of chi-square with 40 degrees of freedom are within these limits.
            let is_consistent = over.len() >= 36 && (0.4..1.84).contains(&mean);
            assert!(is_consistent, "{turn} {translation:?} {near}: {mean} of {}", over.len());
        }
    }

    #[test]
    fn normal_equations_are_solved_and_the_last_unknown_is_known_by_its_schur_complement() {
        let place = |i: usize| f64::from(u8::try_from(i).unwrap());
        let h = |i: usize, j: usize| if i == j { 4.0 } else { 1.0 / (1.0 + place(i + j)) };
        let x = [1.0, -2.0, 0.5, 3.0, 0.0, -1.0, 2.0];
        let mut rows = [[f64::NAN; COLUMNS]; UNKNOWNS];
        let mut fall = 0.0;
        for (i, row) in rows.iter_mut().enumerate() {
            row[UNKNOWNS] = (0..UNKNOWNS).map(|j| h(i, j) * x[j]).sum();
            (i..UNKNOWNS).for_each(|j| row[j] = h(i, j));
            fall += row[UNKNOWNS] * x[i];
        }
        let full = nalgebra::SMatrix::<f64, 7, 7>::from_fn(h);
        let found = solution(&mut rows).unwrap();
        for (a, b) in found.step.into_iter().zip(x) {
            assert!((a - b).abs() < 1e-12, "{:?}", found.step);
        }
        assert!((found.fall - fall).abs() < 1e-9 * fall);
        assert!((found.information - 1.0 / full.try_inverse().unwrap()[(6, 6)]).abs() < 1e-12);
        assert!(solution(&mut [[0.0; COLUMNS]; UNKNOWNS]).is_none());
        assert!(solution(&mut [[f64::NAN; COLUMNS]; UNKNOWNS]).is_none());
    }
}
