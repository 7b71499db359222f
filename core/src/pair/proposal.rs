//! Second start of a search, from poses fitted to three random correspondences each (`ESTIMATOR.md`, section 5).
//!
//! Among outliers, a search may end at a pose that some outliers fit, or between two groups of consistent matches. A
//! pose fitted to a small sample does not depend on the other matches.

use nalgebra::Vector5;

use super::constraint::{Constraint, PoseTerms};
use super::loss::geman_mcclure;
use super::survey::{Random, scattered_over};
use super::weighting::Weighting;
use crate::algebra::information::Information;
use crate::algebra::normal_equations::NormalEquations;
use crate::batch::correspondence::RayPair;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{
    GROUP, GROUPS, IMPROVING_STEPS, LEAST_SCALE_PX, PROPOSAL_GAIN, PROPOSAL_SCALE, ROUNDS, SAMPLE,
    SAMPLED,
};

/// Whitened residuals about a pose, px, and their derivatives, px/rad.
type Rows<T> = heapless::Vec<(T, [T; 5]), SAMPLED>;

/// Rounds of a second start. Each round begins at the pose of the previous round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rounds {
    random: Random,
    pub(super) left: u8,
    /// Whether a round has found a better pose.
    pub(super) moved: bool,
}

impl Rounds {
    /// Plans [`ROUNDS`] rounds, or only one if the last pass of the annealing has seen no peak of residuals. With many
    /// wrong matches there may be no peak.
    ///
    /// * `has_peak`: whether that pass has seen a peak.
    pub(super) fn after_annealing(has_peak: bool) -> Self {
        Self { random: Random::NEW, left: if has_peak { ROUNDS } else { 1 }, moved: false }
    }

    /// Runs one round. Returns a better pose and the step to it, rad; `None` if the round finds no better pose.
    ///
    /// * `by`: weighting at the pose; `scale`: scale of the score, px; `prior`: information of a prior whose optimum is
    ///   `pose`, 1/rad^2.
    pub(super) fn take<T: Scalar>(
        &mut self,
        pose: &RectifyingRotations<T>,
        by: &Weighting<T>,
        pairs: &[RayPair<T>],
        scale: T,
        prior: &Information<T>,
    ) -> Option<(RectifyingRotations<T>, Vector5<T>)> {
        self.left = self.left.saturating_sub(1);
        let d = self.propose(by, pairs, scale, prior)?;
        let moved = pose.stepped_by(&d)?;
        // The proposal rests on a sample and on linearised residuals, so all correspondences must confirm it.
        let there = Weighting { pose: PoseTerms::at(&moved), ..*by };
        (gain(by, &there, pairs, scale) > T::lit(PROPOSAL_GAIN)).then_some((moved, d))
    }

    /// Returns the step to a pose that fits a sample better, rad; `None` if no proposal does. The residuals are
    /// linearised about the pose.
    #[inline(never)]
    fn propose<T: Scalar>(
        &mut self,
        by: &Weighting<T>,
        pairs: &[RayPair<T>],
        scale: T,
        prior: &Information<T>,
    ) -> Option<Vector5<T>> {
        let mut rows = Rows::new();
        take_rows(by, pairs, &mut rows);
        best(&rows, scale, prior, &mut self.random)
    }
}

/// Returns whether a batch is small: it has at most [`SAMPLED`] usable correspondences, as many as a sample holds.
///
/// * `usable`: number of usable correspondences.
pub(super) fn is_small<T: Scalar>(usable: T) -> bool {
    usize::from(usable.to_u16()) <= SAMPLED
}

/// Returns the scale of the scores, and of the first annealed pass after the second start, px.
///
/// * `noise`: standard deviation of a coordinate, px.
pub(super) fn scale<T: Scalar>(noise: T) -> T {
    (T::lit(PROPOSAL_SCALE) * noise).max(T::lit(LEAST_SCALE_PX))
}

/// Returns the score at the pose of `to` minus the score at the pose of `from`, over all correspondences and without
/// linearisation.
///
/// * `from`, `to`: weighting at each pose; `scale`: scale of the score, px.
#[inline(never)]
fn gain<T: Scalar>(from: &Weighting<T>, to: &Weighting<T>, pairs: &[RayPair<T>], scale: T) -> T {
    let square = |by: &Weighting<T>, pair: &RayPair<T>| {
        let seen = Constraint::of(&by.pose, pair)?;
        Some(seen.value * seen.value * by.precision(&seen))
    };
    pairs.iter().fold(T::ZERO, |gain, pair| {
        let [lost, won] = [from, to].map(|by| score(square(by, pair).into_iter(), scale));
        gain + (won - lost)
    })
}

