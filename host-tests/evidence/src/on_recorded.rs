//! Measurements on recorded data: one method with its settings, one data set, one view.

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use stereo_selfcal::geometry::metrics::Deviation;

use super::measurement::{Measured, Measurement, Runner};
use super::recorded_sets::{GATE_PX, RecordedSet, SetView, TURN_DEG};
use crate::rivals::Variant;
use rigs::data::Rays;
use sim::bounds::joint_fit;
use sim::stats::median;

/// Fewest matches of a gated fit, which has five unknowns.
const FEW: usize = 12;

/// `[e_t, e_theta]`, rad.
pub type ErrorPair = [f64; 2];

/// Errors of one method on one data set from one view, rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
#[derive(Serialize)]
struct OnSet<'a> {
    set: &'a str,
    digest: &'a str,
    camera: &'static str,
    view: &'static str,
    degrees: f64,
    method: String,
    #[serde(skip)]
    seen: &'a SetView,
    #[serde(skip)]
    by: &'a Variant,
}

/// The joint least-squares fit of the matches that agree with the reference.
#[derive(Serialize)]
struct GatedFit<'a> {
    set: &'a str,
    digest: &'a str,
    camera: &'static str,
    view: &'static str,
    degrees: f64,
    gate_px: f64,
    #[serde(skip)]
    seen: &'a SetView,
}

/// All methods on one data set from one view.
pub struct Row<'a> {
    /// The data set.
    pub set: &'a RecordedSet,
    /// The view.
    pub seen: &'a SetView,
    /// Errors by method and settings, in their order.
    pub errors: Vec<Measured<Errors>>,
    /// `e_t`, `e_theta` of the least-squares fit of the matches that agree with the reference, rad.
    pub gated_fit: Measured<ErrorPair>,
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

    /// Median of the errors of single pairs, where a pair without an estimate counts as the worst; `None` if the median
    /// is such a pair.
    #[must_use]
    pub fn median(&self) -> Option<ErrorPair> {
        let of = |part: usize| {
            let error = |e: &Option<ErrorPair>| e.map_or(f64::INFINITY, |e| e[part]);
            median(self.single.iter().map(error)).filter(|e| e.is_finite())
        };
        Some([of(0)?, of(1)?])
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
    const KIND: &'static str = "recorded";

    fn label(&self) -> String {
        format!("{} on {}, {}", self.method, self.set, self.seen.words())
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

impl Measurement for GatedFit<'_> {
    type Outcome = ErrorPair;
    const KIND: &'static str = "gated fit";

    fn label(&self) -> String {
        format!("gated fit on {}, {}", self.set, self.seen.words())
    }

    fn measure(&self) -> Result<ErrorPair> {
        let SetView { pairs, truth, .. } = self.seen;
        let agrees = self.seen.agrees();
        let agreeing: Vec<Rays> =
            pairs.iter().flatten().filter(|rays| agrees(rays)).copied().collect();
        ensure!(agreeing.len() >= FEW, "{} matches agree with the reference", agreeing.len());
        Ok(error_pair(self.seen.error(&joint_fit(truth, &agreeing))))
    }
}

/// Measures all methods with all their settings, on all data sets, from all views.
///
/// # Errors
/// If the cache cannot be written.
pub fn rows<'a>(
    runner: &Runner<'_>,
    sets: &'a [RecordedSet],
    variants: &'a [Variant],
) -> Result<Vec<Row<'a>>> {
    let views: Vec<(&RecordedSet, &SetView)> =
        sets.iter().flat_map(|set| set.views.iter().map(move |seen| (set, seen))).collect();
    let of_view = |&(set, seen): &(&'a RecordedSet, &'a SetView)| {
        variants.iter().map(move |by| {
            let (RecordedSet { name, digest, .. }, degrees) = (set, TURN_DEG);
            let SetView { camera, view, .. } = *seen;
            OnSet { set: name, digest, camera, view, degrees, method: by.name(), seen, by }
        })
    };
    let measurements: Vec<OnSet<'_>> = views.iter().flat_map(of_view).collect();
    let errors = runner.run(&measurements)?;
    let fit = |&(set, seen): &(&'a RecordedSet, &'a SetView)| {
        let RecordedSet { name, digest, .. } = set;
        let SetView { camera, view, .. } = *seen;
        let (degrees, gate_px) = (TURN_DEG, GATE_PX);
        GatedFit { set: name, digest, camera, view, degrees, gate_px, seen }
    };
    let fits = runner.run(&views.iter().map(fit).collect::<Vec<_>>())?;
    let of_methods = errors.chunks(variants.len().max(1)).map(<[_]>::to_vec);
    let rows = views.into_iter().zip(of_methods).zip(fits);
    Ok(rows
        .map(|(((set, seen), errors), gated_fit)| Row { set, seen, errors, gated_fit })
        .collect())
}
