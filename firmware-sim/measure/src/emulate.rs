//! Runs a program on an emulated board, at 1024 ns of virtual time per instruction.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail};
use wait_timeout::ChildExt;

use crate::variant::Board;

/// Longest run. A program that faults loops forever.
const TIMEOUT: Duration = Duration::from_secs(600);

/// The program's output over semihosting.
pub(crate) fn output(board: Board, program: &Path) -> Result<String> {
    let [machine, cpu] = board.emulated();
    let mut child = Command::new("qemu-system-arm")
        .args(["-machine", machine, "-cpu", cpu, "-icount", "shift=10", "-nographic"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(program)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start qemu-system-arm; .ci/install-toolchain installs it")?;
    let mut stdout = child.stdout.take().context("the emulator has no output")?;
    // In a thread: a full pipe would stop the emulator.
    let reader = thread::spawn(move || {
        let mut text = String::new();
        stdout.read_to_string(&mut text).map(|_| text)
    });
    let Some(status) = child.wait_timeout(TIMEOUT)? else {
        child.kill()?;
        child.wait()?;
        bail!("{} did not end within {TIMEOUT:?}; it may have faulted", program.display());
    };
    let text = reader.join().map_err(|_| anyhow!("reading the emulator's output failed"))??;
    if !status.success() {
        bail!("{} failed on {}:\n{text}", program.display(), board.name());
    }
    Ok(text)
}
