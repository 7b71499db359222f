//! Estimate of the lens from the sums of a hypothesis, and covariance of its extrinsics with an uncertain lens
//! (`ESTIMATOR.md`, section 17).
//!
//! The extrinsics are estimated with the given lens. A lens error `p` causes an error `-B p` of the extrinsics with
//! `B = Lambda^-1 G S`. Here `S` is the mixed information of extrinsics and lens, `Lambda` is the information on the
//! extrinsics with the prior, and `G` is the gain that removes the noise of disparities. So `B (P + p p^T) B^T` is
//! added to the covariance of the extrinsics, where `p` is the estimate of the lens error and `P` its covariance.

use nalgebra::Vector5;

use super::hypothesis::Hypothesis;
use super::lens_reference::LensReference;
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::information::Information;
use crate::algebra::lens_terms::{LENS_PARAMETERS, LensTerms};
use crate::algebra::symmetric5::{Factor, Symmetric5};
use crate::config::Context;
use crate::geometry::lens_correction::LensCorrection;
use crate::outcome::lens_estimate::{Finding, LensEstimate};
use crate::scalar::Scalar;
use crate::thresholds::{
    LENS_ROUNDING, LENS_SHRINKAGE, MAX_LENS_VALUE, MIN_LENS_PIVOT, SIGNIFICANT,
};

type Square<T> = [[T; LENS_PARAMETERS]; LENS_PARAMETERS];

/// How an estimate uses the knowledge of the lens from dropped sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Knowledge {
    /// The estimate includes the knowledge.
    Included,
    /// The estimate is of the sums alone, and relative to the known lens, about which its prior is centred.
    Origin,
}

/// Errors of the lens that a hypothesis shows, relative to the lens of its rays. The equations are solved in place:
/// each field first holds the equations, and then the result.
#[derive(Debug)]
pub(super) struct HypothesisLens<T> {
    /// `p`, relative to the lens of the rays; 0 for parameters that are held fixed.
    pub(super) values: [T; LENS_PARAMETERS],
    /// `P`, multiplied by the reduced chi-square; 0 for parameters that are held fixed.
    covariance: Square<T>,
    /// Columns of `B`: effect of each parameter on the extrinsics, rad per unit of the parameter.
    effects: [[T; 5]; LENS_PARAMETERS],
}

impl<T: Scalar> HypothesisLens<T> {
    /// An exact lens: no errors, no covariance. An estimate starts from this value.
    pub(super) const EXACT: Self = Self {
        values: [T::ZERO; LENS_PARAMETERS],
        covariance: [[T::ZERO; LENS_PARAMETERS]; LENS_PARAMETERS],
        effects: [[T::ZERO; 5]; LENS_PARAMETERS],
    };

    /// Estimates the lens relative to the lens of the rays. `None` if there is no plausible finite solution.
    ///
    /// The principal rows are held fixed. Only terms in `y^2` distinguish them from pitch, and any bias of the matches
    /// can imitate such terms.
    #[inline(never)]
    pub(super) fn estimate(
        &mut self,
        hypothesis: &Hypothesis<T>,
        reference: &LensReference<T>,
        knowledge: Knowledge,
        context: &Context<'_, T>,
    ) -> Option<()> {
        let Self { values: gradient, covariance: information, effects: mixed } = self;
        let biased = hypothesis.fill_lens(LensTerms { mixed, information, gradient });
        self.solve(&biased, hypothesis, (reference, knowledge), context)
    }

