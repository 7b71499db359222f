//! Measurements on recorded data: one method with its settings, one data set, one view.

use anyhow::{Context, Result, ensure};
use stereo_selfcal::geometry::metrics::Deviation;

use super::measurement::{Measured, Measurement, Runner};
use super::recorded_sets::{RecordedSet, SetView};
use crate::rivals::Variant;

/// `[e_t, e_theta]`, rad.
pub type ErrorPair = [f64; 2];

/// Errors of one method on one data set from one view, rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// `e_t`, `e_theta` of all pairs fused (eqs 23, 24).
    pub fused: ErrorPair,
    /// The same for each pair alone; `None` for a pair without an estimate.
    pub single: Vec<Option<ErrorPair>>,
}

/// A figure of a method on a data set from one view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Error of the fused `t`.
    ErrorT,
    /// Error of the fused `R`.
    ErrorTheta,
    /// RMS error of `t` of single pairs.
    SigmaT,
    /// RMS error of `R` of single pairs.
    SigmaTheta,
}

/// One method on one data set from one view.
struct OnSet<'a> {
    set: &'a str,
    seen: &'a SetView,
    by: &'a Variant,
}

/// All methods on one data set from one view.
pub struct Row<'a> {
    /// The data set.
    pub set: &'a RecordedSet,
    /// The view.
    pub seen: &'a SetView,
    /// Errors by method and settings, in their order.
    pub errors: Vec<Measured<Errors>>,
}

/// A deviation as two numbers.
#[must_use]
pub fn error_pair(deviation: Deviation<f64>) -> ErrorPair {
    [deviation.translation, deviation.rotation]
}

impl Quantity {
    /// All four quantities.
    pub const ALL: [Self; 4] = [Self::ErrorT, Self::ErrorTheta, Self::SigmaT, Self::SigmaTheta];

    /// Its symbol.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ErrorT => "e_t",
            Self::ErrorTheta => "e_theta",
            Self::SigmaT => "sigma_t",
            Self::SigmaTheta => "sigma_theta",
        }
    }

    /// 0 for `t`, 1 for `R`.
    #[must_use]
    pub fn part(self) -> usize {
        usize::from(matches!(self, Self::ErrorTheta | Self::SigmaTheta))
    }

    /// This figure of a method. A figure of single pairs is `None` if fewer than half of them have an estimate.
    #[must_use]
    pub fn of(self, errors: &Errors) -> Option<f64> {
        let pair = match self {
            Self::ErrorT | Self::ErrorTheta => Some(errors.fused),
            Self::SigmaT | Self::SigmaTheta => errors.sigma(),
        };
        Some(pair?[self.part()])
    }
}

impl Errors {
    /// `sigma_t`, `sigma_theta` (eqs 25, 26); `None` if fewer than half of the pairs have an estimate.
    #[must_use]
    pub fn sigma(&self) -> Option<ErrorPair> {
        let solved = self.single.iter().flatten();
        if 2 * self.solved() < self.single.len() {
            return None;
        }
        let deviation = |&[translation, rotation]: &ErrorPair| Deviation { translation, rotation };
        Deviation::root_mean_square(solved.map(deviation)).map(error_pair)
    }

    /// Single pairs with an estimate.
    #[must_use]
    pub fn solved(&self) -> usize {
        self.single.iter().flatten().count()
    }
}

impl Row<'_> {
    /// The least value of a quantity among some of the methods, and its method.
    #[must_use]
    pub fn least(&self, quantity: Quantity, among: &[usize]) -> Option<(usize, f64)> {
        let value = |&i: &usize| Some((i, quantity.of(self.errors[i].as_ref().ok()?)?));
        among.iter().filter_map(value).min_by(|(_, a), (_, b)| a.total_cmp(b))
    }
}

impl Measurement for OnSet<'_> {
    type Outcome = Errors;

    fn label(&self) -> String {
        format!("{} on {}, {}", self.by.name(), self.set, self.seen.words())
    }

    fn measure(&self) -> Result<Errors> {
        let SetView { pairs, setting, .. } = self.seen;
        let front = self.seen.front();
        let fused = self.by.fused(pairs, front, setting).context("no estimate")?;
        let single = |k: usize| {
            let estimate = self.by.fused(&pairs[k..=k], &front.pair(k), setting)?;
            Some(error_pair(self.seen.error_of_pair(k, &estimate)))
        };
        let single = (0..pairs.len()).map(single).collect();
        let fused = error_pair(self.seen.error(&fused));
        ensure!(fused.iter().all(|e| e.is_finite()), "the estimate is not finite");
        Ok(Errors { fused, single })
    }
}

/// Measures all methods with all their settings, on all data sets, from all views.
pub fn rows<'a>(
    runner: &Runner<'_>,
    sets: &'a [RecordedSet],
    variants: &'a [Variant],
) -> Vec<Row<'a>> {
    let of_set = |set: &'a RecordedSet| set.views.iter().map(move |seen| (set, seen));
    let views: Vec<(&RecordedSet, &SetView)> = sets.iter().flat_map(of_set).collect();
    let of_view = |&(set, seen): &(&'a RecordedSet, &'a SetView)| {
        variants.iter().map(move |by| OnSet { set: &set.name, seen, by })
    };
    let errors = runner.run(&views.iter().flat_map(of_view).collect::<Vec<_>>());
    let of_methods = errors.chunks(variants.len().max(1)).map(<[_]>::to_vec);
    views
        .into_iter()
        .zip(of_methods)
        .map(|((set, seen), errors)| Row { set, seen, errors })
        .collect()
}
