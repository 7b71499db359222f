//! Replaces `log` without the feature `logs`: discards the log.

use std::convert::Infallible;
use std::path::Path;
use std::process::{Child, Stdio};

use super::EmulatorError;

/// A type without a value.
pub(crate) struct Log(Infallible);

impl Log {
    pub(crate) fn finish(self) {
        match self.0 {}
    }
}

/// Standard output of QEMU.
pub(crate) fn output() -> Stdio {
    Stdio::null()
}

/// Starts no thread.
#[expect(clippy::unnecessary_wraps, reason = "the decoder's signature")]
pub(crate) fn follow(_: &mut Child, _: &Path) -> Result<Option<Log>, EmulatorError> {
    Ok(None)
}
