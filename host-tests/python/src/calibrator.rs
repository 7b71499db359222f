//! `Calibrator`: one thread at a time, without the GIL while it computes.

use std::sync::{Mutex, TryLockError};

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use stereo_selfcal::depth::{Range, RangeReading};

use crate::arguments::{POINTS, matches, same_length};
use crate::calibration::Calibration;
use crate::engine::{Engine, Settings, each};
use crate::errors::{busy, raised, value};
use crate::outcome::{Health, Result, name};
use crate::rig::Rig;

/// The calibrator of one rig.
#[pyclass(frozen, module = "stereo_selfcal")]
pub(crate) struct Calibrator {
    settings: Settings,
    engine: Mutex<Engine>,
}

/// Calls the core for a calibrator of any capacity.
macro_rules! call {
    ($calibrator:expr, $py:expr, $held:ident => $call:expr) => {
        $calibrator.with($py, |engine| each!(engine, $held => $call))?
    };
}

/// Arrays of a tracked pair: left and right points.
type Views<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

#[pymethods]
impl Calibrator {
    #[new]
    #[pyo3(signature = (rig, capacity=256, preset="robust", **options))]
    fn new(
        py: Python<'_>,
        rig: Rig,
        capacity: usize,
        preset: &str,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let options = options.map_or_else(|| Ok(PyDict::new(py)), PyDictMethods::copy)?;
        let settings =
            Settings { rig, capacity, preset: preset.to_owned(), options: options.unbind() };
        Ok(Self { engine: Mutex::new(settings.engine(py)?), settings })
    }

    #[pyo3(signature = (uv_left, uv_right, score=None, *, grid_step=0.0))]
    fn fuse(
        &self,
        py: Python<'_>,
        uv_left: &Bound<'_, PyAny>,
        uv_right: &Bound<'_, PyAny>,
        score: Option<&Bound<'_, PyAny>>,
        grid_step: f64,
    ) -> PyResult<Result> {
        let pair = matches(POINTS, uv_left, uv_right, score, grid_step)?;
        let outcome = call!(self, py, held => held.fuse(&pair));
        Result::new(py, &outcome.map_err(raised("uv_left, uv_right"))?)
    }

    fn feed_frames(&self, py: Python<'_>, data: &[u8]) -> PyResult<Vec<Result>> {
        let outcomes = call!(self, py, held => held.feed(data)).map_err(raised("data"))?;
        outcomes.iter().map(|outcome| Result::new(py, outcome)).collect()
    }

