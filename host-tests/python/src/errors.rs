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

/// An exception of `stereo_selfcal._errors`.
fn made(class: &str, message: &str, kind: &str, number: u16) -> PyErr {
    Python::attach(|py| {
        let class = py.import("stereo_selfcal._errors").and_then(|module| module.getattr(class));
        let made = class.and_then(|class| class.call1((message, kind, number)));
        made.map_or_else(|error| error, PyErr::from_value)
    })
}

/// Raises the exception of two threads in one calibrator.
pub(crate) fn busy() -> PyErr {
    let text =
        "another thread is in a call of this calibrator, or was when this process was forked";
    made("BusyError", text, "Busy", 0)
}

/// Raises an error of the core; names its argument, if any.
pub(crate) fn raised<E: CoreError>(argument: &str) -> impl Fn(E) -> PyErr {
    move |why| {
        let separator = if argument.is_empty() { "" } else { ": " };
        // `TooFew { usable: 3, needed: 12 }`: the name is the first word.
        let variant = format!("{why:?}");
        let kind = variant.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
        made(why.class(), &format!("{argument}{separator}{why}"), kind, why.number())
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
