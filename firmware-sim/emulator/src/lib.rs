//! The boards that QEMU emulates: builds programs for them, and runs them.

mod board;
mod programs;

use std::io::Read;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, ensure};

pub use board::{BOARDS, Board};
pub use programs::{build, cycle_counter, root};

/// Interval of polls for the end of the process.
const POLL: Duration = Duration::from_millis(10);

/// A QEMU process with a program. Dropping the value ends it.
pub struct Emulator(Child);

impl Emulator {
    /// Starts a program.
    ///
    /// * `options`: further options of QEMU.
    ///
    /// # Errors
    /// If the program or QEMU is missing.
    pub fn start(board: &Board, program: &Path, options: &[&str]) -> Result<Self> {
        ensure!(program.is_file(), "there is no image {}", program.display());
        let qemu = Command::new("qemu-system-arm")
            .args(["-machine", board.machine, "-cpu", board.cpu])
            .args(["-display", "none", "-monitor", "none", "-serial", "none"])
            .args(options)
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(program)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn();
        Ok(Self(qemu.context("cannot start qemu-system-arm; .ci/install-toolchain installs it")?))
    }

    /// The program's output. Read it in a thread: a full pipe stops the emulator.
    ///
    /// # Errors
    /// After the first call.
    pub fn stdout(&mut self) -> Result<ChildStdout> {
        self.0.stdout.take().context("the output is taken")
    }

    /// Waits for the end of the program.
    ///
    /// # Errors
    /// If it has not ended after `limit`.
    pub fn wait(&mut self, limit: Duration) -> Result<ExitStatus> {
        let end = Instant::now() + limit;
        loop {
            match self.0.try_wait()? {
                Some(status) => return Ok(status),
                None if Instant::now() < end => thread::sleep(POLL),
                None => return Err(anyhow!("the program has not ended after {limit:?}")),
            }
        }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // Both calls fail only if the process has already ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs a program to its end. Returns its output.
///
/// # Errors
/// As [`Emulator::start`] and [`Emulator::wait`]; with the output if the program fails.
pub fn output(board: &Board, program: &Path, options: &[&str], limit: Duration) -> Result<String> {
    let mut emulator = Emulator::start(board, program, options)?;
    let mut stdout = emulator.stdout()?;
    let reader = thread::spawn(move || {
        let mut bytes = Vec::new();
        stdout.read_to_end(&mut bytes).map(|_| bytes)
    });
    let status = emulator.wait(limit).with_context(|| program.display().to_string())?;
    let bytes = reader.join().map_err(|_| anyhow!("reading the output failed"))??;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let name = program.display();
    ensure!(status.success(), "{name} ended with {status} on {}:\n{text}", board.name);
    Ok(text)
}

/// Parses a timeout of a command line: whole seconds, up to a day.
///
/// # Errors
/// The message for the user.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|s| (1..=86_400).contains(s));
    seconds.map(Duration::from_secs).ok_or_else(|| "1 to 86400 whole seconds are needed".into())
}