/// Returns the step to the best of the proposed poses, rad; `None` if no score exceeds that of the current pose by
/// [`PROPOSAL_GAIN`].
///
/// A pose fitted to a small sample is only near the pose that most correspondences fit, so its score is noisy if there
/// are few correspondences. Steps to the nearby optimum therefore improve the best pose of each group.
fn best<T: Scalar>(
    rows: &Rows<T>,
    scale: T,
    prior: &Information<T>,
    random: &mut Random,
) -> Option<Vector5<T>> {
    let least = score_after(rows, &Vector5::zeros(), scale) + T::lit(PROPOSAL_GAIN);
    let mut best = Best { score: least, step: None };
    // Fewer rows allow more groups, so the work is about constant.
    for _ in 0..GROUPS * SAMPLED / rows.len().max(SAMPLED / 4) {
        let mut of_group = Best { score: T::ZERO, step: None };
        for _ in 0..GROUP {
            if let Some(d) = through_sample(rows, prior, random) {
                of_group.compare(rows, scale, d);
            }
        }
        if let Some(d) = of_group.step {
            best.compare(rows, scale, improved(rows, d, scale, prior));
        }
    }
    best.step
}

/// Step with the highest score so far.
struct Best<T> {
    score: T,
    /// Step, rad.
    step: Option<Vector5<T>>,
}

impl<T: Scalar> Best<T> {
    fn compare(&mut self, rows: &Rows<T>, scale: T, step: Vector5<T>) {
        let score = score_after(rows, &step, scale);
        if score > self.score {
            *self = Self { score, step: Some(step) };
        }
    }
}

/// Fills `rows` from a sample of the batch. Filling in place saves 1.5 kB of stack.
#[inline(never)]
fn take_rows<T: Scalar>(by: &Weighting<T>, pairs: &[RayPair<T>], rows: &mut Rows<T>) {
    for pair in scattered_over(pairs, SAMPLED) {
        if let Some(constraint) = Constraint::of(&by.pose, pair) {
            let root = by.precision(&constraint).sqrt();
            // The vector has room for the whole sample.
            let _ = rows.push((constraint.value * root, constraint.jacobian.map(|j| j * root)));
        }
    }
}

/// Returns the step to the pose fitted to [`SAMPLE`] random rows, rad; `None` if no step exists. The prior determines
/// the directions that the sample leaves free.
fn through_sample<T: Scalar>(
    rows: &Rows<T>,
    prior: &Information<T>,
    random: &mut Random,
) -> Option<Vector5<T>> {
    let mut normal = NormalEquations::ZERO;
    for _ in 0..SAMPLE {
        let (value, jacobian) = rows.get(random.below(rows.len())?)?;
        normal.add_row(T::ONE, *value, jacobian);
    }
    normal.with(prior).step()
}

/// Returns `start` after [`IMPROVING_STEPS`] steps towards the optimum near it, with Geman-McClure's loss at `scale`,
/// px. `start` and the result are steps from the pose of the rows, rad.
fn improved<T: Scalar>(
    rows: &Rows<T>,
    start: Vector5<T>,
    scale: T,
    prior: &Information<T>,
) -> Vector5<T> {
    let unit = T::ONE / (scale * scale);
    let mut d = start;
    for _ in 0..IMPROVING_STEPS {
        let mut normal = NormalEquations::ZERO;
        for row in rows {
            let r = residual(row, &d);
            normal.add_row(geman_mcclure(r * r * unit), row.0, &row.1);
        }
        let Some(next) = normal.with(prior).step() else {
            break;
        };
        d = next;
    }
    d
}

/// Returns the sum of the Cauchy weights `1 / (1 + r^2 / scale^2)`, a soft count of the correspondences that fit.
///
/// * `squares`: squared residuals `r^2`, px^2; `scale`: px.
fn score<T: Scalar>(squares: impl Iterator<Item = T>, scale: T) -> T {
    let unit = T::ONE / (scale * scale);
    squares.fold(T::ZERO, |sum, squared| sum + T::ONE / (T::ONE + squared * unit))
}

/// Returns the score of the pose after a step.
///
/// * `d`: step from the pose that the rows are linearised about, rad; `scale`: scale of the residuals, px.
#[inline(never)]
fn score_after<T: Scalar>(rows: &Rows<T>, d: &Vector5<T>, scale: T) -> T {
    let residuals = rows.iter().map(|row| residual(row, d));
    score(residuals.map(|r| r * r), scale)
}

