//! Errors of the core as exceptions of `stereo_selfcal._errors`, which has their advice.

use std::fmt::{Debug, Display};
use std::io;

use pyo3::exceptions::{PyFileNotFoundError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use stereo_selfcal::depth::{MotionError, RangeError};
use stereo_selfcal::geometry::{CameraError, ExtrinsicsError, RectifyError};
use stereo_selfcal::link::FrameRefusal;
use stereo_selfcal::{ApplyError, ConfigError, Rejection, RestoreError};

/// An error of the core with its class and number.
pub(crate) trait CoreError: Debug + Display {
    /// Name of the exception.
    fn class(&self) -> &'static str;
    /// Stable number.
    fn number(&self) -> u16;
}

macro_rules! core_errors {
    ($($name:ident),+) => {$(
        impl CoreError for $name {
            fn class(&self) -> &'static str {
                stringify!($name)
            }

            fn number(&self) -> u16 {
                self.code()
            }
        }
    )+};
}
core_errors!(
    ApplyError,
    CameraError,
    ConfigError,
    ExtrinsicsError,
    FrameRefusal,
    MotionError,
    RangeError,
    RectifyError,
    RestoreError
);

impl CoreError for Rejection {
    fn class(&self) -> &'static str {
        // Numbers from 600 on belong to solved pairs.
        if self.code() < 600 { "PairError" } else { "Refusal" }
    }

    fn number(&self) -> u16 {
        self.code()
    }
}

/// The exception of an error.
pub(crate) fn exception<'py>(
    py: Python<'py>,
    why: &dyn CoreError,
    message: &str,
) -> PyResult<Bound<'py, PyAny>> {
    // `TooFew { usable: 3, needed: 12 }`: the name is the first word.
    let variant = format!("{why:?}");
    let kind = variant.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    made(py, why.class(), message, kind, why.number())
}

fn made<'py>(
    py: Python<'py>,
    class: &str,
    message: &str,
    kind: &str,
    number: u16,
) -> PyResult<Bound<'py, PyAny>> {
    py.import("stereo_selfcal._errors")?.getattr(class)?.call1((message, kind, number))
}

/// Raises the exception of two threads in one calibrator.
pub(crate) fn busy() -> PyErr {
    let text =
        "another thread is in a call of this calibrator, or was when this process was forked";
    Python::attach(|py| {
        made(py, "BusyError", text, "Busy", 0).map_or_else(|error| error, PyErr::from_value)
    })
}

/// The exception of a rejection, not raised.
pub(crate) fn rejection(py: Python<'_>, why: Rejection) -> PyResult<Bound<'_, PyAny>> {
    exception(py, &why, &why.to_string())
}

/// Raises an error of the core; names its argument, if any.
pub(crate) fn raised<E: CoreError>(argument: &str) -> impl Fn(E) -> PyErr {
    move |why| {
        let separator = if argument.is_empty() { "" } else { ": " };
        let message = format!("{argument}{separator}{why}");
        Python::attach(|py| {
            exception(py, &why, &message).map_or_else(|error| error, PyErr::from_value)
        })
    }
}

/// `ValueError` of a text.
pub(crate) fn value(text: impl Display) -> PyErr {
    PyValueError::new_err(text.to_string())
}

/// `TypeError` of a text.
pub(crate) fn wrong_type(text: impl Display) -> PyErr {
    PyTypeError::new_err(text.to_string())
}

/// Errors of files: `FileNotFoundError` or `ValueError`, with file and key in the text.
pub(crate) fn of_file(why: anyhow::Error) -> PyErr {
    let text = format!("{why:#}");
    let is_missing = |io: &io::Error| io.kind() == io::ErrorKind::NotFound;
    if why.downcast_ref::<io::Error>().is_some_and(is_missing) {
        PyFileNotFoundError::new_err(text)
    } else {
        value(text)
    }
}