    /// Solves the normal equations of the lens in place.
    ///
    /// * `biased`: equations of the extrinsics.
    // Out of line, because successive calls take less stack than one function.
    #[inline(never)]
    fn solve(
        &mut self,
        biased: &BiasedEquations<T>,
        hypothesis: &Hypothesis<T>,
        (reference, knowledge): (&LensReference<T>, Knowledge),
        context: &Context<'_, T>,
    ) -> Option<()> {
        let Self { values, covariance, effects } = self;
        let measured = measured(covariance, effects, &biased.normal.information);
        let step = eliminate_extrinsics(covariance, effects, hypothesis, biased, context)?;
        for (pull, mixed) in values.iter_mut().zip(effects.iter()) {
            *pull += Vector5::from(*mixed).dot(&step);
        }
        values.iter_mut().zip(measured).for_each(|(pull, own)| *pull *= own);
        let rows = covariance.iter_mut().zip(measured);
        rows.for_each(|(row, own)| scale_row(row, own, &measured));
        match knowledge {
            Knowledge::Included => reference.add_known(covariance, values),
            Knowledge::Origin => reference.move_to_known(covariance, values),
        }
        invert(covariance, &context.lens_prior())?;
        let pull = *values;
        values.iter_mut().zip(covariance.iter()).for_each(|(p, row)| *p = -dot(row, &pull));
        let scale = hypothesis.reduced_chi_square();
        for row in covariance.iter_mut() {
            scale_row(row, scale, &[T::ONE; LENS_PARAMETERS]);
        }
        let rigid = hypothesis.is_rigid();
        let marginal =
            if rigid { *hypothesis.information() } else { biased.debiased().information };
        let mut joint = marginal.0;
        joint.add_diagonal(context.prior);
        take_up(effects, biased, &joint.factor(T::ZERO)?);
        self.is_sane(&context.lens_prior(), scale).then_some(())
    }

    /// Returns whether the estimate is plausible: each value is within [`MAX_LENS_VALUE`] standard deviations of the
    /// prior, and each variance is between 0 and four times the scaled variance of the prior. Sums from a damaged
    /// record may violate this.
    ///
    /// * `sd`: standard deviations of the prior; `scale`: reduced chi-square.
    fn is_sane(&self, sd: &[T; LENS_PARAMETERS], scale: T) -> bool {
        let most = T::lit(MAX_LENS_VALUE * MAX_LENS_VALUE);
        let parameters = self.values.iter().zip(&self.covariance).zip(sd).enumerate();
        parameters.fold(true, |sane, (i, ((value, row), sd))| {
            let variance = row.get(i).copied().unwrap_or(T::ZERO);
            let prior = *sd * *sd;
            let within = variance >= T::ZERO && variance <= prior * scale * T::lit(4.0);
            sane && within && *value * *value <= prior * most
        })
    }

    /// Returns the covariance of the extrinsics with an uncertain lens, rad^2. It includes the prior variances of the
    /// principal rows and of `p2`, which are not estimated.
    ///
    /// * `given`: covariance of the extrinsics if the given lens is exact, rad^2; `off`: errors of the lens, in the
    ///   order of `values`, that the extrinsics still contain.
    #[inline(never)]
    pub(super) fn widen(
        &self,
        given: &Symmetric5<T>,
        off: &[T; LENS_PARAMETERS],
        context: &Context<'_, T>,
    ) -> Symmetric5<T> {
        let mut wide = *given;
        let Self { covariance, effects, .. } = self;
        for ((effect, row), value) in effects.iter().zip(covariance).zip(off) {
            let mut moved = [T::ZERO; 5];
            for ((c, other), other_value) in row.iter().zip(effects).zip(off) {
                let weight = *c + *value * *other_value;
                moved.iter_mut().zip(other).for_each(|(m, e)| *m += weight * *e);
            }
            wide.add_symmetric(effect, &moved);
        }
        let [.., sd_row_l, sd_row_r, _, _, _] = context.lens_prior();
        let [.., row_l, row_r, _, _, _] = effects;
        wide.add_outer_out_of_line(sd_row_l * sd_row_l, row_l);
        wide.add_outer_out_of_line(sd_row_r * sd_row_r, row_r);
        // `p2` acts like a yaw, which the apparent yaw of the lens covers; `p2` of the right camera also turns the
        // baseline about y, by twice its value.
        let p2 = T::single(context.config.lens_prior.p2) * T::lit(2.0);
        wide.add_outer_out_of_line(p2 * p2, &[T::ZERO, T::ZERO, T::ZERO, T::ONE, T::ZERO]);
        wide
    }

    /// Returns the errors of the given lens, for rays that were corrected by `reference`.
    pub(super) fn of_given(&self, reference: &LensCorrection<T>) -> [T; LENS_PARAMETERS] {
        self.moved_by(reference.focal, reference.k1)
    }

    /// Returns the errors that remain after compensation of the differences of focal length and `k1`.
    pub(super) fn left_over(&self) -> [T; LENS_PARAMETERS] {
        let LensCorrection { focal, k1 } = self.difference();
        self.moved_by(-focal, -k1)
    }

