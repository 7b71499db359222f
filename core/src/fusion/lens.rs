//! Estimate of the lens from the sums of a hypothesis, and covariance of its extrinsics with an uncertain lens
//! (`ESTIMATOR.md`, section 17).
//!
//! The extrinsics are estimated with the given lens. A lens error `p` causes an error `-B p` of the extrinsics with
//! `B = Lambda^-1 G S`. Here `S` is the mixed information of extrinsics and lens, `Lambda` is the information on the
//! extrinsics with the prior, and `G` is the gain that removes the noise of disparities. So `B (P + p p^T) B^T` is
//! added to the covariance of the extrinsics, where `p` is the estimate of the lens error and `P` its covariance.

mod equations;

use nalgebra::Vector5;

use super::hypothesis::Hypothesis;
use super::lens_reference::LensReference;
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::lens_terms::{LENS_PARAMETERS, LensEquations, LensValues};
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::geometry::lens_correction::LensCorrection;
use crate::outcome::lens_estimate::{Finding, LensEstimate};
use crate::scalar::Scalar;
use crate::thresholds::{LENS_SHRINKAGE, MAX_LENS_VALUE, SIGNIFICANT};
use equations::{Square, scale_row};

/// How an estimate uses the knowledge of the lens from dropped sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Knowledge {
    /// The estimate includes the knowledge.
    Included,
    /// The estimate is of the sums alone, and relative to the known lens, about which its prior is centred.
    Origin,
}

/// Errors of the lens that a hypothesis shows, relative to the lens of its rays.
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
        let extrinsics = hypothesis.fill_lens(self.equations());
        self.solve(&extrinsics, hypothesis, (reference, knowledge), context)
    }

    /// Returns the buffers of the estimate as those of its equations: [`LensEquations::solve`] replaces the gradient by
    /// the values, the information by the covariance, and the mixed information by the effects.
    fn equations(&mut self) -> LensEquations<'_, T> {
        let Self { values, covariance, effects } = self;
        LensEquations { gradient: values, information: covariance, mixed: effects }
    }

    /// Completes the filled equations of the lens, and solves them.
    ///
    /// * `extrinsics`: equations of the extrinsics.
    // Out of line, because successive calls take less stack than one function.
    #[inline(never)]
    fn solve(
        &mut self,
        extrinsics: &BiasedEquations<T>,
        hypothesis: &Hypothesis<T>,
        (reference, knowledge): (&LensReference<T>, Knowledge),
        context: &Context<'_, T>,
    ) -> Option<()> {
        let mut equations = self.equations();
        let measured = equations.measured(&extrinsics.normal.information);
        equations.eliminate_extrinsics(extrinsics, hypothesis, context)?;
        equations.take_only(&measured);
        match knowledge {
            Knowledge::Included => reference.add_known(&mut equations),
            Knowledge::Origin => reference.move_to_known(&mut equations),
        }
        equations.solve(extrinsics, hypothesis, context)?;
        let scale = hypothesis.reduced_chi_square();
        for row in &mut self.covariance {
            scale_row(row, scale, &[T::ONE; LENS_PARAMETERS]);
        }
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
        let LensValues { row: sds, .. } = context.lens_prior().into();
        let LensValues { row: rows, .. } = effects.each_ref().into();
        for (sd, effect) in sds.into_iter().zip(rows) {
            wide.add_outer_out_of_line(sd * sd, effect);
        }
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
        let mut values = LensValues::from(self.values);
        let ([_, focal_r], [_, k1_r]) = (&mut values.focal, &mut values.k1);
        *focal_r += focal;
        *k1_r += k1;
        values.into()
    }

    /// Returns the differences of focal length and `k1` between the cameras, right minus left, relative to the lens of
    /// the rays.
    pub(super) fn difference(&self) -> LensCorrection<T> {
        let LensValues { focal: [focal_l, focal_r], k1: [k1_l, k1_r], .. } = self.values.into();
        LensCorrection { focal: focal_r - focal_l, k1: k1_r - k1_l }
    }

    /// Returns the variances of the differences of focal length and `k1`. Each variance includes the square of the
    /// amount by which its difference may be underestimated ([`LENS_SHRINKAGE`]).
    #[inline(never)]
    pub(super) fn variances(&self) -> [T; 2] {
        let rows = self.covariances();
        let of_focal = rows.focal.map(|row| LensValues::from(*row).focal);
        let of_k1 = rows.k1.map(|row| LensValues::from(*row).k1);
        let LensCorrection { focal, k1 } = self.difference();
        [hiding(focal, of_difference(&of_focal)), hiding(k1, of_difference(&of_k1))]
    }

    /// Returns the rows of the covariance.
    fn covariances(&self) -> LensValues<&[T; LENS_PARAMETERS]> {
        self.covariance.each_ref().into()
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
        let LensValues { focal: [_, by_focal], k1: [_, by_k1], .. } =
            self.effects.each_ref().into();
        let LensCorrection { focal, k1 } = self.difference();
        -(Vector5::from(*by_focal) * focal + Vector5::from(*by_k1) * k1)
    }

    /// Returns the part of the compensation that frozen weights may hide, rad.
    pub(super) fn hidden(&self) -> Vector5<T> {
        self.compensation() * T::lit(LENS_SHRINKAGE)
    }

    /// Returns the estimate for the report: errors of the given lens. Only the mean of `k1` is relative to the lens of
    /// the rays.
    ///
    /// * `reference`: lens correction of the rays; `focal`: focal length, px.
    pub(super) fn report(&self, reference: &LensCorrection<T>, focal: T) -> LensEstimate<T> {
        let LensValues { column: [column_l, column_r], k1: [k1_l, k1_r], p1, .. } =
            self.values.into();
        let rows = self.covariances();
        let of_column = rows.column.map(|row| LensValues::from(*row).column);
        let of_k1 = rows.k1.map(|row| LensValues::from(*row).k1);
        let of_p1 = LensValues::from(*rows.p1).p1;
        let finding = |value: T, variance| Finding { value, sd: hiding(value, variance).sqrt() };
        let ([v_focal, v_k1], total) = (self.variances(), reference.plus(&self.difference()));
        LensEstimate {
            focal: Finding { value: total.focal, sd: v_focal.sqrt() },
            k1: Finding { value: total.k1, sd: v_k1.sqrt() },
            k1_mean: finding((k1_l + k1_r) * T::HALF, of_mean(&of_k1)),
            p1: finding(p1, of_p1),
            principal_x_px: finding(
                (column_r - column_l) * focal,
                of_difference(&of_column) * focal * focal,
            ),
        }
    }
}

/// Returns the variance of the difference between both cameras.
///
/// * `covariance`: of the left and of the right value.
fn of_difference<T: Scalar>([[left, both], [_, right]]: &[[T; 2]; 2]) -> T {
    *left + *right - T::lit(2.0) * *both
}

/// Returns the variance of the mean over both cameras.
///
/// * `covariance`: as for [`of_difference`].
fn of_mean<T: Scalar>([[left, both], [_, right]]: &[[T; 2]; 2]) -> T {
    (*left + *right + T::lit(2.0) * *both) / T::lit(4.0)
}

/// Returns a variance plus the square of the amount by which its value may be underestimated. The weights were computed
/// from residuals that contain the lens error, so matches that show the error have too little weight.
fn hiding<T: Scalar>(value: T, variance: T) -> T {
    let hidden = T::lit(LENS_SHRINKAGE) * value;
    variance.max(T::ZERO) + hidden * hidden
}

#[cfg(test)]
mod tests;
