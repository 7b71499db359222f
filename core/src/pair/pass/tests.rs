//! Compares the sums of a pass with their definition, and tests which half of a batch is read.

extern crate std;

use nalgebra::Vector5;

use super::*;
use crate::pair::constraint::PoseTerms;
use crate::pair::scenes::{batch, pixels, solvers};
use proptest::prelude::*;
use std::vec::Vec;

/// Returns the weight of a residual according to the definitions of the losses.
fn weight(by: &Weighting<f64>, pair: &RayPair<f64>, constraint: &Constraint<f64>) -> f64 {
    let r2 = by.focal_squared * constraint.value.powi(2) / constraint.variance;
    let of_grid = pair.grid_step().powi(2) / 12.0;
    let variance = by.noise_squared + of_grid;
    let unit_squared = variance.max((0.6 * pair.grid_step()).powi(2));
    let biweight = |x: f64| (1.0 - x).max(0.0).powi(2) / variance;
    match &by.loss {
        Loss::Anneal(unit) => unit / (1.0 + r2 * unit).powi(2),
        _ if !constraint.has_disparity(by.min_disparity) => 0.0,
        Loss::Track(covariance) => {
            let j = Vector5::from(constraint.jacobian);
            let of_pose =
                j.dot(&(covariance.matrix() * j)) * by.focal_squared / constraint.variance;
            biweight(r2 / (by.tukey_squared * (unit_squared + of_pose)))
        }
        Loss::Polish => biweight(r2 / (by.tukey_squared * unit_squared)),
    }
}

proptest! {
    #[test]
    fn a_pass_sums_weighted_rows_and_counts_as_defined(
        pixels in pixels(), rotation in [-0.1..0.1, -0.3..0.3, -0.1..0.1],
        t in [-0.1..0.1, -0.1..0.1],
    ) {
        let batch = batch::<f64>(pixels.into_iter());
        for solver in solvers(&batch, rotation, t) {
            let by = solver.weighting();
            let frame = PoseTerms::at(&solver.iterate.pose);
            let (mut normal, mut usable, mut weighted) = (NormalEquations::ZERO, 0.0, 0.0);
            for pair in read(batch.matches(), false) {
                let Some(constraint) = Constraint::of(&frame, pair) else { continue };
                usable += 1.0;
                let w = weight(&by, pair, &constraint);
                weighted += f64::from(w > 0.0);
                let (row, _) = by.row(&constraint, by.precision(&constraint), w);
                normal.add_row(row.weight, row.value, &row.jacobian);
            }
            let sums = PassSums::of(&solver.iterate, &solver.phase, batch.matches());
            prop_assert_eq!((sums.usable, sums.weighted), (usable, weighted));
            let size = normal.information.0.diagonal().into_iter().fold(0.0, f64::max);
            let (ours, theirs) = (&sums.normal.information.0.0, &normal.information.0.0);
            for (a, b) in ours.iter().zip(theirs) {
                prop_assert!((a - b).abs() <= 1e-9 * size, "{a} {b} of {size}");
            }
            let most = 1e-9 * (size * weighted).sqrt() * by.tukey_squared.sqrt();
            let gap = (sums.normal.gradient - normal.gradient).amax();
            prop_assert!(gap <= most, "{gap} of {most}");
        }
    }
}

/// Returns the percentage of the places read, if half of a batch is read, for which `is_among` holds.
fn percent_read(length: usize, is_among: impl Fn(usize) -> bool) -> usize {
    let all: Vec<usize> = (0..length).collect();
    let read: Vec<_> = read(&all, true).collect();
    100 * read.iter().filter(|place| is_among(***place)).count() / read.len()
}

#[test]
fn half_of_the_batch_follows_no_period() {
    for length in (TRACKED + 1..=1024).step_by(17) {
        // Outliers fill half of the places of each period, at any phase.
        for period in 2..=64 {
            for first in 0..period {
                let among = |place| (place + first) % period < period / 2;
                let percent = percent_read(length, among);
                assert!(percent < 65, "{length} {period} {first}: {percent}");
            }
        }
    }
}

#[test]
fn a_pass_reads_all_of_the_batch_or_half() {
    for length in 0..=1024_usize {
        let all: Vec<usize> = (0..length).collect();
        assert!(read(&all, false).eq(&all), "{length}");
        let read: Vec<_> = read(&all, true).collect();
        assert!(
            read.is_sorted_by(|a, b| a < b) && read.len().abs_diff(length / 2) <= 1,
            "{read:?}"
        );
    }
}