    /// Returns the errors, with additions to the focal length and `k1` of the right camera.
    fn moved_by(&self, focal: T, k1: T) -> [T; LENS_PARAMETERS] {
        let [s_l, s_r, cx_l, cx_r, cy_l, cy_r, k_l, k_r, p1] = self.values;
        [s_l, s_r + focal, cx_l, cx_r, cy_l, cy_r, k_l, k_r + k1, p1]
    }

    /// Returns the differences of focal length and `k1` between the cameras, right minus left, relative to the lens of
    /// the rays.
    pub(super) fn difference(&self) -> LensCorrection<T> {
        let [s_l, s_r, _, _, _, _, k_l, k_r, _] = self.values;
        LensCorrection { focal: s_r - s_l, k1: k_r - k_l }
    }

    /// Returns the variances of the differences of focal length and `k1`. Each variance includes the square of the
    /// amount by which its difference may be underestimated ([`LENS_SHRINKAGE`]).
    #[inline(never)]
    pub(super) fn variances(&self) -> [T; 2] {
        let [ss_l, ss_r, _, _, _, _, sk_l, sk_r, _] = &self.covariance;
        let ([v_sl, c_s, ..], [_, v_sr, ..]) = (*ss_l, *ss_r);
        let ([.., v_kl, c_k, _], [.., v_kr, _]) = (*sk_l, *sk_r);
        let LensCorrection { focal, k1 } = self.difference();
        let two = T::lit(2.0);
        [hiding(focal, v_sl + v_sr - two * c_s), hiding(k1, v_kl + v_kr - two * c_k)]
    }

    /// Returns whether a difference of focal length or `k1` exceeds [`SIGNIFICANT`] standard deviations.
    pub(super) fn is_significant(&self) -> bool {
        let LensCorrection { focal, k1 } = self.difference();
        let least = T::lit(SIGNIFICANT * SIGNIFICANT);
        let exceeds = |(value, variance): (T, T)| value * value > least * variance;
        [focal, k1].into_iter().zip(self.variances()).any(exceeds)
    }

    /// Returns the step, rad, from the extrinsics for the lens of the rays to those for a lens whose differences of
    /// focal length and `k1` are compensated.
    pub(super) fn compensation(&self) -> Vector5<T> {
        let [_, by_focal, _, _, _, _, _, by_k1, _] = self.effects.map(Vector5::from);
        let LensCorrection { focal, k1 } = self.difference();
        -(by_focal * focal + by_k1 * k1)
    }

    /// Returns the part of the compensation that frozen weights may hide, rad.
    pub(super) fn hidden(&self) -> Vector5<T> {
        self.compensation() * T::lit(LENS_SHRINKAGE)
    }

    /// Returns the estimate for the report: errors of the given lens. Only the mean of `k1` is relative to the lens of
    /// the rays.
    ///
    /// * `reference`: lens correction of the rays; `focal`: focal length, px.
    #[inline(never)]
    pub(super) fn report(&self, reference: &LensCorrection<T>, focal: T) -> LensEstimate<T> {
        let Self { values, covariance, .. } = self;
        let [_, _, cx_l, cx_r, _, _, k_l, k_r, p1] = *values;
        let [_, _, sc_l, sc_r, _, _, sk_l, sk_r, sp] = covariance;
        let ([_, _, v_cl, c_c, ..], [_, _, _, v_cr, ..]) = (*sc_l, *sc_r);
        let ([.., v_kl, c_k, _], [.., v_kr, _], [.., v_p]) = (*sk_l, *sk_r, *sp);
        let two = T::lit(2.0);
        let finding = |value: T, variance| Finding { value, sd: hiding(value, variance).sqrt() };
        let ([v_focal, v_k1], total) = (self.variances(), reference.plus(&self.difference()));
        LensEstimate {
            focal: Finding { value: total.focal, sd: v_focal.sqrt() },
            k1: Finding { value: total.k1, sd: v_k1.sqrt() },
            k1_mean: finding((k_l + k_r) * T::HALF, (v_kl + v_kr + two * c_k) / T::lit(4.0)),
            p1: finding(p1, v_p),
            principal_x_px: finding(
                (cx_r - cx_l) * focal,
                (v_cl + v_cr - two * c_c) * focal * focal,
            ),
        }
    }
}

