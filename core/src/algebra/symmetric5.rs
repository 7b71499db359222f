//! Packed symmetric 5 x 5 matrices: sums of outer products, factorisations, inverses.
//!
//! The code is written out, because at opt-level "s" loops over generic matrices cost many times as much.

use nalgebra::{Matrix5, Vector5};

use crate::scalar::Scalar;

/// Lower triangle row by row: element `(i, k)`, `k <= i`, at index `i (i + 1) / 2 + k`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Symmetric5<T>(pub(crate) [T; 15]);

/// Factors of `M = L D L^T`; `L` has a unit diagonal. The factorisation needs no square roots, and its accuracy does
/// not depend on the units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Factor<T> {
    /// Elements below the diagonal of `L`, row by row.
    lower: [T; 10],
    /// `1 / D`.
    inverse_pivots: [T; 5],
}

impl<T: Scalar> Symmetric5<T> {
    pub(crate) const ZERO: Self = Self([T::ZERO; 15]);

    /// Packs the lower triangle of a full matrix.
    pub(crate) fn packed(m: &Matrix5<T>) -> Self {
        let [c0, c1, c2, c3, c4] = m.data.0;
        let ([a0, a1, a2, a3, a4], [_, b1, b2, b3, b4]) = (c0, c1);
        let ([_, _, d2, d3, d4], [_, _, _, e3, e4]) = (c2, c3);
        let [.., f4] = c4;
        Self([a0, a1, b1, a2, b2, d2, a3, b3, d3, e3, a4, b4, d4, e4, f4])
    }

    /// Returns the quadratic form `x^T M x`.
    #[inline(always)]
    pub(crate) fn form(&self, x: &[T; 5]) -> T {
        let (h, [a, b, c, d, e]) = (&self.0, *x);
        let of_c = h[3] * a + h[4] * b;
        let of_d = h[6] * a + h[7] * b + h[8] * c;
        let of_e = h[10] * a + h[11] * b + h[12] * c + h[13] * d;
        let twice = h[1] * a * b + c * of_c + d * of_d + e * of_e;
        let squares = a * a * h[0] + b * b * h[2] + c * c * h[5] + d * d * h[9] + e * e * h[14];
        squares + (twice + twice)
    }

    /// Returns the five elements of the diagonal.
    pub(crate) fn diagonal(&self) -> [T; 5] {
        let h = &self.0;
        [h[0], h[2], h[5], h[9], h[14]]
    }

    /// Returns a diagonal matrix.
    pub(crate) fn of_diagonal([a, b, c, d, e]: [T; 5]) -> Self {
        let mut m = Self::ZERO;
        let h = &mut m.0;
        (h[0], h[2], h[5], h[9], h[14]) = (a, b, c, d, e);
        m
    }

    /// Adds `w j j^T`.
    #[inline(always)]
    #[rustfmt::skip]
    pub(crate) fn add_outer(&mut self, w: T, j: &[T; 5]) {
        let [j0, j1, j2, j3, j4] = *j;
        let [w0, w1, w2, w3, w4] = [w * j0, w * j1, w * j2, w * j3, w * j4];
        let h = &mut self.0;
        h[0] += w0 * j0;
        h[1] += w1 * j0; h[2] += w1 * j1;
        h[3] += w2 * j0; h[4] += w2 * j1; h[5] += w2 * j2;
        h[6] += w3 * j0; h[7] += w3 * j1; h[8] += w3 * j2; h[9] += w3 * j3;
        h[10] += w4 * j0; h[11] += w4 * j1; h[12] += w4 * j2; h[13] += w4 * j3; h[14] += w4 * j4;
    }

    /// Adds as [`Self::add_outer`], out of line, for calls outside the loops over matches.
    #[inline(never)]
    pub(crate) fn add_outer_out_of_line(&mut self, w: T, j: &[T; 5]) {
        self.add_outer(w, j);
    }

    /// Adds the lower triangle of `a b^T`. The sum of all terms that a caller adds must be symmetric.
    #[rustfmt::skip]
    pub(crate) fn add_symmetric(&mut self, a: &[T; 5], b: &[T; 5]) {
        let ([a0, a1, a2, a3, a4], [b0, b1, b2, b3, b4]) = (*a, *b);
        let terms = [
            a0 * b0, a1 * b0, a1 * b1, a2 * b0, a2 * b1, a2 * b2, a3 * b0, a3 * b1, a3 * b2,
            a3 * b3, a4 * b0, a4 * b1, a4 * b2, a4 * b3, a4 * b4,
        ];
        self.0.iter_mut().zip(terms).for_each(|(h, term)| *h += term);
    }

