//! `solve_pairs`: solves pairs alone, on all processors.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use stereo_selfcal::Correspondence;

use crate::arguments::{POINTS, matches};
use crate::engine::{Engine, Outcome, Settings, each};
use crate::errors::value;
use crate::outcome::Result;
use crate::pool::install;
use crate::rig::Rig;

/// Solves each pair alone, from the factory extrinsics.
#[pyfunction]
#[pyo3(signature = (rig, pairs, capacity=256, preset="robust"))]
pub(crate) fn solve_pairs(
    py: Python<'_>,
    rig: Rig,
    pairs: &Bound<'_, PyAny>,
    capacity: usize,
    preset: &str,
) -> PyResult<Vec<Result>> {
    let (preset, options) = (preset.to_owned(), PyDict::new(py).unbind());
    let fresh = Settings { rig, capacity, preset, options }.engine(py)?;
    let named = |i: usize| move |why: PyErr| value(format!("pairs[{i}]: {}", why.value(py)));
    let read = pairs.try_iter()?.enumerate().map(|(i, pair)| read_pair(&pair?).map_err(named(i)));
    let pairs: Vec<Vec<Correspondence<f32>>> = read.collect::<PyResult<_>>()?;
    let outcomes: Vec<Outcome> = install(py, || {
        let solve = |engine: &mut Engine, pair: &Vec<_>| each!(engine, held => held.alone(pair));
        pairs.par_iter().map_init(|| fresh.clone(), solve).collect()
    })?;
    outcomes.iter().map(|outcome| Result::new(py, outcome)).collect()
}

fn read_pair(pair: &Bound<'_, PyAny>) -> PyResult<Vec<Correspondence<f32>>> {
    let parts: Vec<Bound<'_, PyAny>> = pair.extract()?;
    match &parts[..] {
        [left, right] => matches(POINTS, left, right, None, 0.0),
        [left, right, score] => matches(POINTS, left, right, Some(score), 0.0),
        _ => {
            Err(value(format!("(uv_left, uv_right, score) is expected, not {} parts", parts.len())))
        }
    }
}
