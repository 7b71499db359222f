//! Errors of the core as exceptions of `stereo_selfcal._errors`, which has their advice.

use std::fmt::{Debug, Display};
use std::io;

use pyo3::exceptions::{PyFileNotFoundError, PyTypeError, PyValueError};
use pyo3::prelude::*;
pub(crate) use sim::run::refused::snake_case as name;
use stereo_selfcal::depth::{MotionError, RangeError};
use stereo_selfcal::geometry::{CameraError, ExtrinsicsError, RectifyError};
use stereo_selfcal::link::FrameRefusal;
use stereo_selfcal::{ApplyError, ConfigError, Rejection, RestoreError};

/// An error of the core.
pub(crate) trait CoreError: Debug + Display {
    /// Name of the exception, and stable number of the error.
    fn class_and_code(&self) -> (&'static str, u16);
}

macro_rules! core_errors {
    ($($name:ident),+) => {$(
        impl CoreError for $name {
            fn class_and_code(&self) -> (&'static str, u16) {
                (stringify!($name), self.code())
            }
        }
    )+};
}
core_errors! {
    ApplyError, CameraError, ConfigError, ExtrinsicsError, FrameRefusal, MotionError, RangeError, RectifyError,
    RestoreError
}

impl CoreError for Rejection {
    fn class_and_code(&self) -> (&'static str, u16) {
        // Numbers from 600 on belong to solved pairs.
        (if self.code() < 600 { "PairError" } else { "Refusal" }, self.code())
    }
}

/// An exception of `stereo_selfcal._errors`.
fn made(class: &str, message: &str, kind: &str, code: u16) -> PyErr {
    Python::attach(|py| {
        let class = py.import("stereo_selfcal._errors").and_then(|module| module.getattr(class));
        let made = class.and_then(|class| class.call1((message, kind, code)));
        made.map_or_else(|error| error, PyErr::from_value)
    })
}

/// The exception of two threads in one calibrator.
pub(crate) fn busy() -> PyErr {
    let text =
        "another thread is in a call of this calibrator, or was when this process was forked";
    made("BusyError", text, "Busy", 0)
}

/// The exception of an error of the core, which names its argument, if any.
pub(crate) fn raised<E: CoreError>(argument: &str) -> impl Fn(E) -> PyErr {
    move |why| {
        let separator = if argument.is_empty() { "" } else { ": " };
        let (class, code) = why.class_and_code();
        made(class, &format!("{argument}{separator}{why}"), &kind(&why), code)
    }
}

/// Name of a variant: the first word of `TooFew { usable: 3, needed: 12 }`.
fn kind(of: &impl Debug) -> String {
    let text = format!("{of:?}");
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned()
}

/// The exception of an argument with an unknown value; `known` lists the known ones.
pub(crate) fn unknown(name: &str, known: &str, given: &str) -> PyErr {
    value(format!("{name}: {known}, not {given:?}"))
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
    let is_missing = why.downcast_ref().is_some_and(is_missing);
    if is_missing { PyFileNotFoundError::new_err(text) } else { value(text) }
}
