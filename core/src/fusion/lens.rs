//! The lens that the sums of a hypothesis show, and the covariance of its extrinsics with the lens uncertain
//! (`ESTIMATOR.md`, section 17).
//!
//! The extrinsics stay those of the given lens. An error `p` of the lens moves them by `-B p`, `B = Lambda^-1 S`: the
//! covariance gains `B (P + p p^T) B^T` with the estimate `p` of the lens and its covariance `P`.

use super::hypothesis::Hypothesis;
use crate::algebra::lens_terms::{LENS_PARAMETERS, LensTerms};
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::outcome::lens_estimate::{Finding, LensEstimate};
use crate::scalar::Scalar;
use crate::thresholds::{LENS_SHRINKAGE, MIN_LENS_PIVOT};
use nalgebra::Vector5;

type Square<T> = [[T; LENS_PARAMETERS]; LENS_PARAMETERS];

/// The lens estimate of a hypothesis.
#[derive(Debug, Clone, Copy)]
pub(super) struct HypothesisLens<T> {
    /// `p`; 0 where held.
    values: [T; LENS_PARAMETERS],
    /// `P`, reduced chi-square included; 0 where held.
    covariance: Square<T>,
    /// Columns of `B`: movement of the extrinsics by each parameter, rad.
    effects: [[T; 5]; LENS_PARAMETERS],
}

impl<T: Scalar> Hypothesis<T> {
    /// Estimates the lens about the given one. `None` where the prior holds all of it, or without a covariance.
    ///
    /// The principal row is held: only `y^2` tells it from pitch, which any bias of the matches imitates.
    #[inline(never)]
    pub(super) fn lens(&self, context: &Context<'_, T>) -> Option<HypothesisLens<T>> {
        let prior = context.lens_prior();
        if prior.iter().all(|sd| *sd <= T::ZERO) {
            return None;
        }
        let mut terms = LensTerms::ZERO;
        let sums = self.sums();
        sums.fill_lens(self.frame(), self.pose(), &mut terms);
        // With the noise of disparities in it: never less than the mixed terms need.
        let biased = sums.biased_at_pose(self.frame(), self.pose());
        let mut plain = biased.normal.with_prior(context.prior);
        plain.gradient -= self.pose().unknowns_to(&context.factory_pose) * context.prior;
        let plain = plain.information.0.factor(T::ZERO).map(|factor| (factor, plain.gradient))?;
        let (factor, gradient) = plain;
        let step = -factor.solve(&gradient);
        let taken_up = terms.mixed.map(|row| factor.solve(&Vector5::from(row)));
        let mut schur = terms.information;
        for (row, mixed) in schur.iter_mut().zip(&terms.mixed) {
            let mixed = Vector5::from(*mixed);
            row.iter_mut().zip(&taken_up).for_each(|(c, taken)| *c -= mixed.dot(taken));
        }
        let mut pull = terms.gradient;
        for (pull, mixed) in pull.iter_mut().zip(&terms.mixed) {
            *pull += Vector5::from(*mixed).dot(&step);
        }
        let mut covariance = posterior(&schur, &prior)?;
        let values = covariance.map(|row| -dot(&row, &pull));
        let scale = self.reduced_chi_square();
        covariance.iter_mut().flatten().for_each(|c| *c *= scale);
        let mut joint = self.information().0;
        joint.add_diagonal(context.prior);
        let factor = joint.factor(T::ZERO)?;
        // Without the noise of disparities, as the estimate.
        let effects = terms.mixed.map(|row| {
            let mut moved = biased;
            moved.normal.gradient = Vector5::from(row);
            factor.solve(&moved.debiased().gradient).into()
        });
        Some(HypothesisLens { values, covariance, effects })
    }
}

impl<T: Scalar> HypothesisLens<T> {
    /// Covariance of the extrinsics with the lens uncertain, from that with the lens as given, rad^2.
    pub(super) fn widen(&self, given: &Symmetric5<T>, context: &Context<'_, T>) -> Symmetric5<T> {
        let mut wide = *given;
        let Self { values, covariance, effects } = self;
        for ((effect, row), value) in effects.iter().zip(covariance).zip(values) {
            let mut moved = [T::ZERO; 5];
            for ((c, other), other_value) in row.iter().zip(effects).zip(values) {
                let weight = *c + *value * *other_value;
                moved.iter_mut().zip(other).for_each(|(m, e)| *m += weight * *e);
            }
            wide.add_symmetric(effect, &moved);
        }
        let [.., sd_row_l, sd_row_r, _, _, _] = context.lens_prior();
        let [.., row_l, row_r, _, _, _] = effects;
        wide.add_outer(sd_row_l * sd_row_l, row_l);
        wide.add_outer(sd_row_r * sd_row_r, row_r);
        // `p2` of the left camera is a turn about y; of the right one, of the baseline too.
        let (one, two) = (T::single(context.config.lens_prior.p2), T::lit(2.0));
        let variance = one * one;
        wide.add_outer(variance, &[T::ZERO, two, T::ZERO, T::ZERO, T::ZERO]);
        wide.add_outer(variance, &[T::ZERO, two, T::ZERO, two, T::ZERO]);
        wide
    }

