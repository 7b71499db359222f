//! A controller image in QEMU: started, waited for, and ended in any case.

#[cfg_attr(not(feature = "logs"), path = "silence.rs")]
mod log;
mod machine;

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use thiserror::Error;

use log::Log;
#[cfg(feature = "logs")]
pub(super) use log::run;
pub(super) use machine::Machine;

const QEMU: &str = "qemu-system-arm";

/// How often a process is asked whether it has ended.
const POLL: Duration = Duration::from_millis(10);

/// Why there is no emulated controller, or none any more.
#[derive(Debug, Error)]
pub(super) enum EmulatorError {
    /// QEMU is not installed.
    #[error("{QEMU} is not installed: on Debian, as root, `apt-get install {QEMU}`")]
    NoQemu,
    /// There is no such file.
    #[error("there is no image {}", .0.display())]
    NoImage(PathBuf),
    /// It could not be started, or not be waited for.
    #[error("{QEMU}: {0}")]
    Process(#[source] io::Error),
    /// It did not end in time.
    #[error("the firmware has not ended after {} s", .0.as_secs())]
    TimedOut(Duration),
    /// What it was to log could not be decoded.
    #[cfg(feature = "logs")]
    #[error("the log of {}: {why}", .image.display())]
    Log {
        /// The image.
        image: PathBuf,
        /// What the decoder says.
        why: String,
    },
}

/// QEMU with an image. Ends with this value.
pub(super) struct Emulator {
    qemu: Child,
    log: Option<Log>,
}

impl Emulator {
    /// Starts an image.
    ///
    /// * `serial`: where UART 0 goes, in QEMU's words.
    pub(super) fn start(
        machine: Machine,
        image: &Path,
        serial: &str,
    ) -> Result<Self, EmulatorError> {
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
    pub(super) fn status(&mut self) -> Result<Option<ExitStatus>, EmulatorError> {
        self.qemu.try_wait().map_err(EmulatorError::Process)
    }

    /// The firmware's status, once it has ended and all of its log is out.
    pub(super) fn wait(&mut self, limit: Duration) -> Result<ExitStatus, EmulatorError> {
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
        // Both fail only where it has already ended.
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}
