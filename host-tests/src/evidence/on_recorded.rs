//! Cells on recorded data: one method, one data set, one view.

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use stereo_selfcal::metrics::Deviation;

use super::measurement::{Cell, Measured, Runner};
use super::recorded_sets::{GATE_PX, Look, Recording, TURN_DEG};
use crate::baselines::Method;
use crate::bounds::joint_fit;
use crate::data::Rays;

/// Fewer matches than this say nothing of five unknowns.
const FEW: usize = 12;

/// `[e_t, e_theta]`, rad.
pub type Pair = [f64; 2];

/// Errors of one method on one data set from one view, rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// `e_t`, `e_theta` of all pairs fused (eqs 23, 24).
    pub fused: Pair,
    /// The same of each pair alone; `None` where it gave no estimate.
    pub single: Vec<Option<Pair>>,
}

/// One method on one data set from one view.
#[derive(Serialize)]
pub struct OnRecording<'a> {
    set: &'a str,
    digest: &'a str,
    view: &'static str,
    degrees: f64,
    method: &'static str,
    #[serde(skip)]
    look: &'a Look,
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
    look: &'a Look,
}

/// All methods on one data set from one view.
pub struct Row<'a> {
    /// The data set.
    pub set: &'a Recording,
    /// The view.
    pub look: &'a Look,
    /// Of each method, in their order.
    pub errors: Vec<Measured<Errors>>,
    /// `e_t`, `e_theta` of the joint fit of the matches that agree with the reference, rad.
    pub data_optimum: Measured<Pair>,
}

/// As two numbers.
#[must_use]
pub fn pair(deviation: Deviation<f64>) -> Pair {
    [deviation.translation, deviation.rotation]
}

impl Errors {
    /// `sigma_t`, `sigma_theta` (eqs 25, 26); `None` where no pair alone gave an estimate.
    #[must_use]
    pub fn sigma(&self) -> Option<Pair> {
        let solved = self.single.iter().flatten();
        let deviation = |&[translation, rotation]: &Pair| Deviation { translation, rotation };
        Deviation::root_mean_square(solved.map(deviation)).map(pair)
    }
}

impl<'a> OnRecording<'a> {
    /// Of a method, on a data set and one of its views.
    #[must_use]
    pub fn new(set: &'a Recording, look: &'a Look, by: &'a dyn Method) -> Self {
        let Recording { name, digest, .. } = set;
        Self { set: name, digest, view: look.view, degrees: TURN_DEG, method: by.name(), look, by }
    }
}

impl Cell for OnRecording<'_> {
    type Outcome = Errors;
    const KIND: &'static str = "recorded";

    fn label(&self) -> String {
        format!("{} on {}, {}", self.method, self.set, self.view)
    }

    fn measure(&self) -> Result<Errors> {
        let Look { pairs, setting, .. } = self.look;
        let fused = self.by.fused(pairs, setting).context("no estimate")?;
        let single = |k: usize| {
            let estimate = self.by.fused(&pairs[k..=k], setting)?;
            Some(pair(self.look.error_of_pair(k, &estimate)))
        };
        let single = (0..pairs.len()).map(single).collect();
        let fused = pair(self.look.error(&fused));
        ensure!(fused.iter().all(|e| e.is_finite()), "the estimate is not finite");
        Ok(Errors { fused, single })
    }
}

impl Cell for DataOptimum<'_> {
    type Outcome = Pair;
    const KIND: &'static str = "data optimum";

    fn label(&self) -> String {
        format!("joint fit on {}, {}", self.set, self.view)
    }

    fn measure(&self) -> Result<Pair> {
        let Look { pairs, truth, .. } = self.look;
        let agrees = self.look.agrees();
        let agreeing: Vec<Rays> =
            pairs.iter().flatten().filter(|rays| agrees(rays)).copied().collect();
        ensure!(agreeing.len() >= FEW, "{} matches agree with the reference", agreeing.len());
        Ok(pair(self.look.error(&joint_fit(truth, &agreeing))))
    }
}

/// All methods on all data sets from all views.
///
/// # Errors
/// If an outcome cannot be kept.
pub fn rows<'a>(
    runner: &Runner<'_>,
    sets: &'a [Recording],
    methods: &'a [Box<dyn Method>],
) -> Result<Vec<Row<'a>>> {
    let views: Vec<(&Recording, &Look)> =
        sets.iter().flat_map(|set| set.looks.iter().map(move |look| (set, look))).collect();
    let of_view = |&(set, look): &(&'a Recording, &'a Look)| {
        methods.iter().map(move |method| OnRecording::new(set, look, method.as_ref()))
    };
    let cells: Vec<OnRecording<'_>> = views.iter().flat_map(of_view).collect();
    let errors = runner.run(&cells)?;
    let optimum = |&(set, look): &(&'a Recording, &'a Look)| {
        let Recording { name, digest, .. } = set;
        let (view, degrees, gate_px) = (look.view, TURN_DEG, GATE_PX);
        DataOptimum { set: name, digest, view, degrees, gate_px, look }
    };
    let optima = runner.run(&views.iter().map(optimum).collect::<Vec<_>>())?;
    let of_methods = errors.chunks(methods.len().max(1)).map(<[_]>::to_vec);
    let rows = views.into_iter().zip(of_methods).zip(optima);
    Ok(rows
        .map(|(((set, look), errors), data_optimum)| Row { set, look, errors, data_optimum })
        .collect())
}
