//! The 5 x 5 information of a pair about the extrinsics, and what follows from it.
//!
//! Order of the unknowns, all in rad and in the rectified frame (x along the baseline, z forward):
//! turn of `R` about x, y, z; turn of the baseline about y (moves `t_z`) and about z (moves `t_y`).

use nalgebra::{Cholesky, ComplexField, Const, Matrix5, SVector, Vector5};

use crate::scalar::Scalar;

/// Smallest eigenvalue of the information with unit diagonal, below which a direction is free.
const MIN_CONDITION: f64 = 1e-5;

/// Largest share of the disparities' square that may be noise.
const MAX_NOISE: f64 = 0.75;

/// Correspondences summed apart before they are added to the totals: bounds the rounding.
pub(crate) const BLOCK: usize = 16;

/// Inverse iterations for a smallest eigenvalue; the start is never orthogonal to it in practice.
const INVERSE_ITERATIONS: usize = 12;

/// Symmetric positive semi-definite 5 x 5 sum of `w J J^T`, lower triangle row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Information<T>([T; 15]);

impl<T: Scalar> Default for Information<T> {
    /// No information at all.
    fn default() -> Self {
        Self::ZERO
    }
}

impl<T: Scalar> Information<T> {
    pub(crate) const ZERO: Self = Self([T::ZERO; 15]);

    /// Adds `w j j^T`.
    #[inline]
    pub(crate) fn add_outer(&mut self, w: T, j: &[T; 5]) {
        let [j0, j1, j2, j3, j4] = *j;
        let [w0, w1, w2, w3, w4] = [w * j0, w * j1, w * j2, w * j3, w * j4];
        let h = &mut self.0;
        h[0] += w0 * j0;
        h[1] += w1 * j0;
        h[2] += w1 * j1;
        h[3] += w2 * j0;
        h[4] += w2 * j1;
        h[5] += w2 * j2;
        h[6] += w3 * j0;
        h[7] += w3 * j1;
        h[8] += w3 * j2;
        h[9] += w3 * j3;
        h[10] += w4 * j0;
        h[11] += w4 * j1;
        h[12] += w4 * j2;
        h[13] += w4 * j3;
        h[14] += w4 * j4;
    }

    /// `x_i . y_j` for `j <= i`: symmetric if `y = M x` with a symmetric `M`.
    pub(crate) fn of_products<const D: usize>(
        x: &[SVector<T, D>; 5],
        y: &[SVector<T, D>; 5],
    ) -> Self {
        let mut sum = Self::ZERO;
        let rows = x.iter().enumerate();
        let products = rows.flat_map(|(i, x)| y.iter().take(i + 1).map(move |y| x.dot(y)));
        sum.0.iter_mut().zip(products).for_each(|(h, product)| *h = product);
        sum
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a += *b);
    }

    /// Without what another sum has added.
    pub(crate) fn less(&self, other: &Self) -> Self {
        let mut left = *self;
        left.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a -= *b);
        left
    }

    /// The lower triangle of a symmetric matrix.
    fn packed(m: &Matrix5<T>) -> Self {
        let mut packed = Self::ZERO;
        let triangle = (0..5).flat_map(|row| (0..=row).map(move |column| (row, column)));
        for (element, at) in packed.0.iter_mut().zip(triangle) {
            *element = m.get(at).copied().unwrap_or(T::ZERO);
        }
        packed
    }

    /// With `value` added to every element of the diagonal.
    pub(crate) fn plus_diagonal(&self, value: T) -> Self {
        let mut sum = *self;
        let h = &mut sum.0;
        h[0] += value;
        h[2] += value;
        h[5] += value;
        h[9] += value;
        h[14] += value;
        sum
    }

    /// `H x`.
    pub(crate) fn times(&self, x: &Vector5<T>) -> Vector5<T> {
        self.matrix() * x
    }

    pub(crate) fn scaled(&self, factor: T) -> Self {
        Self(self.0.map(|h| h * factor))
    }

    /// Squared disparity, summed, that one standard deviation of the turn about y moves all rows by.
    pub(crate) fn yaw_share(&self) -> T {
        self.0[0] / self.0[2]
    }

    /// Without what noise adds to the baseline's part of a sum over correspondences, whose rows are
    /// disparities: at infinity noise is all there is of them.
    ///
    /// * `weight`: sum of the weights; `variance`: of a row, in the unit of the sum.
    ///
    /// `None` if less than a quarter of the disparities' square is more than that noise and three
    /// standard deviations of the turn about y, which moves all disparities alike and rows hardly.
    pub(crate) fn less_disparity_noise(&self, weight: T, variance: T) -> Option<Self> {
        let squares = self.0[14];
        let alike = T::lit(9.0) * self.yaw_share();
        if !(variance * (weight + alike) <= squares * T::lit(MAX_NOISE)) {
            return None;
        }
        let share = T::ONE - variance * weight / squares;
        let mut left = *self;
        left.0[9] *= share;
        left.0[13] *= share;
        left.0[14] *= share;
        Some(left)
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.0.iter().all(ComplexField::is_finite)
    }

    /// As a full matrix, 1/rad^2.
    pub fn matrix(&self) -> Matrix5<T> {
        let h = &self.0;
        Matrix5::new(
            h[0], h[1], h[3], h[6], h[10], //
            h[1], h[2], h[4], h[7], h[11], //
            h[3], h[4], h[5], h[8], h[12], //
            h[6], h[7], h[8], h[9], h[13], //
            h[10], h[11], h[12], h[13], h[14],
        )
    }

    /// Inverse: covariance of the unknowns, rad^2. `None` if a direction is free.
    pub fn covariance(&self) -> Option<Matrix5<T>> {
        let (factor, scale) = self.factor(T::ZERO)?;
        let inverse = factor.inverse();
        Some(inverse.component_mul(&(scale * scale.transpose())))
    }

    /// Standard deviations of `R` and of the baseline direction, rad: the expected size of the
    /// error, the root of the trace of each block of the covariance. `None` if a direction is free.
    pub fn standard_deviations(&self) -> Option<StandardDeviations<T>> {
        Some(StandardDeviations::of(&self.covariance()?))
    }

    /// Standard deviation along the least certain direction, rad, and that unit direction.
    ///
    /// `None` if it is free. Cost: one 5 x 5 inverse and 12 products.
    pub fn weakest(&self) -> Option<(T, Vector5<T>)> {
        Some(largest_direction(&self.covariance()?))
    }

    /// Whether all five directions are determined, in numbers: a scene of one point, of one line,
    /// or at infinity leaves some free.
    pub(crate) fn is_observable(&self) -> bool {
        self.factor(T::ZERO).is_some_and(|(factor, _)| {
            let (largest_inverse, _) = dominant(|v| factor.solve(v));
            // Not `>`: a NaN must not pass.
            largest_inverse * T::lit(MIN_CONDITION) <= T::ONE
        })
    }

    /// Inverse of a covariance, rad^2; `None` if it is none.
    pub(crate) fn of_covariance(covariance: &Matrix5<T>) -> Option<Self> {
        Some(Self::packed(&Self::packed(covariance).covariance()?))
    }

    /// Solves `(H + damping diag H) x = -gradient`; `None` if there is no Cholesky factor.
    pub(crate) fn damped_step(&self, damping: T, gradient: &[T; 5]) -> Option<Vector5<T>> {
        let (factor, scale) = self.factor(damping)?;
        let mut x = -Vector5::from(*gradient).component_mul(&scale);
        factor.solve_mut(&mut x);
        Some(x.component_mul(&scale))
    }

    /// Factor of the matrix scaled to unit diagonal plus damping, and the scales `1 / sqrt(h_ii)`.
    fn factor(&self, damping: T) -> Option<(Cholesky<T, Const<5>>, Vector5<T>)> {
        let h = &self.0;
        let diagonal = Vector5::new(h[0], h[2], h[5], h[9], h[14]);
        if !diagonal.iter().all(|&d| d > T::ZERO && d.is_finite()) {
            return None;
        }
        let scale = diagonal.map(|d| T::ONE / d.sqrt());
        let mut scaled = self.matrix().component_mul(&(scale * scale.transpose()));
        scaled.set_diagonal(&Vector5::repeat(T::ONE + damping));
        Some((Cholesky::new(scaled)?, scale))
    }
}