    /// Adds another matrix.
    #[inline(never)]
    pub(crate) fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a += *b);
    }

    /// Adds `value I`.
    pub(crate) fn add_diagonal(&mut self, value: T) {
        let h = &mut self.0;
        for i in [0, 2, 5, 9, 14] {
            if let Some(h) = h.get_mut(i) {
                *h += value;
            }
        }
    }

    /// Returns the sum of two matrices.
    #[must_use]
    #[inline(never)]
    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.add(other);
        self
    }

    /// Returns the difference of two matrices.
    #[must_use]
    pub(crate) fn minus(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a -= *b);
        self
    }

    /// Returns `factor M`.
    #[must_use]
    #[inline(never)]
    pub(crate) fn scaled(mut self, factor: T) -> Self {
        self.0.iter_mut().for_each(|h| *h *= factor);
        self
    }

    /// Replaces the variance of yaw (the unknown at index 1), and multiplies its covariances with the other unknowns by
    /// a gain.
    ///
    /// * `gain`: gain of the covariances, dimensionless; `variance`: new variance of yaw, rad^2.
    pub(crate) fn set_yaw(&mut self, gain: T, variance: T) {
        let [_, with_pitch, own, _, with_roll, _, _, with_forward, _, _, _, with_down, ..] =
            &mut self.0;
        for mixed in [with_pitch, with_roll, with_forward, with_down] {
            *mixed *= gain;
        }
        *own = variance;
    }

    /// Returns `M x`.
    #[inline(never)]
    pub(crate) fn times(&self, x: &Vector5<T>) -> Vector5<T> {
        let h = &self.0;
        let [[a, b, c, d, e]] = x.data.0;
        Vector5::new(
            h[0] * a + h[1] * b + h[3] * c + h[6] * d + h[10] * e,
            h[1] * a + h[2] * b + h[4] * c + h[7] * d + h[11] * e,
            h[3] * a + h[4] * b + h[5] * c + h[8] * d + h[12] * e,
            h[6] * a + h[7] * b + h[8] * c + h[9] * d + h[13] * e,
            h[10] * a + h[11] * b + h[12] * c + h[13] * d + h[14] * e,
        )
    }

    /// Returns the trace of the product of two matrices.
    pub(crate) fn dot(&self, other: &Self) -> T {
        let products = self.0.iter().zip(&other.0);
        let all = products.fold(T::ZERO, |sum, (a, b)| sum + *a * *b);
        let diagonals = self.diagonal().into_iter().zip(other.diagonal());
        diagonals.fold(all + all, |sum, (a, b)| sum - a * b)
    }

    /// Returns the full matrix.
    pub(crate) fn matrix(&self) -> Matrix5<T> {
        let h = &self.0;
        Matrix5::new(
            h[0], h[1], h[3], h[6], h[10], //
            h[1], h[2], h[4], h[7], h[11], //
            h[3], h[4], h[5], h[8], h[12], //
            h[6], h[7], h[8], h[9], h[13], //
            h[10], h[11], h[12], h[13], h[14],
        )
    }

    /// Returns `M^-1`; `None` if the matrix is not positive definite.
    pub(crate) fn inverse(&self) -> Option<Self> {
        Some(self.factor(T::ZERO)?.inverse())
    }

    /// Returns `x^T M^-1 x`; `None` if the matrix is not positive definite or the result is not finite.
    #[inline(never)]
    pub(crate) fn inverse_form(&self, x: &Vector5<T>) -> Option<T> {
        let form = x.dot(&self.factor(T::ZERO)?.solve(x));
        form.is_finite().then_some(form)
    }

    /// Returns the factors of `M + damping diag M`; `None` if a pivot is not positive or not finite.
    ///
    /// Out of line, to keep its temporaries off the caller's stack. Cost: five divisions.
    #[inline(never)]
    pub(crate) fn factor(&self, damping: T) -> Option<Factor<T>> {
        let h = &self.0;
        let one = T::ONE + damping;
        // The test is written so that a NaN fails it.
        let inverse_pivot = |d: T| (d > T::ZERO && d.is_finite()).then(|| T::ONE / d);
        let i0 = inverse_pivot(one * h[0])?;
        let [l10, l20, l30, l40] = [h[1] * i0, h[3] * i0, h[6] * i0, h[10] * i0];
        let i1 = inverse_pivot(one * h[2] - l10 * h[1])?;
        let c21 = h[4] - l20 * h[1];
        let c31 = h[7] - l30 * h[1];
        let c41 = h[11] - l40 * h[1];
        let [l21, l31, l41] = [c21 * i1, c31 * i1, c41 * i1];
        let i2 = inverse_pivot(one * h[5] - l20 * h[3] - l21 * c21)?;
        let c32 = h[8] - l30 * h[3] - l31 * c21;
        let c42 = h[12] - l40 * h[3] - l41 * c21;
        let [l32, l42] = [c32 * i2, c42 * i2];
        let i3 = inverse_pivot(one * h[9] - l30 * h[6] - l31 * c31 - l32 * c32)?;
        let c43 = h[13] - l40 * h[6] - l41 * c31 - l42 * c32;
        let l43 = c43 * i3;
        let i4 = inverse_pivot(one * h[14] - l40 * h[10] - l41 * c41 - l42 * c42 - l43 * c43)?;
        Some(Factor {
            lower: [l10, l20, l21, l30, l31, l32, l40, l41, l42, l43],
            inverse_pivots: [i0, i1, i2, i3, i4],
        })
    }
}

