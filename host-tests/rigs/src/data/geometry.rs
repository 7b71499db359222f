//! Extrinsics, matrices and rays as plain numbers.

use nalgebra::{Matrix3, Vector3};
use stereo_selfcal::{Extrinsics, Scalar};

/// A 3 x 3 matrix as its rows.
pub type Rows = [[f64; 3]; 3];

/// One correspondence as rays at unit depth, `[p_l, p_r]`.
pub type Rays = [Vector3<f64>; 2];

/// The matrix of these rows.
pub fn matrix(rows: &Rows) -> Matrix3<f64> {
    Matrix3::from_row_iterator(rows.iter().flatten().copied())
}

/// The rows of a matrix.
pub fn rows(m: &Matrix3<f64>) -> Rows {
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
}

/// The same extrinsics in `f64`.
///
/// # Panics
/// If rounding moves the baseline across the least angle to an optical axis that [`Extrinsics`] allows. `Extrinsics`
/// further from this limit are valid in both scalars.
pub fn in_f64<T: Scalar>(extrinsics: &Extrinsics<T>) -> Extrinsics<f64> {
    let r = Matrix3::from_row_slice(&extrinsics.rotation_row_major().map(T::to_f64));
    let t: Vector3<f64> = extrinsics.translation().map(T::to_f64);
    Extrinsics::try_new(&r, &t).expect("valid in the other scalar")
}
