//! The end of a program.

use std::io;
use std::process::ExitCode;

use anyhow::{Error, Result};

/// Exit status of a program; prints its error.
pub fn exit(outcome: Result<ExitCode>) -> ExitCode {
    match outcome {
        Ok(code) => code,
        // The program that reads the output has closed it: no error.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Whether an error is due to a closed output, as with `| head`.
fn is_broken_pipe(error: &Error) -> bool {
    let kind = error.downcast_ref::<io::Error>().map(io::Error::kind);
    kind == Some(io::ErrorKind::BrokenPipe)
}
