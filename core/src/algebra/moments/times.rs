//! Product of the moments with a vector.

use super::{COORDINATES, Moments, PRODUCT_TRIANGLE, PRODUCTS, Vector12};
use crate::scalar::Scalar;

/// Adds rows of `M x`. Each row lists its element of `x`, its number, and the place of its diagonal element in the
/// packed triangle. For each element left of the diagonal follow its place, the element of `x` in its column, and its
/// column.
macro_rules! times_rows {
    ($m:ident, $y:ident; $($x_row:ident $row:literal $diagonal:literal: $($place:literal $x:ident $column:literal),*);+) => {$(
        let sum = T::ZERO $(+ $m[$place] * $x)*;
        $($y[$column] += $m[$place] * $x_row;)*
        $y[$row] += sum + $m[$diagonal] * $x_row;
    )+};
}

impl<T: Scalar> Moments<T> {
    /// Returns `M x`. Each element of the triangle is read once.
    #[inline(always)]
    pub(in crate::algebra) fn times(&self, x: &Vector12<T>) -> Vector12<T> {
        let mut y = self.times_without_lens(x);
        self.add_times_lens(x, &mut y);
        y
    }

    /// Adds the part of `M x` that involves coordinates of the lens.
    fn add_times_lens(&self, x: &Vector12<T>, y: &mut Vector12<T>) {
        let mut m = self.products.iter().skip(PRODUCT_TRIANGLE);
        for (row, x_row) in x.iter().enumerate().skip(PRODUCTS) {
            let mut sum = T::ZERO;
            for ((x_column, y_column), m) in x.iter().zip(&mut *y).take(row).zip(m.by_ref()) {
                sum += *m * *x_column;
                *y_column += *m * *x_row;
            }
            if let (Some(m), Some(y)) = (m.next(), y.get_mut(row)) {
                *y += sum + *m * *x_row;
            }
        }
    }

    /// Returns `M x` for the nine products alone, and zeros for the lens. Written out, so that `x` and `M x` stay in
    /// registers.
    #[rustfmt::skip]
    pub(in crate::algebra) fn times_without_lens(&self, x: &Vector12<T>) -> Vector12<T> {
        let m = &self.products;
        let [a, b, c, d, e, f, g, h, i, ..] = *x;
        let mut y = [T::ZERO; COORDINATES];
        times_rows!(m, y;
            a 0 0: ;
            b 1 2: 1 a 0;
            c 2 5: 3 a 0, 4 b 1;
            d 3 9: 6 a 0, 7 b 1, 8 c 2;
            e 4 14: 10 a 0, 11 b 1, 12 c 2, 13 d 3;
            f 5 20: 15 a 0, 16 b 1, 17 c 2, 18 d 3, 19 e 4;
            g 6 27: 21 a 0, 22 b 1, 23 c 2, 24 d 3, 25 e 4, 26 f 5;
            h 7 35: 28 a 0, 29 b 1, 30 c 2, 31 d 3, 32 e 4, 33 f 5, 34 g 6;
            i 8 44: 36 a 0, 37 b 1, 38 c 2, 39 d 3, 40 e 4, 41 f 5, 42 g 6, 43 h 7
        );
        y
    }
}
