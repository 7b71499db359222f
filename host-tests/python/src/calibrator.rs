//! `Calibrator`: one thread at a time, without the GIL while it computes.

use std::collections::BTreeMap;
use std::sync::{Mutex, TryLockError};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use stereo_selfcal::depth::{Range, RangeReading};
use stereo_selfcal::{ApplyError, Config, Correspondence, LensTracking, Rejection};

use crate::arguments::{Given, POINTS, matches, motion, same_length};
use crate::calibration::Calibration;
use crate::engine::{Engine, Outcome, each};
use crate::errors::{busy, name, raised, unknown, value};
use crate::outcome::{Details, Result, Verdict, named};
use crate::pool::install;
use crate::rig::Rig;

/// The calibrator of one rig.
#[pyclass(frozen, module = "stereo_selfcal")]
pub(crate) struct Calibrator {
    #[pyo3(get)]
    rig: Rig,
    #[pyo3(get)]
    capacity: i64,
    settings: Settings,
    engine: Mutex<Engine>,
}

/// Arguments of a calibrator by their names.
#[derive(Debug, Clone, Default, IntoPyObject)]
struct Settings {
    lens: String,
    max_correction_rad: Option<f64>,
    memory_pairs: Option<i64>,
    rows_limit_px: Option<f64>,
    depth_limit_px: Option<f64>,
    coverage_limit: Option<f64>,
    motion: bool,
}

/// Calls the core for a calibrator of any capacity.
macro_rules! call {
    ($calibrator:expr, $py:expr, $held:ident => $call:expr) => {
        $calibrator.with($py, |engine| each!(engine, $held => $call))?
    };
}

/// Arrays of a tracked pair: left and right points.
type Views<'py> = [Given<'py>; 2];

