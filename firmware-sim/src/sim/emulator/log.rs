//! The firmware's defmt log, decoded with the strings in its image.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, ExitCode, Stdio};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::Result;
use defmt_decoder::{DecodeError, Table};

use super::{Emulator, EmulatorError, Machine};

/// Runs an image to its end, its log on standard error, and returns its status.
///
/// # Errors
/// If QEMU or the image is not there, or the firmware does not end in time.
pub(crate) fn run(image: &Path, machine: Machine, limit: Duration) -> Result<ExitCode> {
    let status = Emulator::start(machine, image, "null")?.wait(limit)?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}

/// The log on its way to standard error.
pub(super) struct Log(JoinHandle<()>);

impl Log {
    /// Waits until all of it is out.
    pub(super) fn finish(self) {
        // A thread that panicked has said so itself.
        let _ = self.0.join();
    }
}

/// Where the log goes.
pub(super) fn output() -> Stdio {
    Stdio::piped()
}

/// Prints the log as it comes, up to its end.
pub(super) fn follow(qemu: &mut Child, image: &Path) -> Result<Option<Log>, EmulatorError> {
    let failed = |why: String| EmulatorError::Log { image: image.to_owned(), why };
    let elf = fs::read(image).map_err(|error| failed(error.to_string()))?;
    let table = Table::parse(&elf)
        .map_err(|error| failed(format!("{error:#}")))?
        .ok_or_else(|| failed("the image has no strings of one".into()))?;
    let bytes = qemu.stdout.take();
    Ok(bytes.map(|bytes| Log(thread::spawn(move || print(&table, bytes)))))
}

fn print(table: &Table, mut bytes: impl Read) {
    let mut decoder = table.new_stream_decoder();
    let mut buffer = [0; 1024];
    while let Ok(count @ 1..) = bytes.read(&mut buffer) {
        decoder.received(&buffer[..count]);
        loop {
            let line = match decoder.decode() {
                Ok(frame) => {
                    let level = frame.level().map_or("print", |level| level.as_str());
                    format!("{:<5} {}", level.to_uppercase(), frame.display_message())
                }
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => "(part of the log is damaged)".into(),
            };
            if writeln!(std::io::stderr(), "{line}").is_err() {
                return;
            }
        }
    }
}
