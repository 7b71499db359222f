//! Sums of outer products over correspondences.

use super::{COORDINATES, Moments};
use crate::scalar::Scalar;

/// Adds some rows of `w` times an outer product. Written out, because at opt-level "s" a loop takes twice the
/// instructions.
macro_rules! add_rows {
    ($sums:ident, $w:ident; $($row:ident: $($place:literal $column:ident),+);+) => {$(
        let weighted = $w * $row;
        $($sums[$place] += weighted * $column;)+
    )+};
}

impl<T: Scalar> Moments<T> {
    /// Adds correspondences in order, one tile of the triangle after the other, so that each sum is loaded and stored
    /// once. The sums and coordinates of a tile fit into the 32 floating-point registers of a controller; those of a
    /// larger tile would not.
    ///
    /// * `rows`: weight and coordinates `k` of each correspondence. The weight is `w f^2 / V`, dimensionless: the
    ///   weight from the loss, 1/px^2, over the variance of the constraint for coordinates with a variance of 1 px^2.
    pub(crate) fn add_rows<'r>(
        &mut self,
        rows: impl Iterator<Item = (T, &'r [T; COORDINATES])> + Clone,
    ) {
        rows.clone().for_each(|(w, k)| self.add_tile::<0>(w, k));
        rows.clone().for_each(|(w, k)| self.add_tile::<1>(w, k));
        rows.clone().for_each(|(w, k)| self.add_tile::<2>(w, k));
        rows.clone().for_each(|(w, k)| self.add_tile::<3>(w, k));
        rows.for_each(|(w, k)| self.add_tile::<4>(w, k));
    }

    /// Adds one correspondence to tile `G` of the triangle. The tiles hold 21, 17, 17, 11 and 12 sums.
    #[inline(always)]
    #[rustfmt::skip]
    fn add_tile<const G: usize>(
        &mut self,
        w: T,
        &[a, b, c, d, e, f, g, h, i, j, k, l]: &[T; COORDINATES],
    ) {
        let m = &mut self.products;
        match G {
            0 => { add_rows!(m, w;
                a: 0 a; b: 1 a, 2 b; c: 3 a, 4 b, 5 c; d: 6 a, 7 b, 8 c, 9 d;
                e: 10 a, 11 b, 12 c, 13 d, 14 e; f: 15 a, 16 b, 17 c, 18 d, 19 e, 20 f); }
            1 => { add_rows!(m, w;
                h: 28 a, 29 b, 30 c, 31 d, 32 e, 33 f, 34 g, 35 h;
                i: 36 a, 37 b, 38 c, 39 d, 40 e, 41 f, 42 g, 43 h, 44 i); }
            2 => { add_rows!(m, w;
                g: 21 a, 22 b, 23 c, 24 d, 25 e, 26 f, 27 g;
                j: 45 a, 46 b, 47 c, 48 d, 49 e, 50 f, 51 g, 52 h, 53 i, 54 j); }
            3 => { add_rows!(m, w;
                k: 55 a, 56 b, 57 c, 58 d, 59 e, 60 f, 61 g, 62 h, 63 i, 64 j, 65 k); }
            _ => { add_rows!(m, w;
                l: 66 a, 67 b, 68 c, 69 d, 70 e, 71 f, 72 g, 73 h, 74 i, 75 j, 76 k, 77 l); }
        }
    }
}
