//! Results of a pair as the plain data of `stereo_selfcal._results`.

use std::fmt::{Debug, Write};

use host_tests::data::{in_f64, rows};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};
use stereo_selfcal::outcome::{LensEstimate, StandardDeviations};
use stereo_selfcal::{Extrinsics, Health, PairReport, Proposal, Reasons};

use crate::arguments::{to_matrix, to_vector};
use crate::engine::Outcome;
use crate::errors::rejection;

/// Classes of `stereo_selfcal._results`.
struct Classes {
    result: Py<PyAny>,
    health: Py<PyAny>,
    pair: Py<PyAny>,
    sd: Py<PyAny>,
    finding: Py<PyAny>,
    frame: Py<PyAny>,
    /// `tuple.__new__`.
    new_tuple: Py<PyAny>,
}

impl Classes {
    fn get(py: Python<'_>) -> PyResult<&Self> {
        static CLASSES: PyOnceLock<Classes> = PyOnceLock::new();
        CLASSES.get_or_try_init(py, || {
            let module = py.import("stereo_selfcal._results")?;
            let class = |name| module.getattr(name).map(Bound::unbind);
            Ok(Self {
                result: class("Result")?,
                health: class("Health")?,
                pair: class("Pair")?,
                sd: class("Sd")?,
                finding: class("Finding")?,
                frame: class("Frame")?,
                new_tuple: py.get_type::<PyTuple>().getattr("__new__")?.unbind(),
            })
        })
    }
}

/// Calls a class with any number of arguments, in the order of its fields.
macro_rules! made {
    ($py:expr, $class:expr, $($argument:expr),+ $(,)?) => {{
        let arguments = [$($argument.into_bound_py_any($py)?),+];
        $class.bind($py).call1(PyTuple::new($py, arguments)?)
    }};
}

/// A name of the core in Python's style: `KeptApart` is `kept_apart`.
pub(crate) fn name(of: &impl Debug) -> String {
    let mut name = Name(String::new());
    // Ends at the first character that is not part of a name.
    let _ = write!(name, "{of:?}");
    name.0
}

struct Name(String);

impl Write for Name {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        for letter in text.chars() {
            if !letter.is_alphanumeric() {
                return Err(std::fmt::Error);
            }
            if letter.is_uppercase() && !self.0.is_empty() {
                self.0.push('_');
            }
            self.0.push(letter.to_ascii_lowercase());
        }
        Ok(())
    }
}

/// `Result` of a pair.
pub(crate) fn result<'py>(py: Python<'py>, outcome: &Outcome) -> PyResult<Bound<'py, PyAny>> {
    let Outcome { frame, matches: [offered, taken, refused], report, fused, .. } = outcome;
    let Outcome { proposal, health: checked, cause, state, generation, .. } = outcome;
    let classes = Classes::get(py)?;
    let (r, t) = pose(py, proposal.as_ref().map(|proposal| &proposal.extrinsics));
    let reasons = checked.as_ref().map_or(Reasons::default(), |health| health.reasons);
    let reasons: Vec<String> = reasons.iter().map(|reason| name(&reason)).collect();
    let reasons = PyTuple::new(py, reasons)?;
    let sd = |sd: Option<StandardDeviations<f32>>| {
        sd.map(|sd| two(py, &classes.sd, (sd.rotation, sd.translation))).transpose()
    };
    let frame = frame.map(|header| made!(py, classes.frame, header.sequence, header.timestamp_us));
    made!(
        py,
        classes.result,
        r,
        t,
        name(state),
        checked
            .as_ref()
            .zip(proposal.as_ref())
            .map(|(checked, proposal)| health(py, checked, proposal))
            .transpose()?,
        reasons,
        cause.map(|cause| cause.to_string()),
        sd(proposal.as_ref().map(|proposal| proposal.sd))?,
        sd(proposal.as_ref().map(|proposal| proposal.sd_lens))?,
        fused.ok().as_ref().map(name),
        fused.err().map(|why| rejection(py, why)).transpose()?,
        report.as_ref().map(|report| pair(py, classes, report)).transpose()?,
        proposal.as_ref().map_or(0, |proposal| proposal.pairs),
        *offered,
        *taken,
        *refused,
        *generation,
        frame.transpose()?,
    )
}

/// `Health`, with those numbers of the estimate that it needs.
pub(crate) fn health<'py>(
    py: Python<'py>,
    of: &Health<f32>,
    proposal: &Proposal<f32>,
) -> PyResult<Bound<'py, PyAny>> {
    let classes = Classes::get(py)?;
    made!(
        py,
        classes.health,
        of.may_arm(),
        name(&of.band),
        of.in_use_px,
        of.proposed_px,
        of.off_px,
        of.fit_in_use,
        of.fit_proposed,
        of.coverage,
        of.corner_px,
        of.contradicting_ranges,
        of.contradicting_motions,
        two(py, &classes.finding, (proposal.lens_yaw.value, proposal.lens_yaw.sd))?,
        proposal.lens.as_ref().map(|lens| lens_errors(py, classes, lens)).transpose()?,
        proposal.weakest().map(|(direction, sd)| (name(&direction), sd)),
        of.yaw,
        two(py, &classes.sd, (proposal.vibration.rotation, proposal.vibration.baseline))?,
    )
}

fn pair<'py>(
    py: Python<'py>,
    classes: &Classes,
    of: &PairReport<f32>,
) -> PyResult<Bound<'py, PyAny>> {
    let (r, t) = pose(py, Some(&of.extrinsics));
    made!(
        py,
        classes.pair,
        r,
        t,
        of.rms_px_before,
        of.rms_px_after,
        of.noise_px,
        of.usable,
        of.screened,
        of.skipped,
        of.passes,
        name(&of.stop),
    )
}

/// `R` and `t`, orthonormal in `f64`.
fn pose<'py>(
    py: Python<'py>,
    of: Option<&Extrinsics<f32>>,
) -> (Option<Bound<'py, PyAny>>, Option<Bound<'py, PyAny>>) {
    let Some(extrinsics) = of.map(in_f64) else { return (None, None) };
    let r = to_matrix(py, &rows(extrinsics.rotation().matrix()));
    let t = to_vector(py, extrinsics.translation().as_slice());
    (Some(r.into_any()), Some(t.into_any()))
}

/// A named tuple of two numbers. Calling its class takes four times as long.
fn two<'py>(
    py: Python<'py>,
    class: &Py<PyAny>,
    numbers: (f32, f32),
) -> PyResult<Bound<'py, PyAny>> {
    Classes::get(py)?.new_tuple.bind(py).call1((class, numbers))
}

fn lens_errors<'py>(
    py: Python<'py>,
    classes: &Classes,
    of: &LensEstimate<f32>,
) -> PyResult<Bound<'py, PyDict>> {
    let named = PyDict::new(py);
    for (name, found) in [
        ("focal", of.focal),
        ("k1", of.k1),
        ("k1_mean", of.k1_mean),
        ("p1", of.p1),
        ("principal_x_px", of.principal_x_px),
    ] {
        named.set_item(name, two(py, &classes.finding, (found.value, found.sd))?)?;
    }
    Ok(named)
}
