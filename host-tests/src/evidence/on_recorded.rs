//! Cells on recorded data: one method, one data set, one view.

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use stereo_selfcal::metrics::Deviation;

use super::measurement::{Measured, Measurement, Runner};
use super::recorded_sets::{GATE_PX, RecordedSet, SetView, TURN_DEG};
use crate::baselines::Method;
use crate::bounds::joint_fit;
use crate::data::Rays;

/// Fewest matches for five unknowns.
const FEW: usize = 12;

/// `[e_t, e_theta]`, rad.
pub type ErrorPair = [f64; 2];

/// Errors of one method on one data set from one view, rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// `e_t`, `e_theta` of all pairs fused (eqs 23, 24).
    pub fused: ErrorPair,
    /// The same of each pair alone; `None` where it gave no estimate.
    pub single: Vec<Option<ErrorPair>>,
}

/// One method on one data set from one view.
#[derive(Serialize)]
pub struct OnSet<'a> {
    set: &'a str,
    digest: &'a str,
    view: &'static str,
    degrees: f64,
    method: &'static str,
    #[serde(skip)]
    seen: &'a SetView,
    #[serde(skip)]
    by: &'a dyn Method,
}

/// The joint maximum-likelihood fit of the matches that agree with the reference.
#[derive(Serialize)]
struct DataOptimum<'a> {
    set: &'a str,
    digest: &'a str,
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
    /// Errors of each method, in their order.
    pub errors: Vec<Measured<Errors>>,
    /// `e_t`, `e_theta` of the joint fit of the matches that agree with the reference, rad.
    pub data_optimum: Measured<ErrorPair>,
}

/// A deviation as two numbers.
#[must_use]
pub fn error_pair(deviation: Deviation<f64>) -> ErrorPair {
    [deviation.translation, deviation.rotation]
}

impl Errors {
    /// `sigma_t`, `sigma_theta` (eqs 25, 26); `None` where no pair alone gave an estimate.
    #[must_use]
    pub fn sigma(&self) -> Option<ErrorPair> {
        let solved = self.single.iter().flatten();
        let deviation = |&[translation, rotation]: &ErrorPair| Deviation { translation, rotation };
        Deviation::root_mean_square(solved.map(deviation)).map(error_pair)
    }
}

impl<'a> OnSet<'a> {
    /// A measurement of a method on a data set, from one of its views.
    #[must_use]
    pub fn new(set: &'a RecordedSet, seen: &'a SetView, by: &'a dyn Method) -> Self {
        let RecordedSet { name, digest, .. } = set;
        Self { set: name, digest, view: seen.view, degrees: TURN_DEG, method: by.name(), seen, by }
    }
}

impl Measurement for OnSet<'_> {
    type Outcome = Errors;
    const KIND: &'static str = "recorded";

    fn label(&self) -> String {
        format!("{} on {}, {}", self.method, self.set, self.view)
    }

    fn measure(&self) -> Result<Errors> {
        let SetView { pairs, setting, .. } = self.seen;
        let fused = self.by.fused(pairs, setting).context("no estimate")?;
        let single = |k: usize| {
            let estimate = self.by.fused(&pairs[k..=k], setting)?;
            Some(error_pair(self.seen.error_of_pair(k, &estimate)))
        };
        let single = (0..pairs.len()).map(single).collect();
        let fused = error_pair(self.seen.error(&fused));
        ensure!(fused.iter().all(|e| e.is_finite()), "the estimate is not finite");
        Ok(Errors { fused, single })
    }
}

impl Measurement for DataOptimum<'_> {
    type Outcome = ErrorPair;
    const KIND: &'static str = "data optimum";

    fn label(&self) -> String {
        format!("joint fit on {}, {}", self.set, self.view)
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

/// All methods on all data sets from all views.
///
/// # Errors
/// If the cache cannot be written.
pub fn rows<'a>(
    runner: &Runner<'_>,
    sets: &'a [RecordedSet],
    methods: &'a [Box<dyn Method>],
) -> Result<Vec<Row<'a>>> {
    let views: Vec<(&RecordedSet, &SetView)> =
        sets.iter().flat_map(|set| set.views.iter().map(move |seen| (set, seen))).collect();
    let of_view = |&(set, seen): &(&'a RecordedSet, &'a SetView)| {
        methods.iter().map(move |method| OnSet::new(set, seen, method.as_ref()))
    };
    let measurements: Vec<OnSet<'_>> = views.iter().flat_map(of_view).collect();
    let errors = runner.run(&measurements)?;
    let optimum = |&(set, seen): &(&'a RecordedSet, &'a SetView)| {
        let RecordedSet { name, digest, .. } = set;
        let (view, degrees, gate_px) = (seen.view, TURN_DEG, GATE_PX);
        DataOptimum { set: name, digest, view, degrees, gate_px, seen }
    };
    let optima = runner.run(&views.iter().map(optimum).collect::<Vec<_>>())?;
    let of_methods = errors.chunks(methods.len().max(1)).map(<[_]>::to_vec);
    let rows = views.into_iter().zip(of_methods).zip(optima);
    Ok(rows
        .map(|(((set, seen), errors), data_optimum)| Row { set, seen, errors, data_optimum })
        .collect())
}
