//! Moments of a prior: the moments of five virtual correspondences with a given information on the extrinsics and a
//! given response to the lens (`ESTIMATOR.md`, section 21).
//!
//! Let `k` be the twelve coordinates of a correspondence in the rectified frame of the estimate. The constraint has the
//! derivatives `d_i^T k` with respect to the unknowns, and `l^T k` with respect to a lens parameter. The response `E`
//! (5 x 12) is the regression of the coordinates on the unknowns, `E = H^-1 D^T M`, with the noise of disparities
//! included in `H`, so `E D = I`. The moments `M' = E^T H E` give the information `D^T M' D = H` and the mixed
//! information `D^T M' l = H E l = D^T M l`, where `M` are the moments of the original sums. So a lens error moves the
//! estimate by the same amount with `M'` as with `M`.
//!
//! `E D = I` fixes five of the twelve columns of `E`, and the column of the residual is zero at the optimum. The other
//! six columns are free.

use nalgebra::Vector5;

use super::disparity_noise::{BaselineNoise, BiasedEquations};
use super::information::Information;
use super::moments::{COORDINATES, Moments};
use crate::scalar::Scalar;

/// Coordinates whose columns are free: `xx`, `yy`, `yz`, and the derivatives with respect to the lens.
const FREE: [usize; 6] = [3, 4, 8, 9, 10, 11];

/// Largest magnitude of an element of a response, rad. At this value, a lens error of 1e-3 moves the estimate by 1 rad.
pub(crate) const MAX_RESPONSE: f32 = 1e3;

/// Largest ratio of a sum of a prior to the sum of the weights. The sums cancel to the order of the weights, and at
/// this ratio the rounding errors in `f32` are 0.6 % of the weights.
const MAX_CANCELLATION: f64 = 1e5;

/// Share of [`MAX_CANCELLATION`] to which [`Response::weaken`] reduces a sum, and number of its rounds: a round may
/// reduce the sum of the weights, too.
const WEAKENED: f64 = 0.9;
const WEAKENING_ROUNDS: usize = 4;

/// Columns of `E` for the coordinates of [`FREE`], rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Response<T>(pub(crate) [[T; 5]; 6]);

impl<T: Scalar> Response<T> {
    pub(crate) const ZERO: Self = Self([[T::ZERO; 5]; 6]);

    /// Sets the response of `sums` about the pose of their frame; `None`, without a change, if the normal equations
    /// have no solution. Elements are limited to [`MAX_RESPONSE`] in magnitude.
    ///
    /// * `information`: information of the sums, 1/rad^2; `prior`: additional information on each unknown, 1/rad^2.
    #[inline(never)]
    pub(crate) fn set(
        &mut self,
        sums: &Moments<T>,
        information: &Information<T>,
        prior: T,
    ) -> Option<()> {
        let mut joint = information.0;
        joint.add_diagonal(prior);
        let factor = joint.factor(T::ZERO)?;
        for (column, coordinate) in self.0.iter_mut().zip(FREE) {
            let moved = factor.solve(&sums.by_unknowns(coordinate));
            for (to, from) in column.iter_mut().zip(moved.iter()) {
                *to = limited(*from);
            }
        }
        Some(())
    }

    /// Returns whether the sums `E^T H E` keep the digits of `H`.
    ///
    /// * `slack`: factor of the limit, for the rounding of a record.
    pub(crate) fn keeps_digits_of(&self, information: &Information<T>, slack: T) -> bool {
        let [weights, ..] = information.0.diagonal();
        let most = weights * T::lit(MAX_CANCELLATION) * slack;
        self.0.iter().all(|column| sum_of(column, information) <= most)
    }

