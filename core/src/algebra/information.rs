//! The 5 x 5 Fisher information of the extrinsics, and the covariances that follow from it.
//!
//! The unknowns are angles in rad, in the rectified frame (x along the baseline, z forward). Their order is: rotation
//! of `R` about x, y, z; rotation of the baseline about y (moves `t_z`) and about z (moves `t_y`).

use nalgebra::{Matrix5, Vector5};

use super::symmetric5::Symmetric5;
use crate::scalar::Scalar;
use crate::thresholds::{MIN_CONDITION, POWER_ITERATIONS};

/// Symmetric positive semi-definite 5 x 5 sum of `w J J^T`, 1/rad^2.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Information<T>(pub(crate) Symmetric5<T>);

impl<T: Scalar> Default for Information<T> {
    /// Returns zero: all five directions are free.
    fn default() -> Self {
        Self::ZERO
    }
}

impl<T: Scalar> Information<T> {
    /// No information: all five directions are free.
    pub(crate) const ZERO: Self = Self(Symmetric5::ZERO);

    /// Adds `w j j^T`, a row `j` of the Jacobian with weight `w`.
    #[inline(always)]
    pub(crate) fn add_outer(&mut self, w: T, j: &[T; 5]) {
        self.0.add_outer(w, j);
    }

    /// Adds the information of independent correspondences.
    pub(crate) fn add(&mut self, other: &Self) {
        self.0.add(&other.0);
    }

    /// Returns `H - other`: the information without a part of the sum.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        Self(self.0.minus(&other.0))
    }

    /// Returns `H x`.
    pub(crate) fn times(&self, x: &Vector5<T>) -> Vector5<T> {
        self.0.times(x)
    }

    /// Returns `factor H`.
    pub(crate) fn scaled(&self, factor: T) -> Self {
        Self(self.0.scaled(factor))
    }

    /// Returns the full matrix `H`, 1/rad^2.
    pub fn matrix(&self) -> Matrix5<T> {
        self.0.matrix()
    }

    /// Returns the covariance of the unknowns, `H^-1`, rad^2. `None` if a direction is free.
    pub fn covariance(&self) -> Option<Matrix5<T>> {
        Some(self.0.inverse()?.matrix())
    }

    /// Returns the standard deviations of `R` and of the baseline direction, rad. `None` if a direction is free.
    pub fn standard_deviations(&self) -> Option<StandardDeviations<T>> {
        Some(StandardDeviations::of(&self.0.inverse()?))
    }

    /// Returns the standard deviation along the least determined direction, rad, and this direction as a unit vector.
    ///
    /// `None` if a direction is free. Cost: one 5 x 5 inverse and 12 products with a vector.
    pub fn weakest(&self) -> Option<(T, Vector5<T>)> {
        Some(largest_direction(&self.0.inverse()?))
    }

    /// Returns whether all five directions are determined beyond rounding errors. A scene that is a single point, a
    /// single line, or at infinity leaves some directions free.
    ///
    /// The test uses the smallest eigenvalue of `H` scaled to a unit diagonal, which does not depend on units. A
    /// direction is not determined if its derivatives are below the rounding errors of those of another direction.
    pub(crate) fn is_observable(&self) -> bool {
        let diagonal = self.0.diagonal();
        let least = diagonal.into_iter().fold(T::ZERO, T::max) * (T::EPSILON * T::EPSILON);
        // The test is written so that a NaN fails it.
        if !diagonal.into_iter().all(|d| d > least) {
            return false;
        }
        let [a, b, c, d, e] = diagonal.map(|d| T::ONE / d.sqrt());
        let scale = Vector5::new(a, b, c, d, e);
        self.0.factor(T::ZERO).is_some_and(|factor| {
            let (largest_inverse, _) =
                dominant(&|v| factor.solve(&v.component_div(&scale)).component_div(&scale));
            // The test is written so that a NaN fails it.
            largest_inverse * T::lit(MIN_CONDITION) <= T::ONE
        })
    }
}

/// Returns the largest standard deviation of a covariance, rad, and its direction as a unit vector.
pub(crate) fn largest_direction<T: Scalar>(covariance: &Symmetric5<T>) -> (T, Vector5<T>) {
    let (variance, direction) = dominant(&|v| covariance.times(v));
    (variance.sqrt(), direction)
}

/// Returns the largest eigenvalue of a positive definite map and its unit eigenvector, by a fixed number of power
/// iterations. In usual scenes the start vector is not orthogonal to this eigenvector.
fn dominant<T: Scalar>(map: &dyn Fn(&Vector5<T>) -> Vector5<T>) -> (T, Vector5<T>) {
    let start = Vector5::new(1.0, -0.9, 0.8, 1.1, -1.2).map(T::lit);
    (0..POWER_ITERATIONS).fold((T::ZERO, start), |(_, v), _| {
        let mapped = map(&v);
        let largest = mapped.amax();
        // Scaled before the norm, because the squares could overflow in `f32`.
        let norm = (mapped / largest).norm() * largest;
        (norm / v.norm(), mapped / norm)
    })
}

/// Expected size of the error of `R` and of the baseline direction: the root of the trace of each block of the
/// covariance, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StandardDeviations<T> {
    /// Standard deviation of `R`, rad.
    pub rotation: T,
    /// Standard deviation of the baseline direction, rad.
    pub translation: T,
}

impl<T: Scalar> core::fmt::Display for StandardDeviations<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "sd R {:.5} rad, t {:.5} rad", self.rotation, self.translation)
    }
}

impl<T: Scalar> StandardDeviations<T> {
    /// Returns the standard deviations of a covariance, rad^2.
    pub(crate) fn of(covariance: &Symmetric5<T>) -> Self {
        let [x, y, z, forward, down] = covariance.diagonal();
        Self { rotation: (x + y + z).sqrt(), translation: (forward + down).sqrt() }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.rotation.is_finite() && self.translation.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the information of five rows with different weights.
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
    fn covariance_is_the_inverse_and_the_weakest_direction_its_largest_eigenpair() {
        let product = example().covariance().unwrap() * example().matrix();
        assert!((product - Matrix5::identity()).amax() < 1e-10, "{product}");
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
            // The last two columns are equal.
            sum.add_outer(1.0, &[1.0, x.sin(), x.cos(), (2.0 * x).sin(), (2.0 * x).sin()]);
        }
        assert!(!sum.is_observable());
        // If two columns are nearly equal, a covariance exists, but one direction is not observable.
        for i in 0..100_u8 {
            let noise = 3e-4 * f32::from(i % 7);
            sum.add_outer(1.0, &[0.0, 0.0, 0.0, noise, -noise]);
        }
        assert!(sum.covariance().is_some() && !sum.is_observable());
        assert!(!Information::<f32>::ZERO.is_observable());
        assert_eq!(Information::<f32>::ZERO.covariance(), None);
        assert!(example().is_observable());
        // Beside an information of 1e12, a direction needs an information above `1e12 EPSILON^2` = 0.014.
        let of = |least: f32| Information(Symmetric5::of_diagonal([1e12, 1.0, 1e9, least, 1.0]));
        assert_eq!(
            [0.02, 0.01, 0.0, f32::NAN].map(|least| of(least).is_observable()),
            [true, false, false, false]
        );
    }
}
