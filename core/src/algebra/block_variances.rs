//! Variances of a random effect on the extrinsics: one for the three rotations of `R`, one for the two angles of the
//! baseline.

use nalgebra::Vector5;

use super::information::Information;
use super::normal_equations::NormalEquations;
use super::symmetric5::Symmetric5;
use crate::scalar::Scalar;
use crate::thresholds::{MAX_TURN_RATIO, MIN_BLOCK_VARIANCE, TURN_RAD, VIBRATION_RAD};

/// `Q`, a diagonal covariance with two different values, rad^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BlockVariances<T> {
    /// Variance of `R` about each axis.
    pub(crate) rotation: T,
    /// Variance of the baseline about each axis.
    pub(crate) baseline: T,
}

impl<T: Scalar> BlockVariances<T> {
    pub(crate) const ZERO: Self = Self { rotation: T::ZERO, baseline: T::ZERO };

    pub(crate) fn is_zero(&self) -> bool {
        self.rotation == T::ZERO && self.baseline == T::ZERO
    }

    pub(crate) fn scaled(&self, factor: T) -> Self {
        self.map(|variance| variance * factor)
    }

    /// Returns both variances, each at least [`VIBRATION_RAD`] squared.
    pub(crate) fn at_least_rigid(&self) -> Self {
        self.map(|variance| variance.max(T::lit(VIBRATION_RAD * VIBRATION_RAD)))
    }

    /// Returns the larger of both variances, of this one and of `other`, for each block.
    pub(crate) fn at_least(&self, other: &Self) -> Self {
        let Self { rotation, baseline } = *self;
        Self { rotation: rotation.max(other.rotation), baseline: baseline.max(other.baseline) }
    }

    /// Returns the variance of `R`, rad^2, minus the variance of a rig at rest ([`VIBRATION_RAD`] squared), if
    /// rotations of the cameras explain both variances; otherwise 0. A camera rotation moves the baseline about as much
    /// as `R`. A wrong lens or a rolling shutter scatters the baseline far more than `R`, or scatters `R` by no more
    /// than [`TURN_RAD`].
    pub(crate) fn of_turns(&self) -> T {
        let Self { rotation, baseline } = *self;
        let turns = rotation > T::lit(TURN_RAD * TURN_RAD)
            && baseline <= rotation * T::lit(MAX_TURN_RATIO * MAX_TURN_RATIO);
        if turns { self.minus(&Self::ZERO.at_least_rigid()).rotation } else { T::ZERO }
    }

