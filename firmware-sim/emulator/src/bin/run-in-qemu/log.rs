//! Decodes the firmware's defmt log with the strings in its image.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;

use anyhow::{Context, Result};
use defmt_decoder::{DecodeError, Table};

/// Reads the strings of an image.
pub(crate) fn table(image: &Path) -> Result<Table> {
    let table = Table::parse(&fs::read(image)?).map_err(|error| error.context("its defmt strings"));
    table.and_then(|table| table.context("it has no defmt strings"))
}

/// Prints a log to standard error until its end.
pub(crate) fn print(table: &Table, mut bytes: impl Read) {
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