/// Largest standard deviation of a covariance, and its unit direction.
pub(crate) fn largest_direction<T: Scalar>(covariance: &Matrix5<T>) -> (T, Vector5<T>) {
    let (variance, direction) = dominant(|v| covariance * v);
    (variance.sqrt(), direction)
}

/// Largest eigenvalue and its direction of a positive definite map, by power iteration.
fn dominant<T: Scalar>(map: impl Fn(&Vector5<T>) -> Vector5<T>) -> (T, Vector5<T>) {
    let start = Vector5::new(1.0, -0.9, 0.8, 1.1, -1.2).map(T::lit);
    (0..INVERSE_ITERATIONS).fold((T::ZERO, start), |(_, v), _| {
        let mapped = map(&v);
        let largest = mapped.amax();
        // Scaled before the norm, whose squares could overflow.
        let norm = (mapped / largest).norm() * largest;
        (norm / v.norm(), mapped / norm)
    })
}

/// Expected size of an error, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandardDeviations<T> {
    /// Of `R`.
    pub rotation: T,
    /// Of the baseline direction.
    pub translation: T,
}

impl<T: Scalar> StandardDeviations<T> {
    /// Roots of the traces of the two blocks of a covariance.
    pub(crate) fn of(c: &Matrix5<T>) -> Self {
        Self { rotation: (c.m11 + c.m22 + c.m33).sqrt(), translation: (c.m44 + c.m55).sqrt() }
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
    fn information_of_a_covariance_is_its_inverse_or_none() {
        let back = Information::of_covariance(&example().covariance().unwrap()).unwrap();
        assert!((back.matrix() - example().matrix()).amax() < 1e-8 * example().matrix().amax());
        assert_eq!(Information::of_covariance(&Matrix5::<f64>::zeros()), None);
        assert_eq!(Information::of_covariance(&Matrix5::repeat(f64::NAN)), None);
        let mut indefinite = Matrix5::<f64>::identity();
        indefinite.m12 = 2.0;
        indefinite.m21 = 2.0;
        assert_eq!(Information::of_covariance(&indefinite), None);
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

    #[test]
    fn damped_step_solves_the_damped_system() {
        let gradient = [1.0, -2.0, 0.5, 3.0, -0.1];
        let step = example().damped_step(0.1, &gradient).unwrap();
        let mut h = example().matrix();
        for i in 0..5 {
            h[(i, i)] *= 1.1;
        }
        assert!((h * step + Vector5::from(gradient)).amax() < 1e-10);
    }
}