    /// The estimate as it is reported.
    ///
    /// * `focal`: px.
    pub(super) fn report(&self, focal: T) -> LensEstimate<T> {
        let Self { values, covariance, .. } = self;
        let [s_l, s_r, cx_l, cx_r, _, _, k_l, k_r, p1] = *values;
        let [ss_l, ss_r, sc_l, sc_r, _, _, sk_l, sk_r, sp] = covariance;
        let [v_sl, c_s, ..] = *ss_l;
        let [_, v_sr, ..] = *ss_r;
        let [_, _, v_cl, c_c, ..] = *sc_l;
        let [_, _, _, v_cr, ..] = *sc_r;
        let [.., v_kl, c_k, _] = *sk_l;
        let [.., v_kr, _] = *sk_r;
        let [.., v_p] = *sp;
        let two = T::lit(2.0);
        // The weights are those of the residuals with the given lens.
        let finding = |value: T, variance: T| {
            let lost = T::lit(LENS_SHRINKAGE) * value;
            Finding { value, sd: (variance.max(T::ZERO) + lost * lost).sqrt() }
        };
        LensEstimate {
            focal: finding(s_r - s_l, v_sl + v_sr - two * c_s),
            k1: finding(k_r - k_l, v_kl + v_kr - two * c_k),
            k1_mean: finding((k_l + k_r) * T::HALF, (v_kl + v_kr + two * c_k) / T::lit(4.0)),
            p1: finding(p1, v_p),
            principal_x_px: finding(
                (cx_r - cx_l) * focal,
                (v_cl + v_cr - two * c_c) * focal * focal,
            ),
        }
    }
}

/// Inverse of `information + prior`; rows and columns of held parameters are 0.
///
/// * `sd`: of the prior; the principal rows and parameters of 0 are held.
fn posterior<T: Scalar>(information: &Square<T>, sd: &[T; LENS_PARAMETERS]) -> Option<Square<T>> {
    let free = |(i, sd): (usize, &T)| !(4..6).contains(&i) && *sd > T::ZERO;
    let mut scales = [T::ZERO; LENS_PARAMETERS];
    for ((scale, row), (i, sd)) in scales.iter_mut().zip(information).zip(sd.iter().enumerate()) {
        if free((i, sd)) {
            let own = row.get(i).copied().unwrap_or(T::ZERO);
            *scale = T::ONE / (own.max(T::ZERO) + T::ONE / (*sd * *sd)).sqrt();
        }
    }
    // Unit diagonal: units of the parameters differ by orders.
    let mut a = *information;
    for (i, ((row, scale), sd)) in a.iter_mut().zip(scales).zip(sd).enumerate() {
        for (k, (x, other)) in row.iter_mut().zip(scales).enumerate() {
            *x *= scale * other;
            if i == k {
                *x = if scale > T::ZERO { *x + scale * scale / (*sd * *sd) } else { T::ONE };
            }
        }
    }
    let mut inverse = inverted(a)?;
    for (row, scale) in inverse.iter_mut().zip(scales) {
        row.iter_mut().zip(scales).for_each(|(x, other)| *x *= scale * other);
    }
    Some(inverse)
}

/// Gauss-Jordan inverse of a positive definite matrix of unit diagonal; pivots at rounding are floored.
fn inverted<T: Scalar>(mut a: Square<T>) -> Option<Square<T>> {
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
                other.iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * *y);
            }
            if let Some(x) = other.get_mut(pivot) {
                *x = if i == pivot { inverse } else { -factor };
            }
        }
    }
    Some(a)
}

fn dot<T: Scalar>(a: &[T; LENS_PARAMETERS], b: &[T; LENS_PARAMETERS]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use nalgebra::SMatrix;
    use std::vec::Vec;

    type Full = SMatrix<f64, LENS_PARAMETERS, LENS_PARAMETERS>;

    /// Information of as many rows as parameters, of very different units.
    fn information() -> Full {
        let units = [1e3, 1e3, 1e2, 1e2, 1e2, 1e2, 30.0, 30.0, 50.0];
        let index = |i: usize| f64::from(u32::try_from(i).unwrap());
        let rows = Full::from_fn(|i, k| (1.3 * index(i) + 0.7 * index(k * k)).sin() * units[k]);
        rows.transpose() * rows
    }

    fn rows(m: &Full) -> Square<f64> {
        m.transpose().into()
    }

    #[test]
    fn the_posterior_is_the_inverse_of_information_and_prior_without_the_held_parameters() {
        let sd = [0.003, 0.003, 7e-4, 7e-4, 7e-4, 7e-4, 0.005, 0.0, 0.001];
        let got = Full::from(posterior(&rows(&information()), &sd).unwrap());
        let free: Vec<usize> = [0, 1, 2, 3, 6, 8].into();
        let mut expected = SMatrix::<f64, 6, 6>::from_fn(|i, k| information()[(free[i], free[k])]);
        for (i, place) in free.iter().enumerate() {
            expected[(i, i)] += 1.0 / (sd[*place] * sd[*place]);
        }
        let expected = expected.try_inverse().unwrap();
        for i in 0..LENS_PARAMETERS {
            for k in 0..LENS_PARAMETERS {
                let place = |of: usize| free.iter().position(|free| *free == of);
                let expected = place(i).zip(place(k)).map_or(0.0, |at| expected[at]);
                let unit = sd[i].max(1e-4) * sd[k].max(1e-4);
                assert!((got[(i, k)] - expected).abs() < 1e-9 * unit, "{i} {k}");
            }
        }
    }

    #[test]
    fn without_information_the_posterior_is_the_prior_and_nan_has_none() {
        let sd: [f64; LENS_PARAMETERS] =
            [0.003, 0.002, 7e-4, 6e-4, 5e-4, 4e-4, 0.005, 0.004, 0.001];
        let got = posterior(&[[0.0; LENS_PARAMETERS]; LENS_PARAMETERS], &sd).unwrap();
        for (i, (row, sd)) in got.iter().zip(sd).enumerate() {
            let expected = if i == 4 || i == 5 { 0.0 } else { sd * sd };
            assert!((row[i] - expected).abs() < 1e-15, "{i}");
        }
        assert!(posterior(&[[f64::NAN; LENS_PARAMETERS]; LENS_PARAMETERS], &sd).is_none());
    }
}
