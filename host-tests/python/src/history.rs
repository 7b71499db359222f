//! `History`: the changes of a calibrator, in the hands of its user.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use sim::run::EventLine;
use stereo_selfcal::outcome;

use crate::calibrator::Calibrator;
use crate::errors::{name, value};
use crate::outcome::{Verdict, data};

data! {
    /// A change of a calibrator.
    #[pyclass(frozen, get_all, module = "stereo_selfcal")]
    Event(py: Python<'_>, of: &outcome::Event<f32>) {
        time: u64 = of.time,
        pair: u32 = of.pair,
        changes: Py<PyTuple> = {
            let changes = of.changes.iter().map(|change| change.to_string());
            PyTuple::new(py, changes.collect::<Vec<_>>())?.unbind()
        },
        generation: u32 = of.generation,
        state: String = name(&of.verdict.state),
        verdict: Py<Verdict> = Py::new(py, Verdict::new(py, &of.verdict)?)?,
        json: String = serde_json::to_string(&EventLine::of(of, Some(of.time))).map_err(value)?,
        text: String = of.to_string(),
    } {
        fn __repr__(&self) -> String {
            format!("<Event {}>", self.text)
        }
    }
}

/// The last events of a calibrator.
#[pyclass(frozen, module = "stereo_selfcal")]
pub(crate) struct History {
    #[pyo3(get)]
    capacity: usize,
    held: Mutex<Held>,
}

struct Held {
    events: VecDeque<outcome::Event<f32>>,
    last: outcome::Event<f32>,
    /// Number of the next pair.
    pair: u32,
}

#[pymethods]
impl History {
    #[new]
    #[pyo3(signature = (capacity=256))]
    fn new(capacity: usize) -> Self {
        let held = Held { events: VecDeque::new(), last: outcome::Event::START, pair: 0 };
        Self { capacity, held: Mutex::new(held) }
    }

    #[pyo3(signature = (calibrator, time=0, pair=None))]
    fn note(
        &self,
        py: Python<'_>,
        calibrator: &Bound<'_, Calibrator>,
        time: u64,
        pair: Option<u32>,
    ) -> PyResult<Option<Event>> {
        let (verdict, generation) = calibrator.get().now(py)?;
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        let pair = pair.unwrap_or(held.pair);
        held.pair = pair.saturating_add(1);
        let Some(event) = held.last.next(time, pair, &verdict, generation) else { return Ok(None) };
        held.last = event;
        held.events.push_back(event);
        if held.events.len() > self.capacity {
            held.events.pop_front();
        }
        Event::new(py, &event).map(Some)
    }

    #[getter]
    fn events(&self, py: Python<'_>) -> PyResult<Vec<Event>> {
        let held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        held.events.iter().map(|event| Event::new(py, event)).collect()
    }
}
