//! What correspondences say of the extrinsics, in constant memory and exact at every pose: weighted
//! second moments of the products of their rays.
//!
//! The epipolar constraint `C = b^T X a` is linear in the nine products of two rays `a`, `b`
//! (`X = [i_1]x` in the rectified frame), so `sum w C^2 = e^T M e` with a 9 x 9 matrix `M` that adds up
//! over pairs; the optimum over all of them is found on the essential manifold (`e` as a function of
//! the pose) without a look at the correspondences again. The products are split into `a x b`, whose
//! first component is `C` itself and whose others are disparities, and the symmetric rest: nothing
//! cancels, which `f32` needs.

#[cfg(feature = "simd")]
mod side_by_side;
mod turning;

#[cfg(feature = "simd")]
pub(crate) use side_by_side::Products;

use nalgebra::Vector5;

use crate::codec::{Reader, Writer, check_sums_of_squares};
use crate::error::RestoreError;
use crate::information::Information;
use crate::quadratic::Quadratic;
use crate::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::so3::product;
use crate::symmetric::Symmetric;

/// Elements of the lower triangle of a 9 x 9 matrix.
const TRIANGLE: usize = 45;

/// Largest share of the disparities' square that may be noise.
const MAX_NOISE: f64 = 0.75;

/// Places in the triangle: of the horizontal disparity `cy` and the product of depths `zz`.
const CY_CY: usize = 2;
const ZZ_CY: usize = 16;
const ZZ_ZZ: usize = 20;

type Vector9<T> = [T; 9];

/// A correspondence as it enters the sums.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<V> {
    /// One over the variance of its constraint.
    pub(crate) weight: V,
    /// The nine products of its rays, in the rectified frame and at any depth, which scales the constraint.
    pub(crate) products: [V; 9],
}

/// Sums over correspondences, in the rectified frame of a pose that the owner remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments<T> {
    /// `sum w k k^T`, lower triangle row by row, 1/rad^2.
    products: [T; TRIANGLE],
    /// What the derivative of the residual's variance takes from the slope, by the five unknowns.
    slope: [T; 5],
}

impl<T: Scalar> Moments<T> {
    pub(crate) const ZERO: Self = Self { products: [T::ZERO; TRIANGLE], slope: [T::ZERO; 5] };

    /// Adds one correspondence.
    #[inline(always)]
    pub(crate) fn add_seen(&mut self, &Seen { weight: w, products }: &Seen<T>) {
        let [k0, k1, k2, k3, k4, k5, k6, k7, k8] = products;
        let m = &mut self.products;
        let weighted = w * k0;
        m[0] += weighted * k0;
        let weighted = w * k1;
        m[1] += weighted * k0;
        m[2] += weighted * k1;
        let weighted = w * k2;
        m[3] += weighted * k0;
        m[4] += weighted * k1;
        m[5] += weighted * k2;
        let weighted = w * k3;
        m[6] += weighted * k0;
        m[7] += weighted * k1;
        m[8] += weighted * k2;
        m[9] += weighted * k3;
        let weighted = w * k4;
        m[10] += weighted * k0;
        m[11] += weighted * k1;
        m[12] += weighted * k2;
        m[13] += weighted * k3;
        m[14] += weighted * k4;
        let weighted = w * k5;
        m[15] += weighted * k0;
        m[16] += weighted * k1;
        m[17] += weighted * k2;
        m[18] += weighted * k3;
        m[19] += weighted * k4;
        m[20] += weighted * k5;
        let weighted = w * k6;
        m[21] += weighted * k0;
        m[22] += weighted * k1;
        m[23] += weighted * k2;
        m[24] += weighted * k3;
        m[25] += weighted * k4;
        m[26] += weighted * k5;
        m[27] += weighted * k6;
        let weighted = w * k7;
        m[28] += weighted * k0;
        m[29] += weighted * k1;
        m[30] += weighted * k2;
        m[31] += weighted * k3;
        m[32] += weighted * k4;
        m[33] += weighted * k5;
        m[34] += weighted * k6;
        m[35] += weighted * k7;
        let weighted = w * k8;
        m[36] += weighted * k0;
        m[37] += weighted * k1;
        m[38] += weighted * k2;
        m[39] += weighted * k3;
        m[40] += weighted * k4;
        m[41] += weighted * k5;
        m[42] += weighted * k6;
        m[43] += weighted * k7;
        m[44] += weighted * k8;
    }

    /// Takes the slope of the cost at the frame's own pose as it is, variance and all.
    pub(crate) fn set_gradient(&mut self, gradient: &Vector5<T>) {
        self.slope = [T::ZERO; 5];
        self.slope = (self.at_frame().gradient - gradient).into();
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.products.iter_mut().zip(&other.products).for_each(|(a, b)| *a += *b);
        self.slope.iter_mut().zip(&other.slope).for_each(|(a, b)| *a += *b);
    }

    pub(crate) fn scale(&mut self, factor: T) {
        self.products.iter_mut().chain(&mut self.slope).for_each(|m| *m *= factor);
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.products.iter().chain(&self.slope).all(nalgebra::ComplexField::is_finite)
    }