    /// Reduces the information until the sums `E^T H E` keep its digits. A vibrating rig needs this: its vibration
    /// reduces the information on the rotation more than the information on the baseline, to which a large response
    /// belongs.
    ///
    /// Each column `e` with a sum `s = e^T H e` above a limit `m` becomes an additional error of the estimate along
    /// `e`: the covariance `H^-1 + e e^T / m` has the information `H - H e e^T H / (m + s)`, which remains positive
    /// definite, and in which the sum of the column is below `m`. This is an error of a coordinate of `m^-1/2`, far
    /// below the errors of a lens.
    pub(crate) fn weaken(&self, information: &mut Information<T>) {
        for _ in 0..WEAKENING_ROUNDS {
            let [weights, ..] = information.0.diagonal();
            let most = weights * T::lit(WEAKENED * MAX_CANCELLATION);
            for column in &self.0 {
                let sum = sum_of(column, information);
                if sum > most {
                    let [pull] = information.times(&Vector5::from(*column)).data.0;
                    information.0.add_outer_out_of_line(-T::ONE / (most + sum), &pull);
                }
            }
        }
    }

    /// Returns the column of each coordinate, in the order `cx cy cz xx yy zz xy xz yz`, then the lens.
    fn columns(&self) -> [[T; 5]; COORDINATES] {
        let [xx, yy, yz, k1_l, k1_r, p1] = self.0;
        let (zero, one) = (T::ZERO, T::ONE);
        let two = one + one;
        let ([x, others @ ..], none) = (yy, [zero; 5]);
        let mut columns = [none, none, none, xx, yy, none, none, none, yz, k1_l, k1_r, p1];
        let [_, cy, cz, _, _, zz, xy, xz, ..] = &mut columns;
        let ([.., cy_d], [.., cz_f, _]) = (cy, cz);
        (*cy_d, *cz_f) = (-one, one);
        let [zz_x, zz_others @ ..] = zz;
        *zz_x = -one - x;
        zz_others.iter_mut().zip(others).for_each(|(to, from)| *to = -from);
        let ([_, xy_y, _, xy_f, _], [_, _, xz_z, _, xz_d]) = (xy, xz);
        (*xy_y, *xy_f, *xz_z, *xz_d) = (two, -one, two, -one);
        columns
    }
}

/// Returns `e^T H e` for a column `e`.
#[inline(never)]
fn sum_of<T: Scalar>(column: &[T; 5], information: &Information<T>) -> T {
    information.0.form(column)
}

/// Limits an element to [`MAX_RESPONSE`] in magnitude; 0 if the element is not finite.
#[inline(never)]
fn limited<T: Scalar>(element: T) -> T {
    let most = T::single(MAX_RESPONSE);
    if element.is_finite() { element.clamp(-most, most) } else { T::ZERO }
}

