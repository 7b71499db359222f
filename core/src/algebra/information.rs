//! The 5 x 5 information of a pair about the extrinsics, and what follows from it.
//!
//! Order of the unknowns, all in rad and in the rectified frame (x along the baseline, z forward):
//! turn of `R` about x, y, z; turn of the baseline about y (moves `t_z`) and about z (moves `t_y`).

use nalgebra::{Matrix5, Vector5};

use super::symmetric5::Symmetric5;
use crate::scalar::Scalar;
#[cfg(feature = "paper")]
use crate::thresholds::{MAX_DISPARITY_NOISE, YAW_DEVIATIONS};
use crate::thresholds::{MIN_CONDITION, POWER_ITERATIONS};

/// Symmetric5 positive semi-definite 5 x 5 sum of `w J J^T`, 1/rad^2.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Information<T>(pub(crate) Symmetric5<T>);

impl<T: Scalar> Default for Information<T> {
    /// No information at all.
    fn default() -> Self {
        Self::ZERO
    }
}

impl<T: Scalar> Information<T> {
    pub(crate) const ZERO: Self = Self(Symmetric5::ZERO);

    /// Adds `w j j^T`.
    #[inline(always)]
    pub(crate) fn add_outer(&mut self, w: T, j: &[T; 5]) {
        self.0.add_outer(w, j);
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.0.add(&other.0);
    }

    /// Without what another sum has added.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        Self(self.0.minus(&other.0))
    }

    /// `H x`.
    pub(crate) fn times(&self, x: &Vector5<T>) -> Vector5<T> {
        self.0.times(x)
    }

    pub(crate) fn scaled(&self, factor: T) -> Self {
        Self(self.0.scaled(factor))
    }

    /// Squared disparity, summed, that one standard deviation of the turn about y moves all rows by.
    pub(crate) fn yaw_share(&self) -> T {
        let [pitch, yaw, ..] = self.0.diagonal();
        pitch / yaw
    }

    /// Without what noise adds to the baseline's part of a sum over correspondences, whose rows are
    /// disparities: at infinity noise is all there is of them.
    ///
    /// * `weight`: sum of the weights; `variance`: of a row, in the unit of the sum.
    ///
    /// `None` if less than a quarter of the disparities' square is more than that noise and three
    /// standard deviations of the turn about y, which moves all disparities alike and rows hardly.
    #[cfg(feature = "paper")]
    pub(crate) fn less_disparity_noise(&self, weight: T, variance: T) -> Option<Self> {
        let [.., squares] = self.0.diagonal();
        let alike = T::lit(YAW_DEVIATIONS * YAW_DEVIATIONS) * self.yaw_share();
        if !(variance * (weight + alike) <= squares * T::lit(MAX_DISPARITY_NOISE)) {
            return None;
        }
        let share = T::ONE - variance * weight / squares;
        let mut left = *self;
        let h = &mut left.0.0;
        h[9] *= share;
        h[13] *= share;
        h[14] *= share;
        Some(left)
    }

    /// As a full matrix, 1/rad^2.
    pub fn matrix(&self) -> Matrix5<T> {
        self.0.matrix()
    }

    /// Inverse: covariance of the unknowns, rad^2. `None` if a direction is free.
    pub fn covariance(&self) -> Option<Matrix5<T>> {
        Some(self.0.inverse()?.matrix())
    }

    /// Standard deviations of `R` and of the baseline direction, rad: the expected size of the
    /// error, the root of the trace of each block of the covariance. `None` if a direction is free.
    pub fn standard_deviations(&self) -> Option<StandardDeviations<T>> {
        Some(StandardDeviations::of(&self.0.inverse()?))
    }

    /// Standard deviation along the least certain direction, rad, and that unit direction.
    ///
    /// `None` if it is free. Cost: one 5 x 5 inverse and 12 products.
    pub fn weakest(&self) -> Option<(T, Vector5<T>)> {
        Some(largest_direction(&self.0.inverse()?))
    }

    /// Whether all five directions are determined, in numbers: a scene of one point, of one line,
    /// or at infinity leaves some free.
    pub(crate) fn is_observable(&self) -> bool {
        let [a, b, c, d, e] = self.0.diagonal().map(|d| T::ONE / d.sqrt());
        let scale = Vector5::new(a, b, c, d, e);
        self.0.factor(T::ZERO).is_some_and(|factor| {
            // Of the matrix with unit diagonal: what is of another unit must not look weak.
            let (largest_inverse, _) =
                dominant(|v| factor.solve(&v.component_div(&scale)).component_div(&scale));
            // Not `>`: a NaN must not pass.
            largest_inverse * T::lit(MIN_CONDITION) <= T::ONE
        })
    }

    /// Solves `(H + damping diag H) x = -gradient`; `None` if there is no factor.
    pub(crate) fn damped_step(&self, damping: T, gradient: &Vector5<T>) -> Option<Vector5<T>> {
        Some(-self.0.factor(damping)?.solve(gradient))
    }
}

