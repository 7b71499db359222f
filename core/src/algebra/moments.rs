//! Weighted second moments of ray products. They give the normal equations of the epipolar constraint at any pose, in
//! constant memory, and exactly for frozen weights.
//!
//! The epipolar constraint `C = b^T X a` is linear in the nine products of two rays `a` (left) and `b` (right); in the
//! rectified frame, `X = [i_1]x` with the x axis `i_1`. The nine products, and three derivatives of the constraint with
//! respect to the lens, are the coordinates `k` of a correspondence. At any pose `C = e^T k`, and only the coefficients
//! `e` depend on the pose. So `sum w C^2 = e^T M e` with the 12 x 12 matrix `M = sum w k k^T`, and the matrices of
//! several pairs are added. The optimum over all pairs follows from `M` alone.
//!
//! The products are split into the antisymmetric part `a x b` and the symmetric part: `cx cy cz xx yy zz xy xz yz`. The
//! first component of `a x b` is `C`; the other two are disparities. Sums of these small numbers keep their digits in
//! `f32`; differences of large sums would lose them.

mod sums;
mod times;

use nalgebra::Vector5;

use super::information::Information;
use super::normal_equations::NormalEquations;
use super::symmetric5::Symmetric5;
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3::product;
use crate::scalar::Scalar;

/// Number of coordinates of a correspondence: nine products of its rays, and three derivatives with respect to the
/// lens.
pub(crate) const COORDINATES: usize = 12;

/// Number of coordinates that are products of the rays; the coordinates of the lens follow them.
const PRODUCTS: usize = 9;

/// Number of elements of the lower triangle of a 12 x 12 matrix.
const TRIANGLE: usize = 78;

/// Number of elements of the lower triangle of the nine products.
const PRODUCT_TRIANGLE: usize = 45;

/// One number for each coordinate.
pub(super) type Vector12<T> = [T; COORDINATES];

/// Sums over correspondences, in the rectified frame of a pose. The pose is stored elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments<T> {
    /// `sum w k k^T`, lower triangle row by row, 1/rad^2.
    pub(super) products: [T; TRIANGLE],
    /// Offset that is subtracted from the gradient of `M` with respect to the five unknowns, 1/rad. It accounts for the
    /// derivative of the residual's variance.
    pub(super) slope: [T; 5],
    /// Noise tensor: weighted covariance of `a x b` caused by noise alone, 1/rad^2: elements xx, yy, zy, zz. Its other
    /// elements follow from the baseline part of `slope`. [`Self::set_noise`] computes it for one pair.
    pub(super) noise: [T; 4],
}

impl<T: Scalar> Moments<T> {
    /// No correspondences.
    pub(crate) const ZERO: Self =
        Self { products: [T::ZERO; TRIANGLE], slope: [T::ZERO; 5], noise: [T::ZERO; 4] };

    /// Sets the offset so that the gradient at the pose of the frame equals `gradient`, 1/rad, which includes the
    /// derivative of the variance.
    pub(crate) fn set_gradient(&mut self, gradient: &Vector5<T>) {
        self.slope = [T::ZERO; 5];
        self.slope = (self.at_frame().gradient - gradient).into();
    }

    /// Adds other sums in the same frame.
    pub(crate) fn add(&mut self, other: &Self) {
        self.products.iter_mut().zip(&other.products).for_each(|(a, b)| *a += *b);
        self.slope.iter_mut().zip(&other.slope).for_each(|(a, b)| *a += *b);
        self.noise.iter_mut().zip(&other.noise).for_each(|(a, b)| *a += *b);
    }

    /// Multiplies all sums by a factor.
    #[inline(never)]
    pub(crate) fn scale(&mut self, factor: T) {
        let Self { products, slope, noise } = self;
        products.iter_mut().chain(slope).chain(noise).for_each(|m| *m *= factor);
    }

