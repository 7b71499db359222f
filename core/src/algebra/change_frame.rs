//! Transformation of moments to another rectified frame.
//!
//! The nine products are linear in `B = b a^T`, which rotations of the frames map to `R_b B R_a^T`. This linear map is
//! applied to the rows of `M`, then to the columns.

use nalgebra::{Matrix3, Rotation3};

use super::moments::{COORDINATES, Moments, Vector12};
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3::product;
use crate::scalar::Scalar;

impl<T: Scalar> Moments<T> {
    /// Transforms the sums from the rectified frame of one pose to that of another. The rotation part of the gradient's
    /// offset stays unchanged. Out of line, to keep the 12 x 12 matrix off the caller's stack.
    #[inline(never)]
    pub(crate) fn change_frame(
        &mut self,
        from: &RectifyingRotations<T>,
        to: &RectifyingRotations<T>,
    ) {
        // The identity is subtracted, so that small rotations keep their digits.
        let minus_identity = |to: &Rotation3<T>, from: &Rotation3<T>| {
            product(to.matrix(), &from.matrix().transpose()) - Matrix3::identity()
        };
        let left = minus_identity(to.left(), from.left()).transpose();
        let right = minus_identity(to.right(), from.right());
        self.change_frame_of_noise(from, to);
        let mut rows = self.rows();
        for _ in 0..2 {
            for k in &mut rows {
                turn(k, &left, &right);
            }
            transpose(&mut rows);
        }
        let triangle = rows.iter().enumerate().flat_map(|(row, k)| k.iter().take(row + 1));
        self.products.iter_mut().zip(triangle).for_each(|(m, turned)| *m = *turned);
    }

    /// Returns the full symmetric matrix.
    fn rows(&self) -> [Vector12<T>; COORDINATES] {
        let mut rows = [[T::ZERO; COORDINATES]; COORDINATES];
        let mut m = self.products.iter();
        for (row, elements) in rows.iter_mut().enumerate() {
            elements.iter_mut().take(row + 1).zip(m.by_ref()).for_each(|(e, m)| *e = *m);
        }
        mirror(&mut rows, |above, below| *above = *below);
        rows
    }
}

fn transpose<T: Scalar>(m: &mut [Vector12<T>; COORDINATES]) {
    mirror(m, core::mem::swap);
}

/// Calls `f` with each element above the diagonal and its mirror image below the diagonal.
#[inline(always)]
fn mirror<T: Scalar>(m: &mut [Vector12<T>; COORDINATES], f: impl Fn(&mut T, &mut T)) {
    let mut rest: &mut [Vector12<T>] = m;
    let mut diagonal = 0;
    while let Some((first, below)) = rest.split_first_mut() {
        diagonal += 1;
        let column = below.iter_mut().filter_map(|row| row.get_mut(diagonal - 1));
        first.iter_mut().skip(diagonal).zip(column).for_each(|(above, below)| f(above, below));
        rest = below;
    }
}

/// Replaces the products of `B` by those of `(I + right) B (I + left)`, that is, of rotated rays. The derivatives with
/// respect to the lens stay unchanged, to first order.
///
/// * `left`: rotation of the left ray minus the identity, transposed; `right`: rotation of the right ray minus the
///   identity.
#[inline(never)]
fn turn<T: Scalar>(k: &mut Vector12<T>, left: &Matrix3<T>, right: &Matrix3<T>) {
    let b = outer(k);
    let turned = product(right, &b);
    let moved = split(&plus(&turned, &product(&plus(&b, &turned), left)));
    k.iter_mut().zip(moved).for_each(|(k, moved)| *k += moved);
}

/// Returns the sum. Written out, because at opt-level "s" the compiler does not unroll the generic sum.
#[rustfmt::skip]
fn plus<T: Scalar>(a: &Matrix3<T>, b: &Matrix3<T>) -> Matrix3<T> {
    Matrix3::new(
        a.m11 + b.m11, a.m12 + b.m12, a.m13 + b.m13,
        a.m21 + b.m21, a.m22 + b.m22, a.m23 + b.m23,
        a.m31 + b.m31, a.m32 + b.m32, a.m33 + b.m33,
    )
}

/// Returns `B` from its nine products; inverse of [`split`].
#[rustfmt::skip]
fn outer<T: Scalar>(k: &Vector12<T>) -> Matrix3<T> {
    let [cx, cy, cz, xx, yy, zz, xy, xz, yz, ..] = *k;
    let half = |sum: T| sum * T::HALF;
    Matrix3::new(
        xx, half(xy - cz), half(xz + cy),
        half(xy + cz), yy, half(yz - cx),
        half(xz - cy), half(yz + cx), zz,
    )
}

/// Returns the nine products of `B = b a^T`: the antisymmetric part `a x b`, then the symmetric part.
#[rustfmt::skip]
pub(super) fn split<T: Scalar>(b: &Matrix3<T>) -> [T; 9] {
    [
        b.m32 - b.m23, b.m13 - b.m31, b.m21 - b.m12,
        b.m11, b.m22, b.m33,
        b.m12 + b.m21, b.m13 + b.m31, b.m23 + b.m32,
    ]
}
