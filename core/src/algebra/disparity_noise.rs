//! Noise of disparities: the false information on the baseline that the noise adds, and the normal equations without it
//! (`ESTIMATOR.md`, section 11).
//!
//! The derivatives of the constraint with respect to the baseline are disparities, and measured disparities contain
//! noise. In a scene at infinity they contain only noise, and `sum w J J^T` would report information on a baseline that
//! is not observable.

use nalgebra::Matrix3;

use super::moments::{COORDINATES, Moments, add_outer};
use super::normal_equations::NormalEquations;
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3::product;
use crate::scalar::Scalar;
use crate::thresholds::{ALIKE_DISPARITIES, DISPARITY_NOISE_MARGIN};

/// Information on the baseline that noise adds, 1/rad^2: the elements forward (rotation about y), mixed, and down
/// (rotation about z).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BaselineNoise<T>(pub(crate) [T; 3]);

/// Normal equations about a pose, and the noise in them. They can be added, and moved to another pose by a step
/// ([`Self::about`]). [`Self::debiased`] removes the noise, after these operations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BiasedEquations<T> {
    pub(crate) normal: NormalEquations<T>,
    pub(crate) noise: BaselineNoise<T>,
}

impl<T: Scalar> Moments<T> {
    /// Sets the noise tensor of one pair, that is, the weighted covariance of `a x b` that noise causes, from the
    /// products and the variance of a coordinate. [`Moments::set_gradient`] sets the elements xy and xz. The
    /// elements that this function sets are zero if the sums are not positive or not numbers.
    ///
    /// * `pose`: pose of the frame; `variance`: variance of a coordinate at unit depth, dimensionless.
    pub(crate) fn set_noise(&mut self, pose: &RectifyingRotations<T>, variance: T) {
        let axes = [pose.left(), pose.right()].map(|r| r.matrix().data.0[2]);
        let [left, right] = &axes;
        // Rays have depth 1 in their cameras, so `(r_3 . b) (l_3 . a) = 1`. `M` times the coefficients of this product
        // is `sum w k`.
        let mut one = [T::ZERO; COORDINATES];
        add_outer(&mut one, T::ONE, right, left);
        let [_, _, _, xx, yy, zz, xy, xz, yz, ..] = self.times(&one);
        let half = |sum: T| sum * T::HALF;
        let (xy, xz, yz) = (half(xy), half(xz), half(yz));
        let p = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        // If disparities are only noise, `a = b`, and both views have the same `sum w p p^T`.
        let mut sum = (Matrix3::from_diagonal_element(xx + yy + zz) - p) * T::lit(2.0);
        for [x, y, z] in axes {
            let across = Matrix3::new(T::ZERO, -z, y, z, T::ZERO, -x, -y, x, T::ZERO);
            sum -= product(&product(&across, &p), &across.transpose());
        }
        let [kept, ..] = self.products;
        // The test is written so that a NaN fails it.
        if !(sum.m11 > T::ZERO) {
            self.noise = [T::ZERO; 4];
            return;
        }
        // The loss keeps only a part of the squared residuals, but all of the squared disparities.
        let lost = variance - kept / sum.m11;
        let forward = variance * sum.m33 - lost * T::lit(2.0) * xx;
        self.noise = [kept, variance * sum.m22, variance * sum.m32, forward];
    }

    /// Returns whether the variance of the disparities about a linear function of the column is below
    /// [`ALIKE_DISPARITIES`] times the variance of their noise. Then both sides show the same image, possibly shifted
    /// or with other intrinsics. Must be called after [`Moments::set_noise`].
    pub(crate) fn are_disparities_alike(&self) -> bool {
        let [_, noise, ..] = self.noise;
        let sums = |[i, j]: [usize; 2]| self.products.get(i * (i + 1) / 2 + j).copied();
        let [all, with_one, one, with_x, mixed, x] =
            [[1, 1], [5, 1], [5, 5], [7, 1], [7, 5], [7, 7]].map(|at| sums(at).unwrap_or(T::ZERO));
        let determinant = one * x - mixed * mixed;
        let explained = with_one * with_one * x + with_x * with_x * one
            - T::lit(2.0) * with_one * with_x * mixed;
        // Negated `>=`, so that disparities count as alike if a sum is NaN.
        !(all * determinant - explained >= T::lit(ALIKE_DISPARITIES) * noise * determinant)
    }

    /// Returns the symmetric noise tensor in the frame of the sums. Its first column contains the baseline part of the
    /// gradient's offset.
    fn noise_tensor(&self) -> Matrix3<T> {
        let ([xx, yy, zy, zz], [.., by_forward, by_down]) = (self.noise, self.slope);
        let (xy, xz) = (-by_down, by_forward);
        Matrix3::new(xx, xy, xz, xy, yy, zy, xz, zy, zz)
    }

    /// Returns the noise tensor in the frame of another pose.
    pub(super) fn noise_tensor_at(
        &self,
        frame: &RectifyingRotations<T>,
        pose: &RectifyingRotations<T>,
    ) -> Matrix3<T> {
        let turn = product(pose.left().matrix(), &frame.left().matrix().transpose());
        product(&product(&turn, &self.noise_tensor()), &turn.transpose())
    }

    /// Changes the frame of the noise tensor, including the baseline part of the gradient's offset.
    pub(super) fn change_frame_of_noise(
        &mut self,
        from: &RectifyingRotations<T>,
        to: &RectifyingRotations<T>,
    ) {
        let n = self.noise_tensor_at(from, to);
        let [.., by_forward, by_down] = &mut self.slope;
        (*by_forward, *by_down) = (n.m31, -n.m21);
        self.noise = [n.m11, n.m22, n.m32, n.m33];
    }