#[pymethods]
impl Calibrator {
    #[new]
    #[pyo3(signature = (
        rig, capacity=256, *, lens="report", max_correction_rad=None, memory_pairs=None,
        rows_limit_px=None, depth_limit_px=None, coverage_limit=None, motion=false
    ))]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        rig: Rig,
        capacity: i64,
        lens: &str,
        max_correction_rad: Option<f64>,
        memory_pairs: Option<i64>,
        rows_limit_px: Option<f64>,
        depth_limit_px: Option<f64>,
        coverage_limit: Option<f64>,
        #[pyo3(from_py_with = motion)] motion: bool,
    ) -> PyResult<Self> {
        let settings = Settings {
            lens: lens.into(),
            max_correction_rad,
            memory_pairs,
            rows_limit_px,
            depth_limit_px,
            coverage_limit,
            motion,
        };
        let engine = Mutex::new(settings.engine(&rig, capacity)?);
        Ok(Self { rig, capacity, settings, engine })
    }

    #[pyo3(signature = (uv_left, uv_right, score=None, *, grid_step=0.0))]
    fn fuse(
        &self,
        py: Python<'_>,
        uv_left: &Given<'_>,
        uv_right: &Given<'_>,
        score: Option<&Given<'_>>,
        grid_step: f64,
    ) -> PyResult<Result> {
        let pair = matches(POINTS, [uv_left, uv_right], score, grid_step)?;
        let outcome = call!(self, py, held => held.attempt(|held| {
            let outcome = held.fuse(&pair);
            match outcome.fused {
                // The pair does not belong to this rig: arguments are exchanged, or the rig is another one.
                Err(why @ (Rejection::Behind | Rejection::Columns)) => Err(why),
                _ => Ok(outcome),
            }
        }));
        Result::of(py, &outcome.map_err(raised("uv_left, uv_right"))?)
    }

    fn feed_frames(&self, py: Python<'_>, data: &[u8]) -> PyResult<Vec<Result>> {
        let outcomes = call!(self, py, held => held.feed(data)).map_err(raised("data"))?;
        outcomes.iter().map(|outcome| Result::of(py, outcome)).collect()
    }

    #[getter]
    fn link(&self, py: Python<'_>) -> PyResult<BTreeMap<&str, u32>> {
        let c = call!(self, py, held => *held.decoder.counters());
        let counts = named! {
            c: good bad_crc bad_header unsupported gaps repeats restarts overruns refused skipped_bytes
        };
        Ok(counts.into())
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
            other => return Err(unknown("along", "'ray' or 'axis'", other)),
        };
        let single = |pixel: [f64; 2]| pixel.map(|x| x as f32);
        let (pixel, right) = (single(pixel), right.map(single));
        let reading = RangeReading { pixel, right, range, sd_m: sd_m as f32 };
        let witnessed = call!(self, py, held => held.calibrator.push_range(&reading));
        Ok(name(&witnessed.map_err(raised("range"))?))
    }

    fn push_motion(&self, py: Python<'_>, before: Views<'_>, after: Views<'_>) -> PyResult<String> {
        let before = matches(["before[0]", "before[1]"], before.each_ref(), None, 0.0)?;
        let after = matches(["after[0]", "after[1]"], after.each_ref(), None, 0.0)?;
        same_length("after[0]", after.len(), before.len())?;
        let tracked = [before, after];
        let witnessed = call!(self, py, held => held.push_motion(&tracked));
        Ok(name(&witnessed.map_err(raised("before, after"))?))
    }

    fn apply(&self, py: Python<'_>) -> PyResult<Calibration> {
        let applied = call!(self, py, held => held.calibrator.apply()).map_err(raised(""))?;
        Calibration::of(&self.rig, &applied)
    }

    fn undo(&self, py: Python<'_>) -> PyResult<Calibration> {
        let undone = call!(self, py, held => held.calibrator.undo()).map_err(raised(""))?;
        Calibration::of(&self.rig, &undone)
    }

    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        Ok(call!(self, py, held => held.calibrator.reset()))
    }

    #[getter]
    fn verdict(&self, py: Python<'_>) -> PyResult<Verdict> {
        Verdict::new(py, &call!(self, py, held => *held.calibrator.verdict()))
    }

    fn details(&self, py: Python<'_>) -> PyResult<Option<Details>> {
        let found =
            call!(self, py, held => (held.calibrator.details(), held.calibrator.proposal()));
        let (Some(details), Some(proposal)) = found else { return Ok(None) };
        Details::new(&details, &proposal).map(Some)
    }

    #[getter]
    fn in_use(&self, py: Python<'_>) -> PyResult<Calibration> {
        Calibration::of(&self.rig, &call!(self, py, held => held.calibrator.in_use()))
    }

    #[getter]
    fn state(&self, py: Python<'_>) -> PyResult<String> {
        Ok(call!(self, py, held => held.calibrator.state()).to_string())
    }

    #[getter]
    fn generation(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(call!(self, py, held => held.calibrator.in_use().generation))
    }

    /// Whether the calibrator is frozen. A record given to `load` may have frozen it, so a copy of the calibrator is
    /// asked to undo: a frozen one refuses with `ApplyError::Frozen` before any other reason.
    #[getter]
    fn frozen(&self, py: Python<'_>) -> PyResult<bool> {
        let undone = call!(self, py, held => held.calibrator.clone().undo());
        Ok(undone == Err(ApplyError::Frozen))
    }

    #[setter]
    fn set_frozen(&self, py: Python<'_>, frozen: bool) -> PyResult<()> {
        Ok(call!(self, py, held => held.calibrator.set_frozen(frozen)))
    }

    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &call!(self, py, held => held.calibrator.snapshot())))
    }

    fn load(&self, py: Python<'_>, record: &[u8]) -> PyResult<()> {
        let restored =
            call!(self, py, held => held.attempt(|held| held.calibrator.restore(record)));
        restored.map_err(raised("record"))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (Self { capacity, .. }, rig) = (self, self.rig.__repr__()?);
        Ok(format!("<Calibrator {}, {capacity} matches, {rig}>", self.state(py)?))
    }

    fn __getnewargs_ex__(&self) -> ((Rig, i64), Settings) {
        ((self.rig.clone(), self.capacity), self.settings.clone())
    }

    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.save(py)
    }

    fn __setstate__(&self, py: Python<'_>, record: &[u8]) -> PyResult<()> {
        self.load(py, record)
    }
}