impl<T: Scalar> Factor<T> {
    /// Returns the factors of the marginal of the last two unknowns `K = L D L^T`, that is, of `M` without the other
    /// unknowns: the first pivot, the element of `L` below the diagonal, and the second pivot. Both pivots are above 0.
    pub(crate) fn of_last_two(&self) -> [T; 3] {
        let ([.., below], [.., first, second]) = (self.lower, self.inverse_pivots);
        [T::ONE / first, below, T::ONE / second]
    }

    /// Returns `M^-1 x` by forward and back substitution, without a division.
    #[inline(never)]
    pub(crate) fn solve(&self, x: &Vector5<T>) -> Vector5<T> {
        let [l10, l20, l21, l30, l31, l32, l40, l41, l42, l43] = self.lower;
        let [i0, i1, i2, i3, i4] = self.inverse_pivots;
        let [[x0, x1, x2, x3, x4]] = x.data.0;
        let y1 = x1 - l10 * x0;
        let y2 = x2 - l20 * x0 - l21 * y1;
        let y3 = x3 - l30 * x0 - l31 * y1 - l32 * y2;
        let z4 = (x4 - l40 * x0 - l41 * y1 - l42 * y2 - l43 * y3) * i4;
        let z3 = y3 * i3 - l43 * z4;
        let z2 = y2 * i2 - l32 * z3 - l42 * z4;
        let z1 = y1 * i1 - l21 * z2 - l31 * z3 - l41 * z4;
        let z0 = x0 * i0 - l10 * z1 - l20 * z2 - l30 * z3 - l40 * z4;
        Vector5::new(z0, z1, z2, z3, z4)
    }

