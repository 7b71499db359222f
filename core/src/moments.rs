//! What correspondences say of the extrinsics, in constant memory and exact at every pose: weighted
//! second moments of the products of their rays.
//!
//! The epipolar constraint `C = b^T X a` is linear in the nine products of two rays `a`, `b`
//! (`X = [i_1]x` in the rectified frame), so `sum w C^2 = e^T M e` with a 9 x 9 matrix `M` that adds up
//! over pairs; the optimum over all of them is found on the essential manifold (`e` as a function of
//! the pose) without a look at the correspondences again. The products are split into `a x b`, whose
//! first component is `C` itself and whose others are disparities, and the symmetric rest: nothing
//! cancels, which `f32` needs.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3, Vector5};

use crate::information::Information;
use crate::quadratic::Quadratic;
use crate::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Elements of the lower triangle of a 9 x 9 matrix.
const TRIANGLE: usize = 45;

/// Largest share of the disparities' square that may be noise.
const MAX_NOISE: f64 = 0.75;

/// Places in the triangle: of the horizontal disparity `cy` and the product of depths `zz`.
const CY_CY: usize = 2;
const ZZ_CY: usize = 16;
const ZZ_ZZ: usize = 20;

type Vector9<T> = SVector<T, 9>;
type Matrix9<T> = SMatrix<T, 9, 9>;

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
    ///
    /// * `left`, `right`: its rays at unit depth, rotated into the rectified frame.
    /// * `w`: one over the variance of their `C`.
    #[inline]
    pub(crate) fn add_rays(&mut self, w: T, left: &Vector3<T>, right: &Vector3<T>) {
        let (a, b) = (left, right);
        let k = [
            a.y * b.z - a.z * b.y,
            a.z * b.x - a.x * b.z,
            a.x * b.y - a.y * b.x,
            a.x * b.x,
            a.y * b.y,
            a.z * b.z,
            a.x * b.y + a.y * b.x,
            a.x * b.z + a.z * b.x,
            a.y * b.z + a.z * b.y,
        ];
        let mut sums = self.products.iter_mut();
        for (row, k_row) in k.iter().enumerate() {
            let weighted = w * *k_row;
            // The columns first: `zip` takes from its right side only what the left side has.
            for (k_column, sum) in k.iter().take(row + 1).zip(sums.by_ref()) {
                *sum += weighted * *k_column;
            }
        }
    }

    /// Takes the slope of the cost at the frame's own pose as it is, variance and all.
    pub(crate) fn set_gradient(&mut self, frame: &RectifyingRotations<T>, gradient: &[T; 5]) {
        self.slope = [T::ZERO; 5];
        let plain = self.seen_at(frame, frame).gradient;
        self.slope = (plain - Vector5::from(*gradient)).into();
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.products.iter_mut().zip(&other.products).for_each(|(a, b)| *a += *b);
        self.slope.iter_mut().zip(&other.slope).for_each(|(a, b)| *a += *b);
    }

    pub(crate) fn scaled(&self, factor: T) -> Self {
        Self { products: self.products.map(|m| m * factor), slope: self.slope.map(|s| s * factor) }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.products.iter().chain(&self.slope).all(nalgebra::ComplexField::is_finite)
    }

    /// Whether disparities are more than noise: a scene at infinity says nothing of the baseline, but
    /// its noise looks as if it did.
    ///
    /// * `frame`: the pose in whose rectified frame the sums are.
    /// * `variance`: of a coordinate, at unit depth.
    pub(crate) fn speaks_of_baseline(&self, frame: &RectifyingRotations<T>, variance: T) -> bool {
        let m = &self.products;
        let (sum, along, all) = (m[CY_CY], m[ZZ_CY], m[ZZ_ZZ]);
        let noise = T::lit(2.0) * variance * all;
        // An error of yaw moves all disparities alike: so they must differ, or be larger than that.
        let yaw = T::lit(9.0) * self.seen_at(frame, frame).information.yaw_share();
        let spread = sum - along * along / all;
        let most = T::lit(MAX_NOISE);
        // Not `>`: a NaN must not speak.
        noise <= most * spread || noise + yaw <= most * sum
    }

    /// The same sums in the rectified frame of another pose.
    pub(crate) fn turned(
        &self,
        from: &RectifyingRotations<T>,
        to: &RectifyingRotations<T>,
    ) -> Self {
        let less_identity = |to: &Rotation3<T>, from: &Rotation3<T>| {
            (to * from.inverse()).matrix() - Matrix3::identity()
        };
        let left = less_identity(to.left(), from.left());
        let right = less_identity(to.right(), from.right());
        let mut m = self.matrix();
        for _ in 0..2 {
            for mut column in m.column_iter_mut() {
                let k: Vector9<T> = column.clone_owned();
                let b = outer(&k);
                let turned = right * b;
                // As a difference: what is small stays exact.
                let moved = turned + (b + turned) * left.transpose();
                column.copy_from(&(k + split(&moved)));
            }
            m = m.transpose();
        }
        let mut turned = *self;
        turned.set_matrix(&m);
        turned
    }

    /// Information and slope of the cost at a pose.
    ///
    /// * `frame`: the pose in whose rectified frame the sums are.
    pub(crate) fn seen_at(
        &self,
        frame: &RectifyingRotations<T>,
        pose: &RectifyingRotations<T>,
    ) -> Quadratic<T> {
        let left = (pose.left() * frame.left().inverse()).into_inner();
        let right = (frame.right() * pose.right().inverse()).into_inner();
        let (zero, one) = (T::ZERO, T::ONE);
        let coefficients = |x: Matrix3<T>| coefficients(&(right * x * left));
        let e = coefficients(Vector3::x().cross_matrix());
        // By turn of R about x, y, z, then of the baseline about y and z (both views alike).
        let by_unknown = [
            coefficients(Matrix3::from_diagonal(&Vector3::new(zero, -one, -one))),
            coefficients(Vector3::y() * Vector3::x().transpose()),
            coefficients(Vector3::z() * Vector3::x().transpose()),
            coefficients(Vector3::z().cross_matrix()),
            coefficients((-Vector3::y()).cross_matrix()),
        ];
        let m = self.matrix();
        let pull = m * e;
        let slope = Vector5::from(self.slope);
        let gradient = Vector5::from(by_unknown.map(|d: Vector9<T>| d.dot(&pull))) - slope;
        let products = by_unknown.map(|d| m * d);
        Quadratic { information: Information::of_products(&by_unknown, &products), gradient }
    }

    fn matrix(&self) -> Matrix9<T> {
        Matrix9::from_fn(|row, column| {
            let (below, above) = (row.max(column), row.min(column));
            self.products.get(below * (below + 1) / 2 + above).copied().unwrap_or(T::ZERO)
        })
    }

    /// From the lower triangle.
    fn set_matrix(&mut self, m: &Matrix9<T>) {
        let triangle = (0..9).flat_map(|row| (0..=row).map(move |column| (row, column)));
        for (element, at) in self.products.iter_mut().zip(triangle) {
            *element = m.get(at).copied().unwrap_or(T::ZERO);
        }
    }
}