impl Calibrator {
    /// The verdict after the last pair, and the generation of the calibration in use.
    pub(crate) fn now(&self, py: Python<'_>) -> PyResult<(stereo_selfcal::Verdict<f32>, u32)> {
        Ok(call!(self, py, held => {
            let calibrator = &held.calibrator;
            (*calibrator.verdict(), calibrator.in_use().generation)
        }))
    }

    /// Calls the core without the GIL.
    ///
    /// # Errors
    /// `BusyError` if another thread is in a call, or was in one at a fork; `ValueError` if an earlier call panicked.
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

impl Settings {
    /// A new calibrator.
    ///
    /// # Errors
    /// Names the argument.
    fn engine(&self, rig: &Rig, capacity: i64) -> PyResult<Engine> {
        let mut config = match &*self.lens {
            "report" => Config::robust(),
            "given" => Config::robust().without_lens_prior(),
            "compensate" => Config::robust().with_lens_tracking(LensTracking::Compensate),
            other => return Err(unknown("lens", "'report', 'given' or 'compensate'", other)),
        };
        if let Some(rad) = self.max_correction_rad {
            let limited = config.with_max_correction_rad(rad as f32);
            config = limited.map_err(raised("max_correction_rad"))?;
        }
        if let Some(pairs) = self.memory_pairs {
            let pairs = u32::try_from(pairs.max(0)).unwrap_or(u32::MAX);
            config = config.with_memory_pairs(pairs).map_err(raised("memory_pairs"))?;
        }
        if let Some(px) = self.rows_limit_px {
            config = config.with_rows_limit_px(px as f32).map_err(raised("rows_limit_px"))?;
        }
        if let Some(px) = self.depth_limit_px {
            config = config.with_depth_limit_px(px as f32).map_err(raised("depth_limit_px"))?;
        }
        if let Some(share) = self.coverage_limit {
            config = config.with_coverage_limit(share as f32).map_err(raised("coverage_limit"))?;
        }
        let (engine, known) =
            (Engine::new(capacity, config, &rig.made()?, self.motion), Engine::CAPACITIES);
        engine.ok_or_else(|| value(format!("capacity: one of {known:?}, not {capacity}")))
    }
}

/// Solves each pair alone, from the factory extrinsics.
#[pyfunction]
#[pyo3(signature = (rig, pairs, capacity=256))]
pub(crate) fn solve_pairs(
    py: Python<'_>,
    rig: Rig,
    pairs: &Given<'_>,
    capacity: i64,
) -> PyResult<Vec<Result>> {
    let settings = Settings { lens: "report".into(), ..Settings::default() };
    let fresh = settings.engine(&rig, capacity)?;
    let pairs = read_pairs(pairs)?;
    let outcomes: Vec<Outcome> = install(py, || {
        let solve = |engine: &mut Engine, pair: &Vec<_>| {
            each!(engine, held => {
                held.calibrator.reset();
                held.fuse(pair)
            })
        };
        pairs.par_iter().map_init(|| fresh.clone(), solve).collect()
    })?;
    outcomes.iter().map(|outcome| Result::of(py, outcome)).collect()
}

/// Reads pairs; an error names the pair.
pub(crate) fn read_pairs(pairs: &Given<'_>) -> PyResult<Vec<Vec<Correspondence<f32>>>> {
    let py = pairs.py();
    let named = |i: usize| move |why: PyErr| value(format!("pairs[{i}]: {}", why.value(py)));
    pairs.try_iter()?.enumerate().map(|(i, pair)| read_pair(&pair?).map_err(named(i))).collect()
}

fn read_pair(pair: &Given<'_>) -> PyResult<Vec<Correspondence<f32>>> {
    let parts: Vec<Given<'_>> = pair.extract()?;
    match &parts[..] {
        [left, right] => matches(POINTS, [left, right], None, 0.0),
        [left, right, score] => matches(POINTS, [left, right], Some(score), 0.0),
        _ => {
            Err(value(format!("(uv_left, uv_right, score) is expected, not {} parts", parts.len())))
        }
    }
}