    /// Returns the normal equations at the pose of the frame, noise included.
    pub(crate) fn biased_at_frame(&self) -> BiasedEquations<T> {
        let [_, yy, zy, zz] = self.noise;
        BiasedEquations { normal: self.at_frame(), noise: BaselineNoise([zz, -zy, yy]) }
    }
}

impl<T: Scalar> BiasedEquations<T> {
    /// Equations of a cost of zero.
    pub(crate) const ZERO: Self =
        Self { normal: NormalEquations::ZERO, noise: BaselineNoise([T::ZERO; 3]) };

    /// Adds independent equations about the same pose.
    pub(crate) fn add(&mut self, other: &Self) {
        self.normal.add(&other.normal);
        self.noise.0.iter_mut().zip(other.noise.0).for_each(|(sum, n)| *sum += n);
    }

    /// Returns the equations without a part of the cost.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.noise.0, other.noise.0);
        Self {
            normal: self.normal.minus(&other.normal),
            noise: BaselineNoise([a - x, b - y, c - z]),
        }
    }

    /// Returns the equations of the cost times `factor`.
    pub(crate) fn scaled(&self, factor: T) -> Self {
        Self {
            normal: self.normal.scaled(factor),
            noise: BaselineNoise(self.noise.0.map(|n| n * factor)),
        }
    }

    /// Returns the same equations about the pose after a step `d`, rad. The false information from noise does not
    /// change the gradient.
    #[inline(never)]
    pub(crate) fn about(&self, d: &nalgebra::Vector5<T>) -> Self {
        let mut normal = self.normal.about(d);
        let [forward, mixed, down] = self.noise.0;
        normal.gradient.w -= forward * d.w + mixed * d.a;
        normal.gradient.a -= mixed * d.w + down * d.a;
        Self { normal, noise: self.noise }
    }

    /// Returns the equations without the noise: information `A B^-1 A` and gradient `A B^-1 g`. `B`, the sum with
    /// noise, is the covariance of the gradient. `A`, the sum without noise, is the derivative of the expected
    /// gradient.
    ///
    /// Only the block of the baseline changes. Let `K = L L^T` be its marginal information, and `S` the noise times
    /// [`DISPARITY_NOISE_MARGIN`]. The eigenvalues `l` of `L^-1 S L^-T` give the gains `1 - l`, limited to 0 to 1. A
    /// gain is near 1 if disparities far exceed the noise. Equations with a free direction are returned with their
    /// noise.
    pub(crate) fn debiased(&self) -> NormalEquations<T> {
        let Some(factor) = self.normal.information.0.factor(T::ZERO) else {
            return self.normal;
        };
        let step = -factor.solve(&self.normal.gradient);
        // The factors of all information end with those of the marginal information: nothing cancels in `f32`.
        let [k33, unit_l21, pivot] = factor.of_last_two();
        let [l11, l22] = [k33.sqrt(), pivot.sqrt()];
        let l21 = unit_l21 * l11;
        let (k43, k44) = (l21 * l11, l21 * l21 + pivot);
        let [a, b, c] = self.noise.0.map(|n| n * T::lit(DISPARITY_NOISE_MARGIN));
        let w11 = a / k33;
        let w21 = (b / l11 - l21 * w11) / l22;
        let w22 = ((c - l21 * b / l11) / l22 - l21 * w21) / l22;
        let gain = Gain::of(w11, w21, w22);
        let ([p, q, r], [x, y, z]) = (gain.once, gain.twice);
        // Negative marginal gradient, in units of its standard deviations.
        let (by_forward, by_down) = (k33 * step.w + k43 * step.a, k43 * step.w + k44 * step.a);
        let u1 = by_forward / l11;
        let u2 = (by_down - l21 * u1) / l22;
        let (u1, u2) = (p * u1 + q * u2, q * u1 + r * u2);
        let mut debiased = self.normal;
        debiased.gradient.w += by_forward - l11 * u1;
        debiased.gradient.a += by_down - l21 * u1 - l22 * u2;
        let h = &mut debiased.information.0.0;
        h[9] += l11 * l11 * x - k33;
        h[13] += l11 * (l21 * x + l22 * y) - k43;
        h[14] += l21 * l21 * x + T::lit(2.0) * l21 * l22 * y + l22 * l22 * z - k44;
        debiased
    }
}

/// Two functions of a symmetric 2 x 2 matrix with eigenvalues `l`: the gains `1 - l`, limited to 0 to 1, and the
/// squared gains. Each is a symmetric matrix with the elements 11, 21, 22.
struct Gain<T> {
    once: [T; 3],
    twice: [T; 3],
}

impl<T: Scalar> Gain<T> {
    fn of(w11: T, w21: T, w22: T) -> Self {
        let (mean, half) = (T::HALF * (w11 + w22), T::HALF * (w11 - w22));
        let radius = (half * half + w21 * w21).sqrt();
        // At most 1, because negative noise is a rounding error.
        let gain = |l: T| (T::ONE - l).max(T::ZERO).min(T::ONE);
        let [large, small] = [mean + radius, mean - radius].map(gain);
        // Matrix function with given values at both eigenvalues: `f(W) = p I + q W`.
        let matrix = |at_large: T, at_small: T| {
            let q = if radius > T::EPSILON {
                (at_large - at_small) / (radius + radius)
            } else {
                T::ZERO
            };
            let p = T::HALF * (at_large + at_small) - q * mean;
            [p + q * w11, q * w21, p + q * w22]
        };
        Self { once: matrix(large, small), twice: matrix(large * large, small * small) }
    }
}

#[cfg(test)]
mod tests;