    #[getter]
    fn link<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let c = call!(self, py, held => *held.decoder.counters());
        let named = PyDict::new(py);
        for (name, count) in [
            ("good", c.good),
            ("bad_crc", c.bad_crc),
            ("bad_header", c.bad_header),
            ("unsupported", c.unsupported),
            ("truncated", c.truncated),
            ("gaps", c.gaps),
            ("repeats", c.repeats),
            ("restarts", c.restarts),
            ("overruns", c.overruns),
            ("refused", c.refused),
            ("skipped_bytes", c.skipped_bytes),
        ] {
            named.set_item(name, count)?;
        }
        Ok(named)
    }

    #[pyo3(signature = (pixel, range_m, sd_m, *, along="ray", right=None))]
    fn push_range(
        &self,
        py: Python<'_>,
        pixel: [f64; 2],
        range_m: f64,
        sd_m: f64,
        along: &str,
        right: Option<[f64; 2]>,
    ) -> PyResult<String> {
        let range = match along {
            "ray" => Range::AlongRay(range_m as f32),
            "axis" => Range::AlongAxis(range_m as f32),
            other => return Err(value(format!("along: 'ray' or 'axis', not {other:?}"))),
        };
        let single = |pixel: [f64; 2]| pixel.map(|x| x as f32);
        let (pixel, right) = (single(pixel), right.map(single));
        let reading = RangeReading { pixel, right, range, sd_m: sd_m as f32 };
        let witnessed = call!(self, py, held => held.calibrator.push_witness(&reading));
        Ok(name(&witnessed.map_err(raised("range"))?))
    }

    #[pyo3(signature = (before, after))]
    fn push_motion(&self, py: Python<'_>, before: Views<'_>, after: Views<'_>) -> PyResult<String> {
        let views = |names, (left, right): &Views<'_>| matches(names, left, right, None, 0.0);
        let before = views(["before[0]", "before[1]"], &before)?;
        let after = views(["after[0]", "after[1]"], &after)?;
        same_length("after[0]", after.len(), before.len())?;
        let tracked: Vec<_> = before.into_iter().zip(after).map(<[_; 2]>::from).collect();
        let witnessed = call!(self, py, held => held.push_motion(&tracked));
        Ok(name(&witnessed.map_err(raised("before, after"))?))
    }

    fn apply(&self, py: Python<'_>) -> PyResult<Calibration> {
        let applied = call!(self, py, held => held.calibrator.apply()).map_err(raised(""))?;
        Ok(Calibration::new(&self.settings.rig, applied))
    }

    fn undo(&self, py: Python<'_>) -> PyResult<Calibration> {
        let undone = call!(self, py, held => held.calibrator.undo()).map_err(raised(""))?;
        Ok(Calibration::new(&self.settings.rig, undone))
    }

    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        Ok(call!(self, py, held => held.calibrator.reset()))
    }

    fn health(&self, py: Python<'_>) -> PyResult<Option<Health>> {
        let found = call!(self, py, held => (held.calibrator.health(), held.calibrator.proposal()));
        let (Ok(health), Some(proposal)) = found else { return Ok(None) };
        Health::new(&health, &proposal).map(Some)
    }

    #[getter]
    fn in_use(&self, py: Python<'_>) -> PyResult<Calibration> {
        let in_use = call!(self, py, held => held.calibrator.in_use());
        Ok(Calibration::new(&self.settings.rig, in_use))
    }

    #[getter]
    fn state(&self, py: Python<'_>) -> PyResult<String> {
        Ok(call!(self, py, held => held.calibrator.state()).to_string())
    }

    #[getter]
    fn generation(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(call!(self, py, held => held.calibrator.in_use().generation))
    }

    #[getter]
    fn frozen(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(call!(self, py, held => held.is_frozen()))
    }

    #[setter]
    fn set_frozen(&self, py: Python<'_>, frozen: bool) -> PyResult<()> {
        Ok(call!(self, py, held => held.calibrator.set_frozen(frozen)))
    }

    #[getter]
    fn rig(&self) -> Rig {
        self.settings.rig.clone()
    }

    #[getter]
    fn capacity(&self) -> usize {
        self.settings.capacity
    }

    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &call!(self, py, held => held.calibrator.snapshot())))
    }

    fn load(&self, py: Python<'_>, record: &[u8]) -> PyResult<()> {
        call!(self, py, held => held.load(record)).map_err(raised("record"))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Settings { capacity, preset, rig, .. } = &self.settings;
        Ok(format!(
            "<Calibrator {}, {preset}, {capacity} matches, {}>",
            self.state(py)?,
            rig.__repr__()
        ))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let Settings { rig, capacity, preset, options } = &self.settings;
        let partial = py.import("functools")?.getattr("partial")?;
        let make = partial.call((py.get_type::<Self>(),), Some(options.bind(py)))?;
        let arguments = (rig.clone(), capacity, preset);
        (make, arguments, self.save(py)?).into_pyobject(py)
    }

    fn __setstate__(&self, py: Python<'_>, record: &[u8]) -> PyResult<()> {
        self.load(py, record)
    }
}

impl Calibrator {
    /// Calls the core without the GIL.
    ///
    /// # Errors
    /// `BusyError` if another thread is in a call, or was in one at a fork.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        call: impl FnOnce(&mut Engine) -> T + Send,
    ) -> PyResult<T> {
        let mut held = self.engine.try_lock().map_err(|why| match why {
            TryLockError::WouldBlock => busy(),
            TryLockError::Poisoned(_) => value("the calibrator has failed: make a new one"),
        })?;
        let engine: &mut Engine = &mut held;
        Ok(py.detach(move || call(engine)))
    }
}
