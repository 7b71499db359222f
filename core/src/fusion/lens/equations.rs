//! Steps from the filled equations of the lens to their solution, each in place.

use nalgebra::Vector5;

use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::information::Information;
use crate::algebra::lens_terms::{LENS_PARAMETERS, LensEquations, LensValues};
use crate::algebra::symmetric5::Factor;
use crate::config::Context;
use crate::fusion::hypothesis::Hypothesis;
use crate::scalar::Scalar;
use crate::thresholds::{LENS_ROUNDING, MIN_LENS_PIVOT};

/// A value for each pair of lens parameters.
pub(super) type Square<T> = [[T; LENS_PARAMETERS]; LENS_PARAMETERS];

impl<T: Scalar> LensEquations<'_, T> {
    /// Returns 1 for each parameter on which the pairs have information with the extrinsics free, and 0 for each
    /// parameter whose information is then within the rounding errors ([`LENS_ROUNDING`]). The sums of a prior have no
    /// information on the lens itself, so only rounding errors remain.
    #[inline(never)]
    pub(super) fn measured(&self, of_extrinsics: &Information<T>) -> [T; LENS_PARAMETERS] {
        let mut measured = [T::ONE; LENS_PARAMETERS];
        let Some(factor) = of_extrinsics.0.factor(T::ZERO) else { return measured };
        let parameters = measured.iter_mut().zip(self.information.iter()).zip(self.mixed.iter());
        for (i, ((measured, row), mixed)) in parameters.enumerate() {
            let (mixed, all) = (Vector5::from(*mixed), row.get(i).copied().unwrap_or(T::ZERO));
            let left = all - mixed.dot(&factor.solve(&mixed));
            if left <= all * (T::EPSILON * T::lit(LENS_ROUNDING)) {
                *measured = T::ZERO;
            }
        }
        measured
    }

    /// Eliminates the extrinsics: information and gradient become those of the lens with free extrinsics.
    ///
    /// * `extrinsics`: equations of the extrinsics. They include the noise of disparities, as the mixed terms do. So
    ///   the remaining information on the lens stays positive semi-definite.
    #[inline(never)]
    pub(super) fn eliminate_extrinsics(
        &mut self,
        extrinsics: &BiasedEquations<T>,
        hypothesis: &Hypothesis<T>,
        context: &Context<'_, T>,
    ) -> Option<()> {
        let Self { mixed, information, gradient } = self;
        let mut plain = extrinsics.normal.with_prior(context.prior);
        plain.gradient -= hypothesis.pose().unknowns_to(&context.factory_pose) * context.prior;
        let factor = plain.information.0.factor(T::ZERO)?;
        for (row, own) in information.iter_mut().zip(mixed.iter()) {
            let taken_up = factor.solve(&Vector5::from(*own));
            let others = row.iter_mut().zip(mixed.iter());
            others.for_each(|(i, other)| *i -= Vector5::from(*other).dot(&taken_up));
        }
        let step = -factor.solve(&plain.gradient);
        for (pull, mixed) in gradient.iter_mut().zip(mixed.iter()) {
            *pull += Vector5::from(*mixed).dot(&step);
        }
        Some(())
    }

    /// Removes the information on the parameters that are not measured, and their gradient.
    ///
    /// * `measured`: result of [`Self::measured`].
    pub(super) fn take_only(&mut self, measured: &[T; LENS_PARAMETERS]) {
        self.gradient.iter_mut().zip(measured).for_each(|(pull, own)| *pull *= *own);
        let rows = self.information.iter_mut().zip(measured);
        rows.for_each(|(row, own)| scale_row(row, *own, measured));
    }

    /// Solves the equations with the prior of the lens: the gradient becomes the values, the information their
    /// covariance, and the mixed information their effects on the extrinsics. `None` if there is no finite solution.
    ///
    /// * `extrinsics`: equations of the extrinsics.
    pub(super) fn solve(
        self,
        extrinsics: &BiasedEquations<T>,
        hypothesis: &Hypothesis<T>,
        context: &Context<'_, T>,
    ) -> Option<()> {
        let Self { gradient: values, information: covariance, mixed: effects } = self;
        invert(covariance, &context.lens_prior())?;
        let pull = *values;
        values.iter_mut().zip(covariance.iter()).for_each(|(p, row)| *p = -dot(row, &pull));
        let rigid = hypothesis.is_rigid();
        let marginal =
            if rigid { *hypothesis.information() } else { extrinsics.debiased().information };
        let mut joint = marginal.0;
        joint.add_diagonal(context.prior);
        take_up(effects, extrinsics, &joint.factor(T::ZERO)?);
        Some(())
    }
}