/// Returns the scalar product of `a` and `b`.
#[inline(never)]
fn dot<T: Scalar>(a: &Vector5<T>, b: &[T; 5]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

impl<T: Scalar> Moments<T> {
    /// Sets the moments of a prior, in the rectified frame of its pose.
    ///
    /// * `of`: equations about the pose, with their noise of disparities; `response`: free columns of `E`; `squares`:
    ///   weighted sum of squared constraints, dimensionless.
    pub(crate) fn set_prior(
        &mut self,
        of: &BiasedEquations<T>,
        response: &Response<T>,
        squares: T,
    ) {
        *self = Self::ZERO;
        let columns = response.columns();
        let mut sums = self.products.iter_mut();
        for (row, column) in columns.iter().enumerate() {
            let weighted = of.normal.information.times(&Vector5::from(*column));
            let products = columns.iter().take(row.saturating_add(1)).zip(sums.by_ref());
            products.for_each(|(other, sum)| *sum = dot(&weighted, other));
        }
        if let Some(sum) = self.products.first_mut() {
            *sum = squares;
        }
        let BaselineNoise([forward, mixed, down]) = of.noise;
        self.noise = [squares, down, -mixed, forward];
        self.set_gradient(&of.normal.gradient);
    }

    /// Returns the column of `D^T M` for one coordinate, in the frame of the sums.
    fn by_unknowns(&self, coordinate: usize) -> Vector5<T> {
        let mut unit = [T::ZERO; COORDINATES];
        if let Some(one) = unit.get_mut(coordinate) {
            *one = T::ONE;
        }
        let [_, cy, cz, _, yy, zz, xy, xz, ..] = self.times(&unit);
        Vector5::new(-(yy + zz), (cz + xy) * T::HALF, (xz - cy) * T::HALF, cz, -cy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::normal_equations::NormalEquations;
    use crate::algebra::symmetric5::Symmetric5;
    use crate::geometry::rectification::tests::pose;

    fn prior() -> (BiasedEquations<f64>, Response<f64>) {
        let mut information = Symmetric5::of_diagonal([4e9, 3e8, 2e9, 1e6, 5e5]);
        information.add_outer(1e8, &[1.0, -0.4, 0.7, 0.02, -0.01]);
        let gradient = Vector5::new(3.0, -2.0, 1.0, -4.0, 5.0);
        let element = |i: u32| (f64::from(i) * 1.7).sin() * 3.0;
        let column = |k: u32| [0, 1, 2, 3, 4].map(|i| element(5 * k + i));
        let response = Response([0, 1, 2, 3, 4, 5].map(column));
        let normal = NormalEquations { information: Information(information), gradient };
        (BiasedEquations { normal, noise: BaselineNoise([3e5, -2e4, 1e5]) }, response)
    }

    #[test]
    fn the_sums_of_a_prior_have_its_equations_its_response_and_its_squares() {
        let ((equations, response), mut sums) = (prior(), Moments::ZERO);
        sums.set_prior(&equations, &response, 7.0);
        let rig = pose([0.02, -0.01, 0.03], [0.05, -0.04]);
        for found in [sums.biased_at_frame(), sums.in_frame_of(&rig).biased_at(&rig)] {
            let off = found.minus(&equations);
            assert!(off.normal.information.0.0.iter().all(|x| x.abs() < 1e-4), "{off:?}");
            assert!(off.noise.0.iter().all(|x| x.abs() < 1e-9), "{off:?}");
            assert!(off.normal.gradient.amax() < 1e-4, "{off:?}");
        }
        assert!((sums.in_frame_of(&rig).cost_at(&rig) - 7.0).abs() < 1e-9);
        let mut again = Response::ZERO;
        again.set(&sums, &equations.normal.information, 0.0).unwrap();
        for (a, b) in again.0.iter().flatten().zip(response.0.iter().flatten()) {
            assert!((a - b).abs() < 1e-6, "{again:?}");
        }
    }

    #[test]
    fn a_large_response_widens_the_covariance_along_itself_until_its_sum_keeps_the_digits() {
        let (BiasedEquations { normal, .. }, mut response) = prior();
        let mut information = Symmetric5::of_diagonal([4e5, 4e5, 5e5, 4e5, 1e6]);
        information.add_outer(2e5, &[1.0, 0.1, 0.2, 0.5, -0.8]);
        let information = Information(information);
        response.0[2] = [0.1, -0.7, -0.2, 370.0, -4.0];
        response.0[4] = [-1.0, 0.5, -2.0, 1000.0, -1000.0];
        let mut weak = information;
        response.weaken(&mut weak);
        let keep = [&information, &weak].map(|h| response.keeps_digits_of(h, 1.0));
        assert_eq!(keep, [false, true]);
        let wider = weak.0.inverse().unwrap().minus(&information.0.inverse().unwrap());
        for k in 0..100 {
            let direction = [1.0, 2.0, 3.0, 4.0, 5.0].map(|i| (i * f64::from(k)).sin());
            assert!(wider.form(&direction) > -1e-12, "{direction:?}");
        }
        // Without a large response nothing changes.
        let (mut same, (_, small)) = (normal.information, prior());
        small.weaken(&mut same);
        assert_eq!(same, normal.information);
    }
}