/// Returns the residual of a row after a step, px.
#[inline(always)]
fn residual<T: Scalar>((value, [j0, j1, j2, j3, j4]): &(T, [T; 5]), d: &Vector5<T>) -> T {
    let [[a, b, c, e, f]] = d.data.0;
    *value + a * *j0 + b * *j1 + c * *j2 + e * *j3 + f * *j4
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::super::scenes::{batch, solvers};
    use super::*;
    use crate::algebra::symmetric5::Symmetric5;
    use std::vec::Vec;

    /// Returns pixels of a level pair, whose rows are equal up to noise. The first `shifted` right pixels are moved by
    /// `across` px, perpendicular to the rows.
    fn pixels(shifted: usize, across: f64) -> Vec<[f64; 4]> {
        let pixel = |i: usize| {
            let k = f64::from(u8::try_from(i).unwrap());
            let (u, v) =
                (3400.0 + 1200.0 * (k * 0.618).fract(), 3600.0 + 800.0 * (k * 0.414).fract());
            let noise = 0.3 * (7.0 * k).sin();
            [
                u,
                v,
                u - 20.0 - 60.0 * (k * 0.271).fract(),
                v + noise + if i < shifted { across } else { 0.0 },
            ]
        };
        (0..100).map(pixel).collect()
    }

    /// Returns the numbers of matches with residuals below 2 px, out of 30: at the level pose, and after the first
    /// round that finds a better pose. Half of the matches have row offsets of `away` px at the level pose; the row
    /// offsets of the other half are scattered from 15 px to 201 px.
    fn fit_after_rounds(away: f64) -> [usize; 2] {
        let shift = |i: usize| {
            let k = f64::from(u8::try_from(i % 7).unwrap());
            if i.is_multiple_of(2) { away } else { 15.0 + 31.0 * k }
        };
        let all = pixels(0, 0.0).into_iter().take(30).enumerate();
        let batch = batch::<f64>(all.map(|(i, [u, v, x, y])| [u, v, x, y + shift(i)]));
        let solver = solvers(&batch, [0.0; 3], [0.0; 2]).next().unwrap();
        let (by, pairs) = (solver.weighting(), batch.matches());
        let prior = Information(Symmetric5::of_diagonal([100.0; 5]));
        let mut rounds = Rounds::after_annealing(true);
        let step = (0..rounds.left)
            .find_map(|_| rounds.take(&solver.iterate.pose, &by, pairs, 1.0, &prior));
        let mut rows = Rows::new();
        take_rows(&by, pairs, &mut rows);
        let fit = |d: &Vector5<f64>| rows.iter().filter(|row| residual(row, d).abs() < 2.0).count();
        [Vector5::zeros(), step.map_or_else(Vector5::zeros, |(_, d)| d)].map(|d| fit(&d))
    }

    #[test]
    fn rounds_find_half_of_a_small_batch_among_outliers_and_keep_a_pose_that_fits_it() {
        for away in [6.0, -9.0, 12.0] {
            let [before, after] = fit_after_rounds(away);
            assert!(before < 5 && after >= 12, "{away}: {before} {after}");
        }
        assert_eq!(fit_after_rounds(0.0), [15; 2]);
    }

    #[test]
    fn improving_steps_lead_to_the_optimum_of_geman_mcclure_at_the_scale() {
        // The rows depend on three unknowns; the prior determines the other two.
        let row = |i: u8| {
            let k = f64::from(i);
            let r = (3.1 * k).sin() + if i.is_multiple_of(4) { 5.0 } else { 0.0 };
            (r, [1.0, (0.7 * k).sin(), (1.3 * k).cos(), 0.0, 0.0])
        };
        let rows: Rows<f64> = (0..60).map(row).collect();
        let prior = Information(Symmetric5::of_diagonal([1e-3; 5]));
        for scale in [0.5, 3.0] {
            let once = |d| improved(&rows, d, scale, &prior);
            let optimum = (0..20).fold(Vector5::zeros(), |d, _| once(d));
            let mut slope = optimum * 1e-3;
            for row @ (_, jacobian) in &rows {
                let r = residual(row, &optimum);
                slope += Vector5::from(*jacobian) * r / (1.0 + (r / scale).powi(2)).powi(2);
            }
            assert!(slope.norm() < 1e-9, "{scale}: {slope}");
        }
    }

    #[test]
    fn a_proposed_step_gains_at_least_a_fifth_of_a_match() {
        // Thirty rows that fit exactly after a step, and have the same residual before it.
        let improves = |residual: f64| {
            let row = |i: u8| {
                let k = f64::from(i);
                let jacobian = [1.0, k.sin(), (2.0 * k).sin(), (3.0 * k).cos(), (0.7 * k).cos()];
                (residual, jacobian)
            };
            let rows: Rows<f64> = (0..30).map(row).collect();
            let prior = Information(Symmetric5::of_diagonal([1e-6; 5]));
            let mut random = Random::NEW;
            best(&rows, 1.0, &prior, &mut random).is_some()
        };
        // At a scale of 1 px, the score grows by 30 - 30 / (1 + r^2).
        assert_eq!([0.07, 0.1].map(improves), [false, true]);
    }

    #[test]
    fn a_score_sums_the_cauchy_weights_of_residuals_at_its_scale() {
        let rows: Rows<f64> =
            [-2.0, 0.0, 4.0].map(|r| (r, [1.0, 0.0, 0.0, 0.0, 0.0])).into_iter().collect();
        assert_eq!(score_after(&rows, &Vector5::zeros(), 2.0), 0.5 + 1.0 + 0.2);
        assert_eq!(score_after(&rows, &(Vector5::x() * 2.0), 2.0), 1.0 + 0.5 + 0.1);
    }

    #[test]
    fn the_scale_of_a_score_grows_with_the_noise_above_its_least() {
        assert_eq!([0.5, 2.0, 5.0].map(scale), [0.7, 0.7, 1.5]);
    }

    /// Returns how many rows fit the optimum after one round from the level pose, with residuals below 1.5 px plus 0.3
    /// px of noise: rows of the shifted crowd, and rows of the level crowd. `None` if the round finds no better pose.
    fn found(shifted: usize, across: f64) -> Option<[usize; 2]> {
        let batch = batch::<f64>(pixels(shifted, across).into_iter());
        let solver = solvers(&batch, [0.0; 3], [0.0; 2]).next().unwrap();
        let prior = Information(Symmetric5::of_diagonal([100.0; 5]));
        let (by, mut rows) = (solver.weighting(), Rows::new());
        let mut rounds = Rounds::after_annealing(true);
        let (_, step) = rounds.take(&solver.iterate.pose, &by, batch.matches(), 1.0, &prior)?;
        take_rows(&by, batch.matches(), &mut rows);
        let fit_at_once = rows.iter().filter(|row| residual(row, &step).abs() < 1.0).count();
        assert!(fit_at_once > 20, "{fit_at_once}");
        let optimum = (0..20).fold(step, |d, _| improved(&rows, d, 1.0, &prior));
        let mut fit = [0; 2];
        for row in rows.iter().filter(|row| residual(row, &optimum).abs() < 1.5 + 0.3) {
            fit[usize::from(row.0.abs() < across / 2.0)] += 1;
        }
        Some(fit)
    }

    #[test]
    fn the_larger_of_two_crowds_is_found_and_the_smaller_one_is_not() {
        // The sample has 33 rows of the larger crowd and 17 of the smaller crowd.
        let [larger, smaller] = found(65, 8.0).unwrap();
        assert!(larger >= 30 && smaller == 0, "{larger} {smaller}");
        assert_eq!([found(35, 8.0), found(0, 0.0)], [None; 2]);
    }

    #[test]
    fn a_pose_that_fits_most_of_the_sample_and_few_of_all_correspondences_is_refused() {
        let [level, shifted] =
            [0, 100].map(|shifted| batch::<f64>(pixels(shifted, 8.0).into_iter()));
        let solver = solvers(&level, [0.0; 3], [0.0; 2]).next().unwrap();
        let prior = Information(Symmetric5::of_diagonal([100.0; 5]));
        let by = solver.weighting();
        let places: Vec<usize> = (0..100).collect();
        // 40 of the 50 sampled correspondences are shifted, and 40 or 75 of all 100.
        let sampled: Vec<usize> = scattered_over(&places, SAMPLED).copied().collect();
        let not_sampled = places.iter().filter(|place| !sampled.contains(place));
        for others in [0, 35] {
            let mut pairs = level.matches().to_vec();
            for place in sampled.iter().take(40).chain(not_sampled.clone().take(others)) {
                pairs[*place] = shifted.matches()[*place];
            }
            let [mut rounds, mut of_sample] = [Rounds::after_annealing(true); 2];
            let step = rounds.take(&solver.iterate.pose, &by, &pairs, 1.0, &prior);
            assert!(of_sample.propose(&by, &pairs, 1.0, &prior).is_some(), "{others}");
            assert_eq!(step.is_some(), others > 0);
        }
    }
}
