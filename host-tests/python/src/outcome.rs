//! Results of a pair as plain data. An array, a tuple or a dictionary is made when it is read.

#![allow(non_snake_case, reason = "the field's symbol")]

use std::collections::BTreeMap;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyString, PyTuple, PyType};
use rigs::data::in_f64;
use stereo_selfcal::outcome::{self, LensEstimate, StandardDeviations};
use stereo_selfcal::paper::FusedEstimate;
use stereo_selfcal::{PairReport, Proposal};

use crate::arguments::{Matrix, Points, Pose, Triple, Vector, pose};
use crate::engine::Outcome;
use crate::errors::{CoreError, name, raised};

/// Defines tuples that are read as named tuples of `stereo_selfcal._results`.
macro_rules! named_tuples {
    ($($name:ident($($field:ident: $type:ty),+);)+) => {$(
        #[derive(Clone, FromPyObject)]
        pub(crate) struct $name($(pub(crate) $type),+);

        impl<'py> IntoPyObject<'py> for $name {
            type Target = PyAny;
            type Output = Bound<'py, PyAny>;
            type Error = PyErr;

            fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
                static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
                let Self($($field),+) = self;
                CLASS.import(py, "stereo_selfcal._results", stringify!($name))?.call1(($($field),+))
            }
        }
    )+};
}
named_tuples! {
    Sd(rotation: f32, translation: f32);
    Finding(value: f32, sd: f32);
    Frame(sequence: u32, timestamp_us: u64);
    Matches(left: Points, right: Points, score: Vector);
}

/// Fields of a struct with their names, for a dictionary.
macro_rules! named {
    ($of:ident: $($field:ident)+) => { [$((stringify!($field), $of.$field)),+] };
}
pub(crate) use named;