    pub(crate) fn write(&self, to: &mut Writer<'_>) {
        to.numbers(self.products.iter().chain(&self.slope));
    }

    /// Sums whose diagonal can be that of squares.
    pub(crate) fn read(&mut self, from: &mut Reader<'_>) -> Result<(), RestoreError> {
        from.numbers(self.products.iter_mut().chain(&mut self.slope))?;
        let mut elements = self.products.iter();
        // One more element a row: the last one is on the diagonal.
        let diagonal = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|row| elements.nth(row).copied());
        check_sums_of_squares(diagonal.into_iter().flatten())
    }

    /// Whether disparities are more than noise: a scene at infinity says nothing of the baseline, but
    /// its noise looks as if it did.
    ///
    /// * `variance`: of a coordinate, at unit depth.
    pub(crate) fn speaks_of_baseline(&self, variance: T) -> bool {
        let m = &self.products;
        let (sum, along, all) = (m[CY_CY], m[ZZ_CY], m[ZZ_ZZ]);
        let noise = T::lit(2.0) * variance * all;
        // An error of yaw moves all disparities alike: so they must differ, or be larger than that.
        let yaw = T::lit(9.0) * self.at_frame().information.yaw_share();
        let spread = sum - along * along / all;
        let most = T::lit(MAX_NOISE);
        // Not `>`: a NaN must not speak.
        noise <= most * spread || noise + yaw <= most * sum
    }

    /// Information and slope of the cost at the pose of the frame, where each unknown moves but one or
    /// two of the nine.
    #[inline(never)]
    pub(crate) fn at_frame(&self) -> Quadratic<T> {
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
        Quadratic {
            information: Information(Symmetric(information)),
            gradient: Vector5::from(plain) - Vector5::from(self.slope),
        }
    }

    /// Information and slope of the cost at a pose.
    ///
    /// * `frame`: the pose in whose rectified frame the sums are.
    pub(crate) fn seen_at(
        &self,
        frame: &RectifyingRotations<T>,
        pose: &RectifyingRotations<T>,
    ) -> Quadratic<T> {
        let (mut coefficients, mut seen) = (Coefficients::NONE, Quadratic::ZERO);
        coefficients.add(frame, pose);
        self.see_by(&coefficients, &mut seen);
        seen
    }

    #[inline(never)]
    fn see_by(&self, coefficients: &Coefficients<T>, seen: &mut Quadratic<T>) {
        let Coefficients { by_unknown, of_offset } = coefficients;
        let pull = self.times(of_offset);
        for ((slope, d), own) in seen.gradient.iter_mut().zip(by_unknown).zip(&self.slope) {
            *slope = dot(d, &pull) - *own;
        }
        let mut elements = seen.information.0.0.iter_mut();
        for (unknown, d) in by_unknown.iter().enumerate() {
            let weighed = self.times(d);
            for (other, element) in by_unknown.iter().take(unknown + 1).zip(elements.by_ref()) {
                *element = dot(other, &weighed);
            }
        }
    }

    /// `M x`.
    #[inline(never)]
    fn times(&self, x: &Vector9<T>) -> Vector9<T> {
        let mut y = [T::ZERO; 9];
        let mut m = self.products.iter();
        for (row, x_row) in x.iter().enumerate() {
            let mut sum = T::ZERO;
            for ((x_column, y_column), m) in x.iter().zip(&mut y).take(row).zip(m.by_ref()) {
                sum += *m * *x_column;
                *y_column += *m * *x_row;
            }
            if let (Some(m), Some(y)) = (m.next(), y.get_mut(row)) {
                *y += sum + *m * *x_row;
            }
        }
        y
    }
}

/// Factors of the nine coordinates in the constraint at a pose, and in its derivatives.
struct Coefficients<T> {
    of_offset: Vector9<T>,
    /// By turn of `R` about x, y, z, then of the baseline about y and z (both views alike).
    by_unknown: [Vector9<T>; 5],
}

impl<T: Scalar> Coefficients<T> {
    const NONE: Self = Self { of_offset: [T::ZERO; 9], by_unknown: [[T::ZERO; 9]; 5] };

    #[inline(never)]
    fn add(&mut self, frame: &RectifyingRotations<T>, pose: &RectifyingRotations<T>) {
        // Rows of the one, columns of the other.
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

fn dot<T: Scalar>(a: &Vector9<T>, b: &Vector9<T>) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// Adds the factors of the nine coordinates in `b^T X a`, where `X` is a column times a row.
#[inline(never)]
fn add_outer<T: Scalar>(sum: &mut Vector9<T>, factor: T, column: &[T; 3], row: &[T; 3]) {
    let [x, y, z] = column.map(|x| x * factor);
    let [a, b, c] = *row;
    let half = |sum: T| sum * T::HALF;
    let [cx, cy, cz, xx, yy, zz, xy, xz, yz] = sum;
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

#[cfg(test)]
mod tests;