/// Largest standard deviation of a covariance, and its unit direction.
pub(crate) fn largest_direction<T: Scalar>(covariance: &Symmetric5<T>) -> (T, Vector5<T>) {
    let (variance, direction) = dominant(|v| covariance.times(v));
    (variance.sqrt(), direction)
}

/// Largest eigenvalue and its direction of a positive definite map, by power iteration.
fn dominant<T: Scalar>(map: impl Fn(&Vector5<T>) -> Vector5<T>) -> (T, Vector5<T>) {
    let start = Vector5::new(1.0, -0.9, 0.8, 1.1, -1.2).map(T::lit);
    (0..POWER_ITERATIONS).fold((T::ZERO, start), |(_, v), _| {
        let mapped = map(&v);
        let largest = mapped.amax();
        // Scaled before the norm, whose squares could overflow.
        let norm = (mapped / largest).norm() * largest;
        (norm / v.norm(), mapped / norm)
    })
}

/// Expected size of an error, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StandardDeviations<T> {
    /// Of `R`.
    pub rotation: T,
    /// Of the baseline direction.
    pub translation: T,
}

impl<T: Scalar> core::fmt::Display for StandardDeviations<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "sd R {:.5} rad, t {:.5} rad", self.rotation, self.translation)
    }
}

impl<T: Scalar> StandardDeviations<T> {
    /// Roots of the traces of the two blocks of a covariance.
    pub(crate) fn of(covariance: &Symmetric5<T>) -> Self {
        let [x, y, z, forward, down] = covariance.diagonal();
        Self { rotation: (x + y + z).sqrt(), translation: (forward + down).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Information of five unit rows of different weights along rotated axes.
    fn example() -> Information<f64> {
        let mut sum = Information::ZERO;
        for (i, w) in (0_u8..).zip([4.0, 9.0, 16.0, 0.25, 1e4]) {
            let j: [u8; 5] = [0, 1, 2, 3, 4];
            let j = j.map(|k| f64::from(i * 3 + k * 5 + i * k).sin() + f64::from(i == k));
            sum.add_outer(w, &j);
        }
        sum
    }

    #[test]
    fn covariance_is_the_inverse() {
        let product = example().covariance().unwrap() * example().matrix();
        assert!((product - Matrix5::identity()).amax() < 1e-10, "{product}");
    }

    #[test]
    fn weakest_direction_is_the_smallest_eigenpair() {
        let eigen = example().matrix().symmetric_eigen();
        let smallest = eigen.eigenvalues.imin();
        let (sd, direction) = example().weakest().unwrap();
        assert!((sd * eigen.eigenvalues[smallest].sqrt() - 1.0).abs() < 1e-6);
        assert!(direction.dot(&eigen.eigenvectors.column(smallest)).abs() > 1.0 - 1e-6);
    }

    #[test]
    fn a_free_direction_has_no_covariance_and_is_not_observable() {
        let mut sum = Information::<f32>::ZERO;
        for i in 0..100_u8 {
            let x = f32::from(i) * core::f32::consts::TAU / 100.0;
            // The last two columns are one and the same.
            sum.add_outer(1.0, &[1.0, x.sin(), x.cos(), (2.0 * x).sin(), (2.0 * x).sin()]);
        }
        assert!(!sum.is_observable());
        // Nor is one that only noise tells apart.
        for i in 0..100_u8 {
            let noise = 3e-4 * f32::from(i % 7);
            sum.add_outer(1.0, &[0.0, 0.0, 0.0, noise, -noise]);
        }
        assert!(sum.covariance().is_some() && !sum.is_observable());
        assert!(!Information::<f32>::ZERO.is_observable());
        assert_eq!(Information::<f32>::ZERO.covariance(), None);
        assert!(example().is_observable());
    }
}
