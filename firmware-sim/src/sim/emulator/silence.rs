//! Without the decoder: the log is dropped.

use std::convert::Infallible;
use std::path::Path;
use std::process::{Child, Stdio};

use super::EmulatorError;

/// There is none.
pub(super) struct Log(Infallible);

impl Log {
    pub(super) fn finish(self) {
        match self.0 {}
    }
}

/// Where the log goes.
pub(super) fn output() -> Stdio {
    Stdio::null()
}

/// There is nothing to follow.
#[expect(clippy::unnecessary_wraps, reason = "the decoder's signature")]
pub(super) fn follow(_: &mut Child, _: &Path) -> Result<Option<Log>, EmulatorError> {
    Ok(None)
}
