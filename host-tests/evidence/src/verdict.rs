//! Ours against the best rival, cell by cell.
//!
//! A cell is one data set, one view and one quantity. The rival in each cell is the method and the settings with the
//! best result there. Nobody can choose so beforehand, so this favours the rivals. The preset `paper` is a rival. A tie
//! is a difference within the standard error of the reference, if that is known. A cell is judged only if the truth
//! differs from the start by more than that error.

use super::on_recorded::{Quantity, Row};
use crate::rivals::Variant;
use sim::stats::geometric_mean;

/// Our method.
pub const OURS: &str = "robust";

/// Outcome of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Ours has the smaller error.
    Win,
    /// The difference is within the error of the reference.
    Tie,
    /// A rival has the smaller error, or ours has no estimate.
    Loss,
}

/// One cell.
pub struct Cell<'a> {
    /// Data set and view.
    pub row: &'a Row<'a>,
    /// The compared quantity.
    pub quantity: Quantity,
    /// Ours, rad; infinite without an estimate.
    pub ours: f64,
    /// The best rival, by its index among the variants, and its error, rad; infinite without an estimate.
    pub rival: (usize, f64),
    /// Outcome for ours.
    pub outcome: Outcome,
}

impl Cell<'_> {
    /// Error of the rival over ours.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.rival.1 / self.ours
    }

    /// Error of the start.
    #[must_use]
    pub fn still(&self) -> f64 {
        super::on_recorded::error_pair(self.row.seen.still())[self.quantity.part()]
    }
}

/// Indices of the variants of a method.
#[must_use]
pub fn of_method(variants: &[Variant], method: &str) -> Vec<usize> {
    let numbered = variants.iter().enumerate();
    numbered.filter(|(_, by)| by.method.name() == method).map(|(i, _)| i).collect()
}

/// Indices of the variants of all rivals.
#[must_use]
pub fn rivals(variants: &[Variant]) -> Vec<usize> {
    let numbered = variants.iter().enumerate();
    numbered.filter(|(_, by)| by.method.name() != OURS).map(|(i, _)| i).collect()
}

/// All judged cells, against some of the variants; empty without our method.
#[must_use]
pub fn cells<'a>(rows: &'a [Row<'a>], ours: &[usize], rivals: &[usize]) -> Vec<Cell<'a>> {
    let quantities = |row| Quantity::ALL.map(|quantity| (row, quantity));
    let all = rows.iter().flat_map(quantities);
    all.filter_map(|(row, quantity)| cell(row, quantity, ours, rivals)).collect()
}

fn cell<'a>(
    row: &'a Row<'a>,
    quantity: Quantity,
    ours: &[usize],
    rivals: &[usize],
) -> Option<Cell<'a>> {
    let part = quantity.part();
    if ours.is_empty() || !row.seen.is_evidence(row.set.reference)[part] {
        return None;
    }
    // A recording of one pair has no separate figure of single pairs: it would count twice.
    let of_single = matches!(quantity, Quantity::SigmaT | Quantity::SigmaTheta);
    if of_single && row.seen.pairs.len() < 2 {
        return None;
    }
    let ours = row.least(quantity, ours).map_or(f64::INFINITY, |(_, value)| value);
    let first = rivals.first().map(|&i| (i, f64::INFINITY))?;
    let rival = row.least(quantity, rivals).unwrap_or(first);
    let known = row.set.reference.map_or(0.0, |sd| [sd.translation, sd.rotation][part]);
    let outcome = if (ours - rival.1).abs() <= known {
        Outcome::Tie
    } else if ours < rival.1 {
        Outcome::Win
    } else {
        Outcome::Loss
    };
    Some(Cell { row, quantity, ours, rival, outcome })
}

/// Geometric mean of the rival's error over ours, over the cells in which both have an estimate.
#[must_use]
pub fn mean_ratio<'a>(cells: impl Iterator<Item = &'a Cell<'a>>) -> Option<f64> {
    geometric_mean(cells.map(Cell::ratio).filter(|ratio| ratio.ln().is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::on_recorded::Errors;
    use crate::recorded_sets::RecordedSet;
    use sim::synth::Scene;
    use stereo_selfcal::geometry::metrics::Deviation;

    fn outcome(ours: Option<f64>, rivals: [f64; 2]) -> (Outcome, usize) {
        let set = Scene { matches: 20, ..Scene::default() }.dataset(6, 1).unwrap();
        let reference = Some(Deviation { translation: 0.001, rotation: 0.001 });
        let set = RecordedSet { reference, ..RecordedSet::new(&set).unwrap() };
        let of = |fused: Option<f64>| match fused {
            Some(fused) => Ok(Errors { fused: [fused, 0.0], single: vec![None; 6] }),
            None => Err("no estimate".into()),
        };
        let seen = set.views.iter().find(|seen| (seen.camera, seen.view) == ("right", "left"));
        let errors = vec![of(ours), of(Some(rivals[0])), of(Some(rivals[1]))];
        let row = Row { set: &set, seen: seen.unwrap(), errors };
        let cell = cell(&row, Quantity::ErrorT, &[0], &[1, 2]).unwrap();
        (cell.outcome, cell.rival.0)
    }

    #[test]
    fn the_best_of_all_settings_counts_and_the_references_error_makes_a_tie() {
        assert_eq!(outcome(Some(0.01), [0.02, 0.05]), (Outcome::Win, 1));
        assert_eq!(outcome(Some(0.03), [0.05, 0.02]), (Outcome::Loss, 2));
        assert_eq!(outcome(Some(0.0105), [0.01, 0.02]), (Outcome::Tie, 1));
        assert_eq!(outcome(None, [0.05, 0.02]), (Outcome::Loss, 2));
    }
}
