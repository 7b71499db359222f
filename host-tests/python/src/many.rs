//! `solve_pairs`: pairs that are solved alone, on all processors.

use numpy::PyArray1;
use numpy::PyArrayMethods;
use pyo3::prelude::*;
use rayon::prelude::*;
use stereo_selfcal::Correspondence;

use crate::arguments::matches;
use crate::engine::{Outcome, Settings};
use crate::errors::{rejection, value};
use crate::pool::install;
use crate::rig::Rig;
use host_tests::data::{in_f64, rows};

/// Solves each pair from the factory extrinsics, as the only one.
#[pyfunction]
#[pyo3(signature = (rig, pairs, capacity=256, preset="robust"))]
pub(crate) fn solve_pairs<'py>(
    py: Python<'py>,
    rig: Rig,
    pairs: &Bound<'py, PyAny>,
    capacity: usize,
    preset: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (preset, lens) = (preset.to_owned(), "report".to_owned());
    let settings = Settings {
        rig,
        capacity,
        preset,
        lens,
        max_correction_rad: None,
        memory_pairs: None,
        max_angular_rate: None,
        automatic_apply: false,
    };
    let plan = settings.plan()?;
    let read = pairs.try_iter()?.enumerate().map(|(i, pair)| {
        read_pair(&pair?).map_err(|why| value(format!("pairs[{i}]: {}", why.value(py))))
    });
    let pairs: Vec<Vec<Correspondence<f32>>> = read.collect::<PyResult<_>>()?;
    let outcomes: Vec<Outcome> = install(py, || {
        pairs.par_iter().map_init(|| plan.engine(), |engine, pair| engine.alone(pair)).collect()
    })?;
    solutions(py, &outcomes)
}

fn read_pair(pair: &Bound<'_, PyAny>) -> PyResult<Vec<Correspondence<f32>>> {
    let tuple: Vec<Bound<'_, PyAny>> = pair.extract()?;
    match &tuple[..] {
        [left, right] => matches(left, right, None, 0.0),
        [left, right, score] => {
            matches(left, right, Some(score).filter(|score| !score.is_none()), 0.0)
        }
        _ => Err(value(format!(
            "(uv_left, uv_right[, score]) is expected, not {} items",
            tuple.len()
        ))),
    }
}

fn solutions<'py>(py: Python<'py>, outcomes: &[Outcome]) -> PyResult<Bound<'py, PyAny>> {
    let count = outcomes.len();
    let (mut r, mut t) = (Vec::with_capacity(9 * count), Vec::with_capacity(3 * count));
    let (mut sd, mut px) = (Vec::with_capacity(2 * count), Vec::with_capacity(2 * count));
    let mut errors = Vec::with_capacity(count);
    for outcome in outcomes {
        let proposal = outcome.proposal.as_ref().filter(|_| outcome.fused.is_ok());
        let of_proposal = proposal.map(|proposal| {
            let extrinsics = in_f64(&proposal.extrinsics);
            let sd = [proposal.sd.rotation, proposal.sd.translation].map(f64::from);
            (rows(extrinsics.rotation().matrix()), extrinsics.translation().into_inner().into(), sd)
        });
        let of_pair = |report: &stereo_selfcal::PairReport<f32>| {
            [report.rms_px_before, report.rms_px_after].map(f64::from)
        };
        let (r_i, t_i, sd_i) =
            of_proposal.unwrap_or(([[f64::NAN; 3]; 3], [f64::NAN; 3], [f64::NAN; 2]));
        r.extend_from_slice(r_i.as_flattened());
        t.extend_from_slice(&t_i);
        sd.extend_from_slice(&sd_i);
        px.extend_from_slice(&outcome.report.as_ref().map_or([f64::NAN; 2], of_pair));
        errors.push(outcome.fused.err().map(|why| rejection(py, why)).transpose()?);
    }
    let array = |numbers: Vec<f64>| PyArray1::from_vec(py, numbers);
    let class = py.import("stereo_selfcal._results")?.getattr("Solutions")?;
    let arguments = (
        array(r).reshape([count, 3, 3])?,
        array(t).reshape([count, 3])?,
        array(sd).reshape([count, 2])?,
        array(px).reshape([count, 2])?,
        errors,
    );
    class.call1(arguments)
}
