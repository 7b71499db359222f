//! Essential matrices through five correspondences.
//!
//! H. Stewenius, C. Engels and D. Nister, "Recent developments on direct relative orientation", 2006. `E` lies in the
//! null space of five epipolar constraints, which leaves three unknowns. `det E = 0` and `2 E E^T E - tr(E E^T) E = 0`
//! are ten cubic equations in them. Their solutions are eigenvectors of a 10 x 10 action matrix.

use nalgebra::{Matrix3, SMatrix, SVector, Schur};

use rigs::data::Rays;

/// Monomials of degree 3 in x, y, z, then of degree 2, then x, y, z, 1: exponents.
const MONOMIALS: [[usize; 3]; 20] = [
    [3, 0, 0],
    [2, 1, 0],
    [2, 0, 1],
    [1, 2, 0],
    [1, 1, 1],
    [1, 0, 2],
    [0, 3, 0],
    [0, 2, 1],
    [0, 1, 2],
    [0, 0, 3],
    [2, 0, 0],
    [1, 1, 0],
    [1, 0, 1],
    [0, 2, 0],
    [0, 1, 1],
    [0, 0, 2],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [0, 0, 0],
];

/// Index of a monomial by its exponents; 20 for other exponents.
const INDEX: [[[usize; 4]; 4]; 4] = {
    let mut index = [[[MONOMIALS.len(); 4]; 4]; 4];
    let mut i = 0;
    while i < MONOMIALS.len() {
        let [x, y, z] = MONOMIALS[i];
        index[x][y][z] = i;
        i += 1;
    }
    index
};

/// First monomial of degree 1, and of degree 2.
const LINEAR: usize = 16;
const QUADRATIC: usize = 10;

/// Largest number of iterations for the eigenvalues, and for the singular values.
const SWEEPS: usize = 200;

/// An imaginary part below this, relative to 1 plus the magnitude of the real part, is rounding.
const REAL: f64 = 1e-6;

/// A polynomial of degree at most 3, by its coefficients.
type Cubic = SVector<f64, 20>;

/// The essential matrices of five correspondences, at most ten; their norm is 1. One of them is the true one up to sign
/// and noise if all five correspondences are true.
pub(super) fn five_point(sample: &[Rays; 5]) -> Vec<Matrix3<f64>> {
    essentials(sample).unwrap_or_default()
}

fn essentials(sample: &[Rays; 5]) -> Option<Vec<Matrix3<f64>>> {
    let basis = null_space(sample)?;
    let cubics = constraints(&basis);
    let leading = cubics.fixed_columns::<10>(0).into_owned();
    let reduced = leading.lu().solve(&cubics.fixed_columns::<10>(10).into_owned())?;
    // x times each monomial of degree at most 2: six products are cubic, four are in the list.
    let mut action = SMatrix::<f64, 10, 10>::zeros();
    for i in 0..6 {
        action.set_row(i, &-reduced.row(i));
    }
    for (row, monomial) in [(6, 0), (7, 1), (8, 2), (9, 6)] {
        action[(row, monomial)] = 1.0;
    }
    let eigenvalues = Schur::try_new(action, f64::EPSILON, SWEEPS)?.complex_eigenvalues();
    let real = eigenvalues.iter().filter(|x| x.im.abs() < REAL * (1.0 + x.re.abs()));
    let solutions = real.filter_map(|x| {
        let v = eigenvector(&action, x.re)?;
        let [x, y, z] = [v[6], v[7], v[8]].map(|xyz| xyz / v[9]);
        let e = basis[0] * x + basis[1] * y + basis[2] * z + basis[3];
        let e = e / e.norm();
        e.iter().all(|x| x.is_finite()).then_some(e)
    });
    Some(solutions.collect())
}

