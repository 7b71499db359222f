//! Moments in another rectified frame: the nine products are bilinear in the two rays, and turn with both.

use nalgebra::{Matrix3, Rotation3};

use super::moments::{Moments, Vector9};
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3::product;
use crate::scalar::Scalar;

impl<T: Scalar> Moments<T> {
    /// Transforms the sums into the rectified frame of another pose.
    #[inline(never)]
    pub(crate) fn change_frame(
        &mut self,
        from: &RectifyingRotations<T>,
        to: &RectifyingRotations<T>,
    ) {
        let less_identity = |to: &Rotation3<T>, from: &Rotation3<T>| {
            product(to.matrix(), &from.matrix().transpose()) - Matrix3::identity()
        };
        let left = less_identity(to.left(), from.left()).transpose();
        let right = less_identity(to.right(), from.right());
        let mut rows = self.rows();
        for _ in 0..2 {
            for k in &mut rows {
                turn(k, &left, &right);
            }
            transpose(&mut rows);
        }
        let triangle = rows.iter().enumerate().flat_map(|(row, k)| k.iter().take(row + 1));
        self.products.0.iter_mut().zip(triangle).for_each(|(m, turned)| *m = *turned);
    }

    /// The full symmetric matrix.
    fn rows(&self) -> [Vector9<T>; 9] {
        let mut rows = [[T::ZERO; 9]; 9];
        let mut m = self.products.0.iter();
        for (row, elements) in rows.iter_mut().enumerate() {
            elements.iter_mut().take(row + 1).zip(m.by_ref()).for_each(|(e, m)| *e = *m);
        }
        let mut left: &mut [Vector9<T>] = &mut rows;
        let mut diagonal = 0;
        while let Some((first, below)) = left.split_first_mut() {
            diagonal += 1;
            let column = below.iter().filter_map(|row| row.get(diagonal - 1));
            first.iter_mut().skip(diagonal).zip(column).for_each(|(e, below)| *e = *below);
            left = below;
        }
        rows
    }
}

fn transpose<T: Scalar>(m: &mut [Vector9<T>; 9]) {
    let mut left: &mut [Vector9<T>] = m;
    let mut diagonal = 0;
    while let Some((first, below)) = left.split_first_mut() {
        diagonal += 1;
        let column = below.iter_mut().filter_map(|row| row.get_mut(diagonal - 1));
        first
            .iter_mut()
            .skip(diagonal)
            .zip(column)
            .for_each(|(e, below)| core::mem::swap(e, below));
        left = below;
    }
}

/// Products of rotated rays. `left`, transposed, and `right` are the rotations minus the identity: small rotations keep
/// their digits.
#[inline(never)]
fn turn<T: Scalar>(k: &mut Vector9<T>, left: &Matrix3<T>, right: &Matrix3<T>) {
    let b = outer(k);
    let turned = product(right, &b);
    let moved = split(&(turned + product(&(b + turned), left)));
    k.iter_mut().zip(moved).for_each(|(k, moved)| *k += moved);
}

/// `b a^T` of nine products.
fn outer<T: Scalar>(k: &Vector9<T>) -> Matrix3<T> {
    let [cx, cy, cz, xx, yy, zz, xy, xz, yz] = *k;
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

/// Nine products of `b a^T`: `b x a` up to sign, then the symmetric part.
pub(super) fn split<T: Scalar>(b: &Matrix3<T>) -> Vector9<T> {
    [
        b.m32 - b.m23,
        b.m13 - b.m31,
        b.m21 - b.m12,
        b.m11,
        b.m22,
        b.m33,
        b.m12 + b.m21,
        b.m13 + b.m31,
        b.m23 + b.m32,
    ]
}
