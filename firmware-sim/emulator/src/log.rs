//! Decodes the firmware's defmt log with the strings in its image.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Stdio};
use std::thread::{self, JoinHandle};

use defmt_decoder::{DecodeError, Table};

use super::EmulatorError;

/// A thread that prints the log to standard error.
pub(crate) struct Log(JoinHandle<()>);

impl Log {
    /// Waits until the whole log is printed.
    pub(crate) fn finish(self) {
        // A panic of the thread is already printed.
        let _ = self.0.join();
    }
}

/// Standard output of QEMU, which has the log.
pub(crate) fn output() -> Stdio {
    Stdio::piped()
}

/// Prints the log until its end.
pub(crate) fn follow(qemu: &mut Child, image: &Path) -> Result<Option<Log>, EmulatorError> {
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
