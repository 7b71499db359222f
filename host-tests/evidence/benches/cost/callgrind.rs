//! Instructions, counted by valgrind's callgrind. It runs this program again for one row of the table, and counts only
//! inside [`run_counted`].

use std::fs;
use std::hint::black_box;
use std::process::{Command, Stdio};
use std::thread;

use anyhow::{Context, Result, anyhow, ensure};

/// Result of a run under callgrind.
#[derive(Debug)]
pub(crate) struct Count {
    /// Instructions inside [`run_counted`], all jobs of the row together.
    pub(crate) instructions: f64,
    /// Output of the counted run.
    pub(crate) said: String,
}

/// Whether valgrind is installed.
pub(crate) fn is_present() -> bool {
    let version = Command::new("valgrind").arg("--version").stdout(Stdio::null()).status();
    version.is_ok_and(|status| status.success())
}

/// Runs each job once, to be counted.
///
/// On a separate stack: the main thread's stack begins below the environment, whose size would change the counts by a
/// few instructions.
pub(crate) fn run_once<J: Send + 'static, A: Send + 'static>(
    jobs: Vec<J>,
    run: fn(J) -> A,
) -> Result<Vec<A>> {
    let run = move || jobs.into_iter().map(|job| run_counted(job, run)).collect();
    thread::spawn(run).join().map_err(|_| anyhow!("a job panicked"))
}

/// Callgrind counts from entry to return, so this must stay a symbol.
#[inline(never)]
fn run_counted<J, A>(job: J, run: fn(J) -> A) -> A {
    black_box(run(job))
}

/// Runs one row of the table under callgrind.
pub(crate) fn count(row: usize) -> Result<Count> {
    let folder = tempfile::tempdir()?;
    let profile = folder.path().join("callgrind.out");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--toggle-collect=*run_counted*"])
        .arg(format!("--callgrind-out-file={}", profile.display()))
        .arg(std::env::current_exe()?)
        .args(["--row", &row.to_string()])
        .output()?;
    let errors = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "valgrind failed:\n{errors}");
    let said = String::from_utf8(output.stdout)?.trim().to_owned();
    let profile = fs::read_to_string(profile)?;
    let total = profile.lines().find_map(|line| line.strip_prefix("totals: "));
    let instructions: f64 = total.context("callgrind gave no total")?.trim().parse()?;
    ensure!(instructions > 0.0, "callgrind counted nothing");
    Ok(Count { instructions, said })
}