/// Returns a variance plus the square of the amount by which its value may be underestimated. The weights were computed
/// from residuals that contain the lens error, so matches that show the error have too little weight.
fn hiding<T: Scalar>(value: T, variance: T) -> T {
    let hidden = T::lit(LENS_SHRINKAGE) * value;
    variance.max(T::ZERO) + hidden * hidden
}

/// Eliminates the extrinsics from the information on the lens. Returns the step of the extrinsics for an unchanged
/// lens, rad.
#[inline(never)]
fn eliminate_extrinsics<T: Scalar>(
    information: &mut Square<T>,
    mixed: &[[T; 5]; LENS_PARAMETERS],
    hypothesis: &Hypothesis<T>,
    biased: &BiasedEquations<T>,
    context: &Context<'_, T>,
) -> Option<Vector5<T>> {
    // The equations include the noise of disparities, as the mixed terms do. So the remaining information on the lens
    // stays positive semi-definite.
    let mut plain = biased.normal.with_prior(context.prior);
    plain.gradient -= hypothesis.pose().unknowns_to(&context.factory_pose) * context.prior;
    let factor = plain.information.0.factor(T::ZERO)?;
    for (row, own) in information.iter_mut().zip(mixed) {
        let taken_up = factor.solve(&Vector5::from(*own));
        row.iter_mut().zip(mixed).for_each(|(i, other)| *i -= Vector5::from(*other).dot(&taken_up));
    }
    Some(-factor.solve(&plain.gradient))
}

/// Returns 1 for each parameter on which the pairs have information with the extrinsics free, and 0 for each parameter
/// whose information is then within the rounding errors ([`LENS_ROUNDING`]). The sums of a prior have no information on
/// the lens itself, so only rounding errors remain.
#[inline(never)]
fn measured<T: Scalar>(
    information: &Square<T>,
    mixed: &[[T; 5]; LENS_PARAMETERS],
    of_extrinsics: &Information<T>,
) -> [T; LENS_PARAMETERS] {
    let mut measured = [T::ONE; LENS_PARAMETERS];
    let Some(factor) = of_extrinsics.0.factor(T::ZERO) else { return measured };
    let parameters = measured.iter_mut().zip(information).zip(mixed);
    for (i, ((measured, row), mixed)) in parameters.enumerate() {
        let (mixed, all) = (Vector5::from(*mixed), row.get(i).copied().unwrap_or(T::ZERO));
        let left = all - mixed.dot(&factor.solve(&mixed));
        if left <= all * (T::EPSILON * T::lit(LENS_ROUNDING)) {
            *measured = T::ZERO;
        }
    }
    measured
}

/// Replaces the mixed terms by the effects of the lens on the extrinsics. The noise of disparities is removed from
/// them, as it is from the estimate of the extrinsics.
#[inline(never)]
fn take_up<T: Scalar>(
    mixed: &mut [[T; 5]; LENS_PARAMETERS],
    biased: &BiasedEquations<T>,
    joint: &Factor<T>,
) {
    let mut moved = *biased;
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
fn invert<T: Scalar>(a: &mut Square<T>, sd: &[T; LENS_PARAMETERS]) -> Option<()> {
    let free = |(i, sd): (usize, &T)| !(4..6).contains(&i) && *sd > T::ZERO;
    let mut scales = [T::ZERO; LENS_PARAMETERS];
    for ((scale, row), (i, sd)) in scales.iter_mut().zip(a.iter()).zip(sd.iter().enumerate()) {
        if free((i, sd)) {
            let own = row.get(i).copied().unwrap_or(T::ZERO);
            *scale = T::ONE / (own.max(T::ZERO) + T::ONE / (*sd * *sd)).sqrt();
        }
    }
    // Scales to a unit diagonal, because the scales of the parameters differ by orders of magnitude.
    for (i, ((row, scale), sd)) in a.iter_mut().zip(scales).zip(sd).enumerate() {
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
fn scale_row<T: Scalar>(row: &mut [T; LENS_PARAMETERS], factor: T, own: &[T; LENS_PARAMETERS]) {
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

#[cfg(test)]
mod tests;
