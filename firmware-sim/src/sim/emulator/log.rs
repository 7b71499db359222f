//! Decodes the firmware's defmt log with the strings in its image.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, ExitCode, Stdio};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::Result;
use defmt_decoder::{DecodeError, Table};

use super::{Emulator, EmulatorError, Machine};

/// Runs an image to its end and prints its log to standard error. Returns the firmware's status.
///
/// # Errors
/// If QEMU or the image is missing, or the firmware does not end in time.
pub(crate) fn run(image: &Path, machine: Machine, limit: Duration) -> Result<ExitCode> {
    let status = Emulator::start(machine, image, "null")?.wait(limit)?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}

/// A thread that prints the log to standard error.
pub(super) struct Log(JoinHandle<()>);

impl Log {
    /// Waits until the whole log is printed.
    pub(super) fn finish(self) {
        // A panic of the thread is already printed.
        let _ = self.0.join();
    }
}

/// Standard output of QEMU, which has the log.
pub(super) fn output() -> Stdio {
    Stdio::piped()
}

/// Prints the log until its end.
pub(super) fn follow(qemu: &mut Child, image: &Path) -> Result<Option<Log>, EmulatorError> {
    let failed = |why: String| EmulatorError::Log { image: image.to_owned(), why };
    let elf = fs::read(image).map_err(|error| failed(error.to_string()))?;
    let table = Table::parse(&elf)
        .map_err(|error| failed(format!("{error:#}")))?
        .ok_or_else(|| failed("the image has no defmt strings".into()))?;
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