    /// Returns the variances minus those of `other`, each at least 0.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        let Self { rotation, baseline } = *self;
        Self {
            rotation: (rotation - other.rotation).max(T::ZERO),
            baseline: (baseline - other.baseline).max(T::ZERO),
        }
    }

    /// Returns whether at least one variance is at least twice that of `other`.
    pub(crate) fn doubles(&self, other: &Self) -> bool {
        let two = T::lit(2.0);
        self.rotation >= two * other.rotation || self.baseline >= two * other.baseline
    }

    fn map(&self, f: impl Fn(T) -> T) -> Self {
        Self { rotation: f(self.rotation), baseline: f(self.baseline) }
    }

    /// Returns the variance of each unknown, rad^2.
    pub(crate) fn diagonal(&self) -> [T; 5] {
        let Self { rotation: r, baseline: b } = *self;
        [r, r, r, b, b]
    }

    /// Adds `Q` to a covariance.
    pub(crate) fn add_to(&self, covariance: &mut Symmetric5<T>) {
        covariance.add(&Symmetric5::of_diagonal(self.diagonal()));
    }

    /// Returns `L Q L`: the covariance that the random effect adds to the gradient of a pair with the information `L`.
    pub(crate) fn scatter_of_gradient(&self, information: &Information<T>) -> Information<T> {
        let mut scatter = Information::ZERO;
        let mut unit = Vector5::zeros();
        for (axis, variance) in self.diagonal().into_iter().enumerate() {
            if let Some(x) = unit.get_mut(axis) {
                *x = T::ONE;
            }
            let [column] = information.times(&unit).data.0;
            scatter.0.add_outer_out_of_line(variance, &column);
            unit.fill(T::ZERO);
        }
        scatter
    }

    /// Returns `Q^-1 x`; variances of `Q` below [`MIN_BLOCK_VARIANCE`] are raised to it.
    pub(crate) fn precise(&self, x: &Vector5<T>) -> Vector5<T> {
        x.component_mul(&Vector5::from(self.precision()))
    }

    /// Returns `L + Q^-1` for the information `L`; variances of `Q` below [`MIN_BLOCK_VARIANCE`] are raised to it.
    pub(crate) fn with_precision(&self, information: &Information<T>) -> Symmetric5<T> {
        information.0.plus(&Symmetric5::of_diagonal(self.precision()))
    }

    fn precision(&self) -> [T; 5] {
        self.diagonal().map(|q| T::ONE / q.max(T::lit(MIN_BLOCK_VARIANCE)))
    }

    /// Returns the equations for the mean extrinsics if the optimum of `of` contains the random effect. With the
    /// information `L` of `of`, they have the information `(L^-1 + Q)^-1` and the same optimum. Free directions stay
    /// free. `None` if numbers overflow.
    pub(crate) fn marginal(&self, of: &NormalEquations<T>) -> Option<NormalEquations<T>> {
        let factor = self.with_precision(&of.information).factor(T::ZERO)?;
        // (L^-1 + Q)^-1 = L (L + Q^-1)^-1 Q^-1 avoids differences of large numbers.
        let mut information = Symmetric5::ZERO;
        let mut rest = &mut information.0[..];
        for axis in 0..5 {
            let mut unit = Vector5::zeros();
            if let Some(x) = unit.get_mut(axis) {
                *x = T::ONE;
            }
            let [column] = of.information.times(&factor.solve(&self.precise(&unit))).data.0;
            // Row `axis` of the lower triangle equals the column down to the diagonal.
            let (row, below) = rest.split_at_mut_checked(axis + 1)?;
            row.iter_mut().zip(column).for_each(|(h, c)| *h = c);
            rest = below;
        }
        let gradient = self.precise(&factor.solve(&of.gradient));
        let information = Information(information);
        Some(NormalEquations { information, gradient })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const Q: BlockVariances<f64> = BlockVariances { rotation: 4e-6, baseline: 1e-7 };

    fn equations() -> NormalEquations<f64> {
        let mut sum = NormalEquations::ZERO;
        let rows = [
            [1.0, 0.2, 0.1, 0.05, 0.1],
            [1.1, -0.3, 0.4, 0.0, 0.2],
            [1.0, 0.1, -0.5, 0.1, 0.01],
            [1.3, 0.4, 0.3, -0.1, 0.1],
            [1.1, -0.4, 0.1, 0.1, -0.2],
            [1.0, 0.0, 0.6, 0.02, 0.3],
        ];
        for (k, row) in (0_u32..).zip(rows) {
            sum.add_row(3e6, 1e-4 * f64::from(k) - 2e-4, &row);
        }
        sum
    }

    #[test]
    fn turns_explain_a_baseline_that_scatters_about_as_much() {
        let of = |rotation: f64, baseline: f64| BlockVariances {
            rotation: rotation * rotation,
            baseline: baseline * baseline,
        };
        let floor = VIBRATION_RAD * VIBRATION_RAD;
        for (rotation, baseline) in [(1e-3, 0.0), (1e-3, 1e-3), (1e-3, 3.9e-3)] {
            let turns = of(rotation, baseline).of_turns();
            assert!((turns - (1e-6 - floor)).abs() < 1e-12, "{rotation} {baseline}");
        }
        for (rotation, baseline) in [(1e-3, 4.1e-3), (0.99 * TURN_RAD, 1e-4), (0.0, 0.0)] {
            assert!(of(rotation, baseline).of_turns() == 0.0, "{rotation} {baseline}");
        }
    }

    #[test]
    fn marginal_information_is_the_inverse_of_both_covariances_with_the_same_optimum() {
        let given = equations();
        let marginal = Q.marginal(&given).unwrap();
        let (optimum, covariance) = given.optimum().unwrap();
        let (same, wide) = marginal.optimum().unwrap();
        assert!((optimum - same).amax() < 1e-9 * optimum.amax());
        let mut expected = covariance;
        Q.add_to(&mut expected);
        let gap = wide.minus(&expected).matrix().amax();
        assert!(gap < 1e-9 * expected.matrix().amax(), "{gap}");
    }

    #[test]
    fn without_effect_the_equations_are_as_they_were_and_free_directions_stay_free() {
        let given = equations();
        let same = BlockVariances::ZERO.marginal(&given).unwrap();
        let gap = same.information.minus(&given.information).0.matrix().amax();
        assert!(gap < 1e-4 * given.information.0.matrix().amax(), "{gap}");
        let none = Q.marginal(&NormalEquations::ZERO).unwrap();
        assert_eq!(none.information, Information::ZERO);
    }

    #[test]
    fn the_scatter_of_the_gradient_is_the_variance_times_the_information_on_both_sides() {
        let information = equations().information;
        let l = information.0.matrix();
        let q = nalgebra::Matrix5::from_diagonal(&Q.diagonal().into());
        let gap = (Q.scatter_of_gradient(&information).0.matrix() - l * q * l).amax();
        assert!(gap < 1e-12 * (l * q * l).amax(), "{gap}");
    }
}
