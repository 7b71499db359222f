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

/// Words that are read as a tuple.
#[derive(Clone, FromPyObject)]
pub(crate) struct Words(Vec<String>);

impl<'py> IntoPyObject<'py> for Words {
    type Target = PyTuple;
    type Output = Bound<'py, PyTuple>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        PyTuple::new(py, self.0)
    }
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

/// Defines classes whose values have these fields, and can be pickled.
macro_rules! data {
    ($(
        $(#[$doc:meta])*
        $name:ident { $($field:ident: $type:ty,)+ } { $($method:tt)* }
    )+) => {$(
        $(#[$doc])*
        #[pyclass(frozen, get_all, module = "stereo_selfcal")]
        pub(crate) struct $name { $($field: $type),+ }

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
    Pair {
        R: Matrix<3, 3>,
        t: Vector,
        rms_px_before: f32,
        rms_px_after: f32,
        noise_px: f32,
        usable: u32,
        fit: u32,
        skipped: u32,
        passes: u16,
        stop: String,
    } {}

    /// The calibration in use and the estimate, over the matches of the last pair.
    Health {
        may_arm: bool,
        band: String,
        in_use_px: f32,
        proposed_px: f32,
        off_px: f32,
        fit_in_use: u32,
        fit_proposed: u32,
        coverage: f32,
        corner_px: f32,
        contradicting_ranges: u16,
        contradicting_motions: u16,
        lens_yaw: Finding,
        lens: Option<Lens>,
        weakest: Option<(String, f32)>,
        yaw: f32,
        vibration: Sd,
    } {}

    /// The estimate after a pair.
    Result {
        R: Option<Matrix<3, 3>>,
        t: Option<Vector>,
        state: String,
        health: Option<Py<Health>>,
        reasons: Words,
        cause: Option<String>,
        sd: Option<Sd>,
        sd_lens: Option<Sd>,
        fused: Option<String>,
        rejection: Option<Py<PyAny>>,
        pair: Option<Py<Pair>>,
        motion: Option<Py<PyAny>>,
        pairs: u32,
        offered: usize,
        taken: usize,
        refused: usize,
        generation: u32,
        frame: Option<Frame>,
    } {
        fn __repr__(&self) -> String {
            let fused = self.fused.clone().or(self.rejection.as_ref().map(Py::to_string));
            let mut words = vec![format!("{}, {}", self.state, fused.unwrap_or_default())];
            if let (Some(Vector(t)), Some(Sd(sd_r, sd_t))) = (&self.t, &self.sd_lens) {
                let t: Vec<String> = t.iter().map(|x| format!("{x:.5}")).collect();
                words.push(format!("t {}, sd {sd_r:.5} and {sd_t:.5} rad", t.join(" ")));
            }
            if let Some(Health { in_use_px: used, proposed_px, .. }) = self.health.as_ref().map(Py::get) {
                words.push(format!("rows {used:.2} px in use, {proposed_px:.2} px by the estimate"));
            }
            if !self.reasons.0.is_empty() {
                words.push(format!("against it: {}", self.reasons.0.join(", ")));
            }
            words.extend(self.cause.as_ref().map(|cause| format!("likely cause: {cause}")));
            format!("<Result {}>", words.join("; "))
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

impl Result {
    pub(crate) fn new(py: Python<'_>, outcome: &Outcome) -> PyResult<Self> {
        let Outcome { matches: [offered, taken, refused], ref report, ref proposal, .. } = *outcome;
        let Outcome { ref health, state, generation, fused, .. } = *outcome;
        let estimate = proposal.as_ref().map(|proposal| pose(&in_f64(&proposal.extrinsics)));
        let (R, t) = estimate.unzip();
        let reasons = health.as_ref().map_or(Reasons::default(), |health| health.reasons);
        let health = health.as_ref().zip(proposal.as_ref());
        let health = health.map(|(health, proposal)| Health::new(health, proposal));
        Ok(Self {
            R,
            t,
            state: name(&state),
            health: health.map(|health| Py::new(py, health)).transpose()?,
            reasons: Words(reasons.iter().map(|reason| name(&reason)).collect()),
            cause: outcome.cause.map(|cause| cause.to_string()),
            sd: proposal.as_ref().map(|proposal| proposal.sd.into()),
            sd_lens: proposal.as_ref().map(|proposal| proposal.sd_lens.into()),
            fused: fused.ok().as_ref().map(name),
            rejection: fused.err().map(|why| exception(py, why)),
            pair: report.as_ref().map(|report| Py::new(py, Pair::new(report))).transpose()?,
            motion: outcome.motion.map(|motion| match motion {
                Ok(witnessed) => PyString::new(py, &name(&witnessed)).into(),
                Err(why) => exception(py, why),
            }),
            pairs: proposal.as_ref().map_or(0, |proposal| proposal.pairs),
            offered,
            taken,
            refused,
            generation,
            frame: outcome.frame.map(|header| Frame(header.sequence, header.timestamp_us)),
        })
    }
}

impl Health {
    /// * `proposal`: has some of the numbers.
    pub(crate) fn new(of: &CoreHealth<f32>, proposal: &Proposal<f32>) -> Self {
        Self {
            may_arm: of.may_arm(),
            band: name(&of.band),
            in_use_px: of.in_use_px,
            proposed_px: of.proposed_px,
            off_px: of.off_px,
            fit_in_use: of.fit_in_use,
            fit_proposed: of.fit_proposed,
            coverage: of.coverage,
            corner_px: of.corner_px,
            contradicting_ranges: of.contradicting_ranges,
            contradicting_motions: of.contradicting_motions,
            lens_yaw: proposal.lens_yaw.into(),
            lens: proposal.lens.as_ref().map(Lens::new),
            weakest: proposal.weakest().map(|(direction, sd)| (name(&direction), sd)),
            yaw: of.yaw,
            vibration: Sd(proposal.vibration.rotation, proposal.vibration.baseline),
        }
    }
}

impl Pair {
    fn new(of: &PairReport<f32>) -> Self {
        let PairReport { rms_px_before, rms_px_after, noise_px, usable, skipped, passes, .. } = *of;
        let (R, t) = pose(&in_f64(&of.extrinsics));
        let (fit, stop) = (of.screened, name(&of.stop));
        Self { R, t, rms_px_before, rms_px_after, noise_px, usable, fit, skipped, passes, stop }
    }
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
