//! Runs a controller image in QEMU.

#[cfg_attr(not(feature = "logs"), path = "no_log.rs")]
mod log;
mod machine;

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use thiserror::Error;

use log::Log;
pub use machine::Machine;

const QEMU: &str = "qemu-system-arm";

/// Interval of polls for the end of the process.
const POLL: Duration = Duration::from_millis(10);

/// Why the emulated controller does not run.
#[derive(Debug, Error)]
pub enum EmulatorError {
    /// QEMU is not installed.
    #[error("{QEMU} is not installed: on Debian, as root, `apt-get install {QEMU}`")]
    NoQemu,
    /// The image does not exist.
    #[error("there is no image {}", .0.display())]
    NoImage(PathBuf),
    /// QEMU could not be started or polled.
    #[error("{QEMU}: {0}")]
    Process(#[source] io::Error),
    /// The firmware did not end in time.
    #[error("the firmware has not ended after {} s", .0.as_secs())]
    TimedOut(Duration),
    /// The log cannot be decoded.
    #[cfg(feature = "logs")]
    #[error("the log of {}: {why}", .image.display())]
    Log {
        /// The image.
        image: PathBuf,
        /// The error of the decoder.
        why: String,
    },
}

/// A QEMU process with an image. Dropping the value ends it.
pub struct Emulator {
    qemu: Child,
    log: Option<Log>,
}

impl Emulator {
    /// Starts an image.
    ///
    /// * `serial`: connection of UART 0, as QEMU's option `-serial` takes it.
    ///
    /// # Errors
    /// [`EmulatorError`] if the image, its log or QEMU is missing.
    pub fn start(machine: Machine, image: &Path, serial: &str) -> Result<Self, EmulatorError> {
        if !image.is_file() {
            return Err(EmulatorError::NoImage(image.to_owned()));
        }
        let mut command = Command::new(QEMU);
        command
            .args(["-machine", machine.name(), "-cpu", machine.cpu()])
            .args(["-display", "none", "-monitor", "none", "-serial", serial])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(image)
            .stdin(Stdio::null())
            .stdout(log::output());
        let qemu = command.spawn().map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => EmulatorError::NoQemu,
            _ => EmulatorError::Process(error),
        })?;
        let mut emulator = Self { qemu, log: None };
        emulator.log = log::follow(&mut emulator.qemu, image)?;
        Ok(emulator)
    }

    /// The firmware's status, if it has ended.
    ///
    /// # Errors
    /// [`EmulatorError::Process`].
    pub fn status(&mut self) -> Result<Option<ExitStatus>, EmulatorError> {
        self.qemu.try_wait().map_err(EmulatorError::Process)
    }

    /// Waits for the end of the firmware and of its log. Returns the firmware's status.
    ///
    /// # Errors
    /// [`EmulatorError::TimedOut`] after `limit`, [`EmulatorError::Process`].
    pub fn wait(&mut self, limit: Duration) -> Result<ExitStatus, EmulatorError> {
        let end = Instant::now() + limit;
        let status = loop {
            match self.status()? {
                Some(status) => break status,
                None if Instant::now() >= end => return Err(EmulatorError::TimedOut(limit)),
                None => thread::sleep(POLL),
            }
        };
        if let Some(log) = self.log.take() {
            log.finish();
        }
        Ok(status)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // Both calls fail only if the process has already ended.
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

/// Parses a timeout of a command line: whole seconds, up to a day.
///
/// # Errors
/// The message for the user.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|s| (1..=86_400).contains(s));
    seconds.map(Duration::from_secs).ok_or_else(|| "1 to 86400 whole seconds are needed".into())
}