/// Replaces the mixed information by the effects of the lens on the extrinsics. The noise of disparities is removed from
/// them, as it is from the estimate of the extrinsics.
#[inline(never)]
fn take_up<T: Scalar>(
    mixed: &mut [[T; 5]; LENS_PARAMETERS],
    extrinsics: &BiasedEquations<T>,
    joint: &Factor<T>,
) {
    let mut moved = *extrinsics;
    for row in mixed {
        moved.normal.gradient = Vector5::from(*row);
        *row = joint.solve(&moved.debiased().gradient).into();
    }
}

/// Replaces information by the inverse of `information + prior`. Rows and columns of held parameters are 0. `None` if
/// the information is not finite.
///
/// * `sd`: standard deviations of the prior. The principal rows, and parameters with a standard deviation of 0, are
///   held fixed.
#[inline(never)]
pub(super) fn invert<T: Scalar>(a: &mut Square<T>, sd: &[T; LENS_PARAMETERS]) -> Option<()> {
    let sd: [T; LENS_PARAMETERS] = LensValues { row: [T::ZERO; 2], ..LensValues::from(*sd) }.into();
    let mut scales = [T::ZERO; LENS_PARAMETERS];
    for (i, ((scale, row), sd)) in scales.iter_mut().zip(a.iter()).zip(&sd).enumerate() {
        if *sd > T::ZERO {
            let own = row.get(i).copied().unwrap_or(T::ZERO);
            *scale = T::ONE / (own.max(T::ZERO) + T::ONE / (*sd * *sd)).sqrt();
        }
    }
    // Scales to a unit diagonal, because the scales of the parameters differ by orders of magnitude.
    for (i, ((row, scale), sd)) in a.iter_mut().zip(scales).zip(&sd).enumerate() {
        scale_row(row, scale, &scales);
        if let Some(x) = row.get_mut(i) {
            *x = if scale > T::ZERO { *x + scale * scale / (*sd * *sd) } else { T::ONE };
        }
    }
    eliminate(a)?;
    a.iter_mut().zip(scales).for_each(|(row, scale)| scale_row(row, scale, &scales));
    Some(())
}

/// Multiplies a row by a factor, and each element by its own factor.
#[inline(never)]
pub(super) fn scale_row<T: Scalar>(
    row: &mut [T; LENS_PARAMETERS],
    factor: T,
    own: &[T; LENS_PARAMETERS],
) {
    row.iter_mut().zip(own).for_each(|(x, own)| *x *= factor * *own);
}

/// Inverts a positive definite matrix with unit diagonal by Gauss-Jordan elimination. Pivots below [`MIN_LENS_PIVOT`]
/// are raised to it. `None` if a pivot is not finite.
fn eliminate<T: Scalar>(a: &mut Square<T>) -> Option<()> {
    for pivot in 0..LENS_PARAMETERS {
        let row = *a.get(pivot)?;
        let found = *row.get(pivot)?;
        if !found.is_finite() {
            return None;
        }
        let inverse = T::ONE / found.max(T::lit(MIN_LENS_PIVOT));
        for (i, other) in a.iter_mut().enumerate() {
            let factor = *other.get(pivot)? * inverse;
            if i == pivot {
                for x in other.iter_mut() {
                    *x *= inverse;
                }
            } else {
                subtract(other, factor, &row);
            }
            if let Some(x) = other.get_mut(pivot) {
                *x = if i == pivot { inverse } else { -factor };
            }
        }
    }
    Some(())
}

/// Subtracts a multiple of another row.
#[inline(never)]
fn subtract<T: Scalar>(row: &mut [T; LENS_PARAMETERS], factor: T, other: &[T; LENS_PARAMETERS]) {
    row.iter_mut().zip(other).for_each(|(x, y)| *x -= factor * *y);
}

#[inline(never)]
fn dot<T: Scalar>(a: &[T; LENS_PARAMETERS], b: &[T; LENS_PARAMETERS]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}