/// Defines classes of plain data: fields with their values. They can be pickled.
macro_rules! data {
    ($(
        $(#[$attribute:meta])*
        $name:ident($($given:tt: $of:ty),+) { $($field:ident: $type:ty = $value:expr,)+ }
        { $($method:tt)* }
    )+) => {$(
        $(#[$attribute])*
        pub(crate) struct $name { $($field: $type),+ }

        impl $name {
            #[allow(clippy::unnecessary_wraps, reason = "some have values that can fail")]
            pub(crate) fn new($($given: $of),+) -> PyResult<Self> {
                Ok(Self { $($field: $value),+ })
            }
        }

        #[pymethods]
        #[allow(clippy::too_many_arguments, reason = "called by pickle")]
        impl $name {
            $($method)*

            #[staticmethod]
            fn _of($($field: $type),+) -> Self {
                Self { $($field),+ }
            }

            fn __reduce__<'py>(
                of: &Bound<'py, Self>,
            ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, pyo3::types::PyTuple>)> {
                let fields = [$(of.getattr(stringify!($field))?),+];
                Ok((of.getattr("_of")?, pyo3::types::PyTuple::new(of.py(), fields)?))
            }
        }
    )+};
}
pub(crate) use data;

data! {
    /// One stereo pair, solved.
    #[pyclass(frozen, get_all, module = "stereo_selfcal")]
    Pair(of: &PairReport<f32>, (R, t): Pose) {
        R: Matrix<3, 3> = R,
        t: Triple = t,
        rms_px_before: f32 = of.rms_px_before,
        rms_px_after: f32 = of.rms_px_after,
        noise_px: f32 = of.noise_px,
        usable: u32 = of.usable,
        fit: u32 = of.screened,
        skipped: u32 = of.skipped,
        passes: u16 = of.passes,
        stop: String = name(&of.stop),
    } {}

    /// Judgement of the calibration in use by the last pairs.
    #[pyclass(frozen, get_all, module = "stereo_selfcal")]
    Verdict(py: Python<'_>, of: &stereo_selfcal::Verdict<f32>) {
        rows_px: f32 = of.rows_px,
        depth_px: f32 = of.depth_px,
        coverage: f32 = of.coverage,
        image_coverage: f32 = of.image_coverage,
        rows_ok: bool = of.rows_ok,
        depth_ok: bool = of.depth_ok,
        may_arm: bool = of.may_arm,
        should_apply: bool = of.should_apply,
        reasons: Py<PyTuple> = {
            let reasons = of.reasons.iter().map(|reason| name(&reason));
            PyTuple::new(py, reasons.collect::<Vec<_>>())?.unbind()
        },
        cause: Option<String> = of.cause.map(|cause| cause.to_string()),
        text: String = of.to_string(),
    } {
        fn __repr__(&self) -> String {
            format!("<Verdict {}>", self.text)
        }
    }

    /// The calibration in use and the estimate, over the matches of the last pair.
    #[pyclass(frozen, get_all, module = "stereo_selfcal")]
    Details(of: &outcome::Details<f32>, proposal: &Proposal<f32>) {
        in_use_px: f32 = of.in_use_px,
        proposed_px: f32 = of.proposed_px,
        off_px: f32 = of.off_px,
        fit_in_use: u32 = of.fit_in_use,
        fit_proposed: u32 = of.fit_proposed,
        corner_px: f32 = of.corner_px,
        contradicting_ranges: u16 = of.contradicting_ranges,
        contradicting_motions: u16 = of.contradicting_motions,
        lens_yaw: Finding = finding(proposal.lens_yaw),
        lens: Option<BTreeMap<String, Finding>> = proposal.lens.as_ref().map(lens),
        weakest: (String, f32) = {
            let (of, sd) = proposal.weakest();
            (name(&of), sd)
        },
        yaw: f32 = of.yaw,
        vibration: Sd = Sd(proposal.vibration.rotation, proposal.vibration.baseline),
    } {}

    /// The estimate of the published method after a pair.
    #[pyclass(frozen, get_all, module = "stereo_selfcal")]
    Published(of: &FusedEstimate<f32>, (R, t): Pose) {
        R: Matrix<3, 3> = R,
        t: Triple = t,
        sd: Sd = deviations(of.sd),
        pairs: u32 = of.pairs,
        axis_is_meaningful: bool = of.axis_is_meaningful,
    } {}

    /// The estimate after a pair.
    #[pyclass(frozen, get_all, module = "stereo_selfcal")]
    Result(py: Python<'_>, of: &Outcome, (R, t): (Option<Matrix<3, 3>>, Option<Triple>)) {
        R: Option<Matrix<3, 3>> = R,
        t: Option<Triple> = t,
        state: String = name(&of.state),
        verdict: Py<Verdict> = Py::new(py, Verdict::new(py, &of.verdict)?)?,
        details: Option<Py<Details>> = match (&of.details, &of.proposal) {
            (Some(details), Some(proposal)) => Some(Py::new(py, Details::new(details, proposal)?)?),
            _ => None,
        },
        sd: Option<Sd> = of.proposal.as_ref().map(|of| deviations(of.sd)),
        sd_lens: Option<Sd> = of.proposal.as_ref().map(|of| deviations(of.sd_lens)),
        fused: Option<String> = of.fused.ok().as_ref().map(name),
        rejection: Option<Py<PyAny>> = of.fused.err().map(|why| exception(py, why)),
        pair: Option<Py<Pair>> = match &of.report {
            Some(of) => Some(Py::new(py, Pair::new(of, pose(&in_f64(&of.extrinsics)))?)?),
            None => None,
        },
        motion: Option<Py<PyAny>> = of.motion.map(|motion| match motion {
            Ok(witnessed) => PyString::new(py, &name(&witnessed)).into(),
            Err(why) => exception(py, why),
        }),
        pairs: u32 = of.proposal.as_ref().map_or(0, |of| of.pairs),
        grid_step: f32 = of.grid_step,
        offered: usize = of.matches[0],
        taken: usize = of.matches[1],
        refused: usize = of.matches[2],
        generation: u32 = of.generation,
        frame: Option<Frame> = of.frame.map(|header| Frame(header.sequence, header.timestamp_us)),
    } {
        fn __repr__(&self) -> String {
            let fused = self.fused.clone().or(self.rejection.as_ref().map(Py::to_string));
            let mut words = vec![format!("{}, {}", self.state, fused.unwrap_or_default())];
            if let (Some(Triple([x, y, z])), Some(Sd(r, t))) = (&self.t, &self.sd_lens) {
                words.push(format!("t {x:.5} {y:.5} {z:.5}, sd of R {r:.5}, of t {t:.5} rad"));
            }
            words.push(self.verdict.get().text.clone());
            format!("<Result {}>", words.join("; "))
        }
    }
}

impl Result {
    /// All results of a pair.
    pub(crate) fn of(py: Python<'_>, of: &Outcome) -> PyResult<Self> {
        let estimate = of.proposal.as_ref().map(|of| pose(&in_f64(&of.extrinsics)));
        Self::new(py, of, estimate.unzip())
    }
}

/// The exception of an error, not raised.
fn exception<E: CoreError>(py: Python<'_>, why: E) -> Py<PyAny> {
    raised("")(why).into_value(py).into_any()
}

fn deviations(of: StandardDeviations<f32>) -> Sd {
    Sd(of.rotation, of.translation)
}

fn finding(of: outcome::Finding<f32>) -> Finding {
    Finding(of.value, of.sd)
}

/// Errors of the lens models by their names.
fn lens(of: &LensEstimate<f32>) -> BTreeMap<String, Finding> {
    let errors = named! { of: focal k1 k1_mean p1 principal_x_px };
    errors.map(|(name, of)| (name.to_owned(), finding(of))).into()
}