/// Four matrices whose combinations satisfy the five constraints.
fn null_space(sample: &[Rays; 5]) -> Option<[Matrix3<f64>; 4]> {
    // Padded with zeros, so that the decomposition gives the null space too.
    let mut rows = SMatrix::<f64, 9, 9>::zeros();
    for (i, [p_l, p_r]) in sample.iter().enumerate() {
        let outer = p_r * p_l.transpose();
        rows.set_row(i, &SVector::<f64, 9>::from_column_slice(outer.as_slice()).transpose());
    }
    let svd = rows.try_svd(false, true, f64::EPSILON, SWEEPS)?;
    let v_t = svd.v_t?;
    let mut order = [0, 1, 2, 3, 4, 5, 6, 7, 8];
    order.sort_by(|&i, &j| svd.singular_values[i].total_cmp(&svd.singular_values[j]));
    let matrix = |i: usize| Matrix3::from_iterator(v_t.row(order[i]).iter().copied());
    Some(std::array::from_fn(matrix))
}

/// The ten cubics, one a row.
fn constraints(basis: &[Matrix3<f64>; 4]) -> SMatrix<f64, 10, 20> {
    let element = |row: usize, column: usize| {
        let mut e = Cubic::zeros();
        basis.iter().zip(LINEAR..).for_each(|(m, i)| e[i] = m[(row, column)]);
        e
    };
    let e: [[Cubic; 3]; 3] = [0, 1, 2].map(|row| [0, 1, 2].map(|column| element(row, column)));
    let linear = |a: &Cubic, b: &Cubic| product(a, LINEAR, b, LINEAR);
    let outer = [0, 1, 2].map(|i: usize| {
        [0, 1, 2].map(|j: usize| (0..3).map(|k| linear(&e[i][k], &e[j][k])).sum::<Cubic>())
    });
    let trace = outer[0][0] + outer[1][1] + outer[2][2];
    let mut all = SMatrix::<f64, 10, 20>::zeros();
    for n in 0..9 {
        let (i, j) = (n / 3, n % 3);
        let terms = (0..3).map(|k| {
            let left = outer[i][k] * 2.0 - if i == k { trace } else { Cubic::zeros() };
            product(&left, QUADRATIC, &e[k][j], LINEAR)
        });
        all.set_row(n, &terms.sum::<Cubic>().transpose());
    }
    let minor = |a: usize, b: usize| linear(&e[1][a], &e[2][b]) - linear(&e[1][b], &e[2][a]);
    let determinant = product(&minor(1, 2), QUADRATIC, &e[0][0], LINEAR)
        + product(&minor(2, 0), QUADRATIC, &e[0][1], LINEAR)
        + product(&minor(0, 1), QUADRATIC, &e[0][2], LINEAR);
    all.set_row(9, &determinant.transpose());
    all
}

/// Product of polynomials whose first monomials are `from_a` and `from_b`.
fn product(a: &Cubic, from_a: usize, b: &Cubic, from_b: usize) -> Cubic {
    let mut product = Cubic::zeros();
    for i in from_a..MONOMIALS.len() {
        for j in from_b..MONOMIALS.len() {
            let [x, y, z] = std::array::from_fn(|k| MONOMIALS[i][k] + MONOMIALS[j][k]);
            product[INDEX[x][y][z]] += a[i] * b[j];
        }
    }
    product
}

/// An eigenvector by two steps of inverse iteration.
fn eigenvector(action: &SMatrix<f64, 10, 10>, eigenvalue: f64) -> Option<SVector<f64, 10>> {
    // Slightly off the eigenvalue, so that the matrix is not singular.
    let shift = eigenvalue + 1e-10 * (1.0 + eigenvalue.abs());
    let shifted = (action - SMatrix::identity() * shift).lu();
    let once = shifted.solve(&SVector::repeat(1.0))?.normalize();
    shifted.solve(&once)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::pose::Pose;
    use sim::synth::{Scene, rig};

    #[test]
    fn one_solution_of_five_true_correspondences_is_the_true_matrix() {
        let rig = rig([4.0, -3.0, 2.0], [6.0, -5.0]).unwrap();
        let scene = Scene { rig, noise_px: 0.0, matches: 5, ..Scene::default() };
        let truth = Pose::of(&rig).essential().e.normalize();
        for pair in scene.pairs(3).take(50) {
            let sample = std::array::from_fn(|i| scene.rays(pair.clean[i]));
            let found = five_point(&sample);
            let off = |e: &Matrix3<f64>| (e - truth).norm().min((e + truth).norm());
            let nearest = found.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-6, "{nearest} of {}", found.len());
        }
    }
}