    /// Returns `M^-1 = L^-T D^-1 L^-1`.
    #[rustfmt::skip]
    pub(crate) fn inverse(&self) -> Symmetric5<T> {
        let [l10, l20, l21, l30, l31, l32, l40, l41, l42, l43] = self.lower;
        let [i0, i1, i2, i3, i4] = self.inverse_pivots;
        // `m`: elements of `-L^-1` below the diagonal; `n`: elements of `D^-1` times `m`.
        let [m10, m21, m32, m43] = [l10, l21, l32, l43];
        let m20 = l20 - l21 * m10;
        let m31 = l31 - l32 * m21;
        let m42 = l42 - l43 * m32;
        let m30 = l30 - l31 * m10 - l32 * m20;
        let m41 = l41 - l42 * m21 - l43 * m31;
        let m40 = l40 - l41 * m10 - l42 * m20 - l43 * m30;
        let n10 = i1 * m10;
        let [n20, n21] = [i2 * m20, i2 * m21];
        let [n30, n31, n32] = [i3 * m30, i3 * m31, i3 * m32];
        let [n40, n41, n42, n43] = [i4 * m40, i4 * m41, i4 * m42, i4 * m43];
        Symmetric5([
            i0 + m10 * n10 + m20 * n20 + m30 * n30 + m40 * n40,
            m21 * n20 + m31 * n30 + m41 * n40 - n10,
            i1 + m21 * n21 + m31 * n31 + m41 * n41,
            m32 * n30 + m42 * n40 - n20,
            m32 * n31 + m42 * n41 - n21,
            i2 + m32 * n32 + m42 * n42,
            m43 * n40 - n30,
            m43 * n41 - n31,
            m43 * n42 - n32,
            i3 + m43 * n43,
            -n40, -n41, -n42, -n43, i4,
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Rows = [[f64; 5]; 7];

    fn rows() -> impl Strategy<Value = Rows> {
        proptest::array::uniform7(proptest::array::uniform5(-1.0..1.0_f64))
    }

    /// Returns the sum of seven outer products whose columns differ greatly in size, as a packed matrix and by
    /// nalgebra.
    fn sums(rows: &Rows) -> (Symmetric5<f64>, Matrix5<f64>) {
        let (mut packed, mut full) = (Symmetric5::ZERO, Matrix5::zeros());
        for (row, w) in rows.iter().zip([1.0, 0.5, 2.0, 3.0, 1.0, 0.25, 1.0]) {
            let [a, b, c, d, e] = *row;
            let j = [a * 1e-3, b, c * 1e2, d, e * 10.0];
            packed.add_outer(w, &j);
            full += Vector5::from(j) * Vector5::from(j).transpose() * w;
        }
        (packed, full)
    }

    proptest! {
        #[test]
        fn products_match_the_full_matrix(rows in rows(), x in proptest::array::uniform5(-1.0..1.0_f64)) {
            let (packed, full) = sums(&rows);
            let v = Vector5::from(x);
            prop_assert!((packed.matrix() - full).amax() <= 1e-12 * full.amax());
            prop_assert!((packed.times(&v) - full * v).amax() <= 1e-12 * full.amax());
            prop_assert!((packed.form(&x) - v.dot(&(full * v))).abs() <= 1e-12 * full.amax());
            prop_assert!((packed.dot(&packed) - full.dot(&full)).abs() <= 1e-12 * full.norm_squared());
        }

        #[test]
        fn inverse_and_solution_match_the_definition(rows in rows(), x in proptest::array::uniform5(-1.0..1.0_f64)) {
            let (packed, full) = sums(&rows);
            let scale = full.diagonal().map(|d| 1.0 / d.sqrt());
            let unit = full.component_mul(&(scale * scale.transpose()));
            let smallest = unit.symmetric_eigen().eigenvalues.min();
            prop_assume!(smallest > 1e-4);
            let inverse = packed.inverse().unwrap();
            let unit_inverse = inverse.matrix().component_div(&(scale * scale.transpose()));
            prop_assert!((unit * unit_inverse - Matrix5::identity()).amax() < 1e-9);
            let v = Vector5::from(x);
            let solved = packed.factor(0.0).unwrap().solve(&v);
            let gap = (inverse.times(&v) - solved).component_div(&scale);
            prop_assert!(gap.amax() < 1e-9 * v.component_mul(&scale).amax());
            let form = packed.inverse_form(&v).unwrap();
            prop_assert!((form - v.dot(&solved)).abs() <= 1e-12 * form.abs());
            let [first, below, second] = packed.factor(0.0).unwrap().of_last_two();
            let marginal = [first, below * first, below * below * first + second];
            let block = inverse.matrix().fixed_view::<2, 2>(3, 3).try_inverse().unwrap();
            let expected = [block.m11, block.m21, block.m22];
            for (ours, expected) in marginal.iter().zip(expected) {
                prop_assert!((ours - expected).abs() < 1e-6 * (block.m11 + block.m22), "{block}");
            }
        }
    }

    #[test]
    fn matrices_that_are_not_positive_definite_have_no_inverse() {
        let unit = Symmetric5::<f64>::of_diagonal([1.0; 5]);
        let mut indefinite = unit;
        indefinite.0[1] = 2.0;
        let mut dependent = unit;
        dependent.0[1] = 1.0;
        for none in [
            Symmetric5::ZERO,
            Symmetric5::of_diagonal([f64::NAN; 5]),
            Symmetric5::of_diagonal([1.0, 1.0, -1.0, 1.0, 1.0]),
            indefinite,
            dependent,
        ] {
            assert_eq!(none.inverse(), None);
            assert_eq!(none.inverse_form(&Vector5::repeat(1.0)), None);
        }
        assert_eq!(unit.scaled(4.0).inverse_form(&Vector5::repeat(1.0)), Some(1.25));
    }

    #[test]
    fn damping_adds_its_part_of_the_diagonal() {
        let (packed, full) = sums(&core::array::from_fn(|i| {
            core::array::from_fn(|k| if i == k { 1.0 } else { 0.1 })
        }));
        let x = Vector5::new(1.0, -2.0, 0.5, 3.0, -0.1);
        let solved = packed.factor(0.5).unwrap().solve(&x);
        let damped = full + Matrix5::from_diagonal(&(full.diagonal() * 0.5));
        assert!((damped * solved - x).amax() < 1e-12);
    }
}
