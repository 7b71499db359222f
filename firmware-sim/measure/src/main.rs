//! `controller-cost`: what the core costs on a controller.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod compare;
mod compile;
mod duration;
mod emulate;
mod image;
mod survey;
mod table;
mod variant;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;
use host_tests::is_broken_pipe;
use host_tests::run::progress;

use table::Table;

/// Measure the core on an emulated controller: instructions and stack of every call, flash and RAM.
///
/// Builds programs for a Cortex-M4F (f32) and a Cortex-M7 (f32, f64) with .cargo/for-target, runs them
/// under QEMU, which executes one instruction each 1024 ns of its own time, and prints what they
/// count. Counts repeat exactly, and move with the compiler. The scene: 256 matches, 3 of 10 wrong,
/// 0.3 px of noise, 1920x1200 px, focal length 1400 px, the rig 5 degrees off about each axis, then
/// knocked by half a degree about each, then blinded by batches of mismatches until it is lost.
///
/// Times are estimates, not measured: 1.5 cycles an instruction at 168 MHz (Cortex-M4F), 1.0 at
/// 480 MHz (Cortex-M7), memory without wait states.
#[derive(Debug, Parser)]
#[command(
    name = "controller-cost",
    version,
    after_help = "Examples:
  cargo controller-cost                 the table
  cargo controller-cost --check         fail where a figure has moved by more than 3 %
  cargo controller-cost --update        commit to new figures
  cargo controller-cost --repeat 5      prove that the counts repeat
  cargo controller-cost --calls         every single call as well

Builds are opt-level 3 and s, fat LTO, one codegen unit, panic=abort: profiles controller and
controller-size. Needs what .ci/install-toolchain installs."
)]
struct Args {
    /// Compare with the committed table, and fail where a figure has moved by more than 3 %, up or down.
    #[arg(long, conflicts_with = "update")]
    check: bool,

    /// Write the table that --check compares with.
    #[arg(long)]
    update: bool,

    /// Run each program so many times; fail unless all print the same.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=100))]
    repeat: u16,

    /// Print the instructions of every single call before the table.
    #[arg(long)]
    calls: bool,

    /// The committed table; by default that of this package.
    #[arg(long)]
    table: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever read the output has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<()> {
    let path = args
        .table
        .clone()
        .unwrap_or_else(|| compile::root().join("firmware-sim/measure/costs.csv"));
    // Before minutes of work that could not be compared.
    let committed = args.check.then(|| Table::read(&path)).transpose()?;
    let repeat = usize::from(args.repeat);
    let bar = progress::over(survey::steps(repeat), "builds and runs");
    let mut calls = String::new();
    let measured = survey::table(repeat, &bar, |text| calls.push_str(text))?;
    bar.finish_and_clear();
    if args.calls {
        print_calls(&calls)?;
    }
    print(&measured)?;
    if args.update {
        measured.write(&path)?;
    }
    committed.map_or(Ok(()), |committed| check(&committed, &measured))
}

fn print_calls(calls: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    calls.lines().filter(|line| line.starts_with('#')).try_for_each(|line| writeln!(out, "{line}"))
}

fn print(table: &Table) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "rustc {}; ms and shares of a frame are estimates, see --help\n",
        table.compiler
    )?;
    writeln!(out, "| board | scalar | opt | what | value | unit | ms | of 20 Hz | of 60 Hz |")?;
    writeln!(out, "|---|---|---|---|--:|---|--:|--:|--:|")?;
    for row in &table.rows {
        let [board, scalar, opt, what] = row.key();
        write!(out, "| {board} | {scalar} | {opt} | {what} | {} | {} |", row.value, row.unit)?;
        match duration::estimated(row) {
            Some((ms, [at_20, at_60])) => {
                let percent = |share: f64| share * 100.0;
                let [at_20, at_60] = [percent(at_20), percent(at_60)];
                writeln!(out, " {ms:.3} | {at_20:.2} % | {at_60:.2} % |")?;
            }
            None => writeln!(out, " | | |")?,
        }
    }
    Ok(())
}

fn check(committed: &Table, measured: &Table) -> Result<()> {
    let changes = compare::changes(&committed.rows, &measured.rows);
    if changes.is_empty() {
        println!("\nall {} figures as committed", measured.rows.len());
        return Ok(());
    }
    println!();
    for change in &changes {
        println!("{change}");
    }
    let advice = if committed.compiler == measured.compiler {
        "commit to them with --update if they are meant".to_owned()
    } else {
        format!(
            "the committed ones are of rustc {}, these of {}",
            committed.compiler, measured.compiler
        )
    };
    bail!("{} figures have changed: {advice}", changes.len())
}
