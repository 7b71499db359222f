//! Results of a pair as plain data. An array, a tuple or a dictionary is made when it is read.

#![allow(non_snake_case, reason = "the field's symbol")]

use std::fmt::Debug;

use host_tests::data::in_f64;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyString, PyTuple, PyType};
use stereo_selfcal::outcome::{self, LensEstimate, StandardDeviations};
use stereo_selfcal::{Health as CoreHealth, PairReport, Proposal, Reasons};

use crate::arguments::{Matrix, Vector, pose};
use crate::engine::Outcome;
use crate::errors::{CoreError, raised};

/// Defines tuples that are read as named tuples of `stereo_selfcal._results`.
macro_rules! named_tuples {
    ($($name:ident($($field:ident: $type:ty),+);)+) => {$(
        #[derive(Clone, FromPyObject)]
        pub(crate) struct $name($($type),+);

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
}

/// Errors of the lens models, read as a dictionary.
#[derive(Clone, FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Lens {
    focal: Finding,
    k1: Finding,
    k1_mean: Finding,
    p1: Finding,
    principal_x_px: Finding,
}

/// Defines classes of plain data: fields with their values. They can be pickled.
macro_rules! data {
    ($(
        $(#[$doc:meta])*
        $name:ident($($given:ident: $of:ty),+) { $($field:ident: $type:ty = $value:expr,)+ }
        { $($method:tt)* }
    )+) => {$(
        $(#[$doc])*
        #[pyclass(frozen, get_all, module = "stereo_selfcal")]
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
            ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
                let fields = [$(of.getattr(stringify!($field))?),+];
                Ok((of.getattr("_of")?, PyTuple::new(of.py(), fields)?))
            }
        }
    )+};
}
data! {
    /// One stereo pair, solved.
    Pair(of: &PairReport<f32>) {
        R: Matrix<3, 3> = pose(&in_f64(&of.extrinsics)).0,
        t: Vector = pose(&in_f64(&of.extrinsics)).1,
        rms_px_before: f32 = of.rms_px_before,
        rms_px_after: f32 = of.rms_px_after,
        noise_px: f32 = of.noise_px,
        usable: u32 = of.usable,
        fit: u32 = of.screened,
        skipped: u32 = of.skipped,
        passes: u16 = of.passes,
        stop: String = name(&of.stop),
    } {}

    /// The calibration in use and the estimate, over the matches of the last pair.
    Health(of: &CoreHealth<f32>, proposal: &Proposal<f32>) {
        may_arm: bool = of.may_arm(),
        band: String = name(&of.band),
        in_use_px: f32 = of.in_use_px,
        proposed_px: f32 = of.proposed_px,
        off_px: f32 = of.off_px,
        fit_in_use: u32 = of.fit_in_use,
        fit_proposed: u32 = of.fit_proposed,
        coverage: f32 = of.coverage,
        corner_px: f32 = of.corner_px,
        contradicting_ranges: u16 = of.contradicting_ranges,
        contradicting_motions: u16 = of.contradicting_motions,
        lens_yaw: Finding = proposal.lens_yaw.into(),
        lens: Option<Lens> = proposal.lens.as_ref().map(Lens::new),
        weakest: Option<(String, f32)> =
            proposal.weakest().map(|(direction, sd)| (name(&direction), sd)),
        yaw: f32 = of.yaw,
        vibration: Sd = Sd(proposal.vibration.rotation, proposal.vibration.baseline),
    } {}

    /// The estimate after a pair.
    Result(py: Python<'_>, of: &Outcome) {
        R: Option<Matrix<3, 3>> = of.proposal.as_ref().map(|of| pose(&in_f64(&of.extrinsics)).0),
        t: Option<Vector> = of.proposal.as_ref().map(|of| pose(&in_f64(&of.extrinsics)).1),
        state: String = name(&of.state),
        health: Option<Py<Health>> = match (&of.health, &of.proposal) {
            (Some(health), Some(proposal)) => Some(Py::new(py, Health::new(health, proposal)?)?),
            _ => None,
        },
        reasons: Py<PyTuple> = {
            let reasons = of.health.as_ref().map_or(Reasons::default(), |health| health.reasons);
            let names: Vec<String> = reasons.iter().map(|reason| name(&reason)).collect();
            PyTuple::new(py, names)?.unbind()
        },
        cause: Option<String> = of.cause.map(|cause| cause.to_string()),
        sd: Option<Sd> = of.proposal.as_ref().map(|of| of.sd.into()),
        sd_lens: Option<Sd> = of.proposal.as_ref().map(|of| of.sd_lens.into()),
        fused: Option<String> = of.fused.ok().as_ref().map(name),
        rejection: Option<Py<PyAny>> = of.fused.err().map(|why| exception(py, why)),
        pair: Option<Py<Pair>> =
            of.report.as_ref().map(|report| Py::new(py, Pair::new(report)?)).transpose()?,
        motion: Option<Py<PyAny>> = of.motion.map(|motion| match motion {
            Ok(witnessed) => PyString::new(py, &name(&witnessed)).into(),
            Err(why) => exception(py, why),
        }),
        pairs: u32 = of.proposal.as_ref().map_or(0, |of| of.pairs),
        offered: usize = of.matches[0],
        taken: usize = of.matches[1],
        refused: usize = of.matches[2],
        generation: u32 = of.generation,
        frame: Option<Frame> = of.frame.map(|header| Frame(header.sequence, header.timestamp_us)),
    } {
        fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
            let fused = self.fused.clone().or(self.rejection.as_ref().map(Py::to_string));
            let mut words = vec![format!("{}, {}", self.state, fused.unwrap_or_default())];
            if let (Some(Vector(t)), Some(Sd(sd_r, sd_t))) = (&self.t, &self.sd_lens) {
                let t: Vec<String> = t.iter().map(|x| format!("{x:.5}")).collect();
                words.push(format!("t {}, sd {sd_r:.5} and {sd_t:.5} rad", t.join(" ")));
            }
            if let Some(Health { in_use_px: used, proposed_px, .. }) = self.health.as_ref().map(Py::get) {
                words.push(format!("rows {used:.2} px in use, {proposed_px:.2} px by the estimate"));
            }
            let reasons: Vec<String> = self.reasons.extract(py)?;
            if !reasons.is_empty() {
                words.push(format!("against it: {}", reasons.join(", ")));
            }
            words.extend(self.cause.as_ref().map(|cause| format!("likely cause: {cause}")));
            Ok(format!("<Result {}>", words.join("; ")))
        }
    }
}

/// A name of the core in Python's style: `KeptApart` is `kept_apart`.
pub(crate) fn name(of: &impl Debug) -> String {
    let mut name = String::with_capacity(24);
    for letter in format!("{of:?}").chars().take_while(char::is_ascii_alphanumeric) {
        if letter.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.push(letter.to_ascii_lowercase());
    }
    name
}

/// The exception of an error, not raised.
fn exception<E: CoreError>(py: Python<'_>, why: E) -> Py<PyAny> {
    raised("")(why).into_value(py).into_any()
}

impl Lens {
    fn new(of: &LensEstimate<f32>) -> Self {
        let LensEstimate { focal, k1, k1_mean, p1, principal_x_px, .. } = *of;
        Self {
            focal: focal.into(),
            k1: k1.into(),
            k1_mean: k1_mean.into(),
            p1: p1.into(),
            principal_x_px: principal_x_px.into(),
        }
    }
}

impl From<outcome::Finding<f32>> for Finding {
    fn from(of: outcome::Finding<f32>) -> Self {
        Self(of.value, of.sd)
    }
}

impl From<StandardDeviations<f32>> for Sd {
    fn from(of: StandardDeviations<f32>) -> Self {
        Self(of.rotation, of.translation)
    }
}