/// The products `b a^T` behind the nine coordinates.
fn outer<T: Scalar>(k: &Vector9<T>) -> Matrix3<T> {
    let [cx, cy, cz, xx, yy, zz, xy, xz, yz] = (*k).into();
    let half = |sum: T| sum * T::HALF;
    Matrix3::new(
        xx,
        half(xy - cz),
        half(xz + cy),
        half(xy + cz),
        yy,
        half(yz - cx),
        half(xz - cy),
        half(yz + cx),
        zz,
    )
}

/// The nine coordinates of products `b a^T`.
fn split<T: Scalar>(b: &Matrix3<T>) -> Vector9<T> {
    Vector9::from([
        b.m32 - b.m23,
        b.m13 - b.m31,
        b.m21 - b.m12,
        b.m11,
        b.m22,
        b.m33,
        b.m12 + b.m21,
        b.m13 + b.m31,
        b.m23 + b.m32,
    ])
}

/// The factors of the nine coordinates in `b^T X a`.
fn coefficients<T: Scalar>(x: &Matrix3<T>) -> Vector9<T> {
    let half = |sum: T| sum * T::HALF;
    Vector9::from([
        half(x.m32 - x.m23),
        half(x.m13 - x.m31),
        half(x.m21 - x.m12),
        x.m11,
        x.m22,
        x.m33,
        half(x.m12 + x.m21),
        half(x.m13 + x.m31),
        half(x.m23 + x.m32),
    ])
}

#[cfg(test)]
mod tests;