    /// Returns whether every sum is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let Self { products, slope, noise } = self;
        products.iter().chain(slope).chain(noise).all(nalgebra::ComplexField::is_finite)
    }

    /// Returns the normal equations at the pose of the frame. This is [`FramedMoments::at`] written out, because at this
    /// pose each derivative contains only one or two of the nine products. Derivation: `ESTIMATOR.md`.
    #[inline(never)]
    pub(crate) fn at_frame(&self) -> NormalEquations<T> {
        let m = &self.products;
        let [half, quarter] = [T::HALF, T::HALF * T::HALF];
        let information = [
            m[14] + m[19] + m[19] + m[20],
            -half * (m[12] + m[17] + m[25] + m[26]),
            quarter * (m[5] + m[23] + m[23] + m[27]),
            half * (m[11] + m[16] - m[32] - m[33]),
            quarter * (m[30] - m[4] + m[34] - m[22]),
            quarter * (m[35] - m[29] - m[29] + m[2]),
            -(m[12] + m[17]),
            half * (m[5] + m[23]),
            half * (m[30] - m[4]),
            m[5],
            m[11] + m[16],
            -half * (m[4] + m[22]),
            half * (m[2] - m[29]),
            -m[4],
            m[2],
        ];
        let plain = [-(m[10] + m[15]), half * (m[3] + m[21]), half * (m[28] - m[1]), m[3], -m[1]];
        NormalEquations {
            information: Information(Symmetric5(information)),
            gradient: Vector5::from(plain) - Vector5::from(self.slope),
        }
    }

    /// Fills `H_ik = d_i^T M d_k` and `g_i = d_i^T M e`, minus `slope_i` for the rotation. Out of line, to free the
    /// caller's stack.
    #[inline(never)]
    pub(super) fn fill(&self, coefficients: &Coefficients<T>, normal: &mut NormalEquations<T>) {
        let Coefficients { by_unknown, of_offset } = coefficients;
        let pull = self.times_without_lens(of_offset);
        let [x, y, z, ..] = self.slope;
        let offsets = [x, y, z, T::ZERO, T::ZERO];
        for ((slope, d), own) in normal.gradient.iter_mut().zip(by_unknown).zip(offsets) {
            *slope = dot(d, &pull) - own;
        }
        let mut elements = normal.information.0.0.iter_mut();
        for (unknown, d) in by_unknown.iter().enumerate() {
            let weighted = self.times_without_lens(d);
            for (other, element) in by_unknown.iter().take(unknown + 1).zip(elements.by_ref()) {
                *element = dot(other, &weighted);
            }
        }
    }
}

/// Coefficients of the nine products in the constraint at a pose, and in its derivatives.
pub(super) struct Coefficients<T> {
    /// `e`: the constraint.
    pub(super) of_offset: Vector12<T>,
    /// `d_i`: derivatives of the constraint with respect to rotations of `R` about x, y, z, then of the baseline about
    /// y and z (a baseline rotation turns both views).
    pub(super) by_unknown: [Vector12<T>; 5],
}

impl<T: Scalar> Coefficients<T> {
    pub(super) const NONE: Self =
        Self { of_offset: [T::ZERO; COORDINATES], by_unknown: [[T::ZERO; COORDINATES]; 5] };

    /// Adds the coefficients at `pose`, for products in the rectified frame of `frame`.
    pub(super) fn add(&mut self, frame: &RectifyingRotations<T>, pose: &RectifyingRotations<T>) {
        // Columns: the rectified axes of `pose`, expressed in the rectified frame of `frame`. `left` converts through
        // the frame of the left camera, `right` through that of the right one.
        let left = product(frame.left().matrix(), &pose.left().matrix().transpose());
        let right = product(frame.right().matrix(), &pose.right().matrix().transpose());
        let ([[x_l, y_l, z_l], [x_r, y_r, z_r]], one) = ([left.data.0, right.data.0], T::ONE);
        let Self { of_offset, by_unknown: [x, y, z, forward, down] } = self;
        add_outer(x, -one, &y_r, &y_l);
        add_outer(x, -one, &z_r, &z_l);
        add_outer(y, one, &y_r, &x_l);
        add_outer(z, one, &z_r, &x_l);
        (*forward, *down) = (*y, *z);
        add_outer(forward, -one, &x_r, &y_l);
        add_outer(down, -one, &x_r, &z_l);
        add_outer(of_offset, one, &z_r, &y_l);
        add_outer(of_offset, -one, &y_r, &z_l);
    }
}

/// Returns the scalar product. Written out, because at opt-level "s" a loop takes twice the instructions.
#[inline(never)]
pub(super) fn dot<T: Scalar>(a: &Vector12<T>, b: &Vector12<T>) -> T {
    let ([a, b, c, d, e, f, g, h, i, j, k, l], [m, n, o, p, q, r, s, t, u, v, w, x]) = (*a, *b);
    let products = T::ZERO + a * m + b * n + c * o + d * p + e * q + f * r;
    products + g * s + h * t + i * u + j * v + k * w + l * x
}

/// Adds the coefficients of the nine products in `b^T X a` with `X = factor column row^T`.
#[inline(never)]
pub(super) fn add_outer<T: Scalar>(
    sum: &mut Vector12<T>,
    factor: T,
    column: &[T; 3],
    row: &[T; 3],
) {
    let [x, y, z] = column.map(|x| x * factor);
    let [a, b, c] = *row;
    let half = |sum: T| sum * T::HALF;
    let [cx, cy, cz, xx, yy, zz, xy, xz, yz, ..] = sum;
    *cx += half(z * b - y * c);
    *cy += half(x * c - z * a);
    *cz += half(y * a - x * b);
    *xx += x * a;
    *yy += y * b;
    *zz += z * c;
    *xy += half(x * b + y * a);
    *xz += half(x * c + z * a);
    *yz += half(y * c + z * b);
}

/// Returns the coordinates of a correspondence with these products, and zeros for the lens.
#[cfg(test)]
pub(super) fn without_lens<T: Scalar>(products: [T; 9]) -> Vector12<T> {
    let mut k = [T::ZERO; COORDINATES];
    k.iter_mut().zip(products).for_each(|(k, product)| *k = product);
    k
}

#[cfg(test)]
mod tests;
