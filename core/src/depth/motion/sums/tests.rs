//! Tests of the equations of a tracked match.

use super::*;
use crate::geometry::lens_correction::LensCorrection;
use nalgebra::{Matrix3, SMatrix};

#[test]
fn inverse_matches_the_full_matrix_and_is_refused_without_one() {
    let [xx, xy, xz, yy, yz, zz] = [1.3, 0.2, 0.9, 1.1, -0.1, 2.4];
    let c = Symmetric3 { xx, xy, xz, yy, yz, zz };
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let full = |c: &Symmetric3<f64>| Matrix3::from(columns.map(|axis| c.times(axis)));
    let product = full(&c) * full(&c.inverse(0.25).unwrap()) * 4.0;
    assert!((product - Matrix3::identity()).norm() < 1e-12, "{product}");
    assert!(c.scaled(-1.0).inverse(1.0).is_none());
    assert!(c.scaled(f64::NAN).inverse(1.0).is_none());
}

#[test]
fn sums_of_a_match_equal_central_differences() {
    let r = so3::exp(&Vector3::new(0.02, -0.05, 0.03)).unwrap();
    let t = Vector3::new(-1.0, 0.05, 0.02).normalize();
    let pose = &RectifyingRotations::from(&Extrinsics::try_new(r.matrix(), &t).unwrap());
    let change = LensCorrection::NONE.change_to(&LensCorrection { focal: 0.002, k1: 0.01 });
    let views = Views { pose, change, noise: 3e-4 };
    let pair = |left, right| RayPair::try_new(left, right).unwrap();
    let both = [pair([0.4, -0.3], [0.26, -0.29]), pair([0.45, -0.35], [0.25, -0.33])];
    let mut motion = Motion::NONE;
    motion.take(&[0.01, -0.02, 0.03, 0.4, 0.1, -1.5, 0.005]).unwrap();
    let equations = |motion: &Motion<f64>| {
        let left = views.left_after(motion.turn).unwrap();
        let [one, two] = both.each_ref().map(|pair| views.of(&left, pair).unwrap());
        Equations::of(motion, &one, &two, views.noise).unwrap()
    };
    let mut by = [[0.0; 3]; UNKNOWNS];
    for (i, by) in by.iter_mut().enumerate() {
        let moved = |by: f64| {
            let (mut step, mut motion) = ([0.0; UNKNOWNS], motion);
            step[i] = by;
            motion.take(&step).unwrap();
            equations(&motion).off
        };
        *by = difference(moved(-1e-5), moved(1e-5)).map(|x| x / 2e-5);
    }
    let by = SMatrix::<f64, 3, UNKNOWNS>::from(by);
    let of = equations(&motion);
    let inverse = of.covariance.inverse(1.0).unwrap();
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let weights = Matrix3::from(axes.map(|axis| inverse.times(axis)));
    let (normal, right) =
        (by.transpose() * weights * by, by.transpose() * weights * Vector3::from(of.off));
    let zeros = [[0.0; COLUMNS]; UNKNOWNS];
    let mut sums = Sums { rows: zeros, inliers: [0; 2], squared: 0.0 };
    sums.add(&of, 1.0, 0.0);
    for (i, row) in sums.rows.iter().enumerate() {
        for j in i..UNKNOWNS {
            assert!((row[j] - normal[(i, j)]).abs() < 1e-7, "{i} {j} {row:?} {normal}");
        }
        assert!((row[UNKNOWNS] - right[i]).abs() < 1e-7, "{i} {row:?} {right}");
    }
}
