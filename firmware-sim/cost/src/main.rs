//! `controller-cost`: instructions, stack, flash and RAM of the core on a controller.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod compare;
mod documents;
mod flash;
mod measurement;
mod table;

use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, ensure};
use clap::Parser;
use emulator::{BOARDS, Board};

use measurement::Measured;
use table::{Row, Table};

/// Measure the core on an emulated controller: instructions and stack of every call, flash and RAM, the largest functions.
///
/// Builds programs for a Cortex-M4F (f32) and a Cortex-M7 (f32, f64) with .cargo/for-target, runs them
/// in QEMU and prints their counts. QEMU executes one instruction per 1024 ns of its virtual time. The
/// scene: 256 matches, 30 % of them outliers, 0.3 px of noise, 1920x1200 px, focal length 1400 px. The
/// rig starts 5 degrees off about each axis, is knocked by half a degree about each, and then gets
/// batches of outliers until the state is lost.
///
/// Times are estimates. Cortex-M4F at 168 MHz: a plugin of QEMU adds the cycles of each instruction by the table of the
/// processor's manual, with the longest refill of the pipeline and the longest division. Cortex-M7 at 480 MHz: one cycle
/// an instruction, because its manual has no such table. Flash has no wait states, as behind a cache that always hits.
///
/// Counts repeat exactly, but differ between compiler versions. firmware-sim/cost/costs.csv is the
/// committed table; its first line names the compiler that built the programs.
#[derive(Debug, Parser)]
#[command(
    name = "controller-cost",
    version,
    after_help = "Examples:
  cargo controller-cost                 the table
  cargo controller-cost --check         fail where a figure has moved
  cargo controller-cost --check --board m4f --opt 3    the same for one build, in a quarter of the time
  cargo controller-cost --update        write the table and the documents
  cargo controller-cost --repeat 5      prove that the counts repeat

Builds: opt-level 3 and s, fat LTO, one codegen unit, panic=abort (profiles controller and
controller-size). .ci/install-toolchain installs the compiler and QEMU."
)]
struct Args {
    /// Compare with the committed table. Fail if a figure has moved by more than 3 %, up or down, or if another compiler
    /// wrote the table.
    #[arg(long, conflicts_with = "update")]
    check: bool,

    /// Check against the table of another compiler, and allow 40 %.
    #[arg(long, requires = "check")]
    other_compiler: bool,

    /// Measure only this board [default: all].
    #[arg(long, value_parser = Board::parser(), conflicts_with = "update")]
    board: Option<&'static Board>,

    /// Measure only this opt-level [default: all].
    #[arg(long, value_parser = measurement::opts(), conflicts_with = "update")]
    opt: Option<String>,

    /// Wait states of the flash in the cycles of the Cortex-M4F, without cache and prefetch: each run of instructions
    /// waits for each 16 bytes.
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with_all = ["check", "update"])]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=15))]
    wait_states: u32,

    /// Write the committed table, and its figures into the documents.
    #[arg(long)]
    update: bool,

    /// Number of runs of each program; fail unless all print the same.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=100))]
    repeat: u16,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The committed table.
fn table_file() -> PathBuf {
    emulator::root().join("firmware-sim/cost/costs.csv")
}

fn run(args: &Args) -> Result<()> {
    // Read first, so that a damaged table is an error before minutes of builds.
    let committed = args.check.then(|| Table::read(&table_file())).transpose()?;
    let boards = args.board.map_or_else(|| BOARDS.iter().collect(), |board| vec![board]);
    let measured =
        measurement::measure(&boards, args.opt.as_deref(), args.wait_states, args.repeat)?;
    let Measured { table, functions } = &measured;
    print(table);
    println!("\n{}", flash::largest(functions));
    if args.update {
        fs::write(table_file(), table.text())?;
        documents::write(&emulator::root(), table)?;
    }
    committed.map_or(Ok(()), |committed| check(&committed, table, args))
}

fn print(table: &Table) {
    println!("rustc {}; ms are estimates, see --help\n", table.compiler);
    println!("| board | scalar | opt | what | value | unit | ms |\n|---|---|---|---|--:|---|--:|");
    for row in &table.rows {
        let ms = row.ms().map(|ms| format!("{ms:.3}")).unwrap_or_default();
        println!("| {} | {} | {} | {ms} |", row.key.join(" | "), row.value, row.unit);
    }
}

fn check(committed: &Table, measured: &Table, args: &Args) -> Result<()> {
    let percent = compare::bound(committed, measured, args.other_compiler)?;
    println!("\nchecked against the table of rustc {}, bound {percent} %", committed.compiler);
    let is_measured = |row: &&Row| {
        let [board, _, opt, _] = &row.key;
        args.board.is_none_or(|only| only.name == board)
            && args.opt.as_ref().is_none_or(|only| only == opt)
    };
    let rows: Vec<_> = committed.rows.iter().filter(is_measured).cloned().collect();
    let changes = compare::changes(&rows, &measured.rows, percent);
    for change in &changes {
        println!("{change}");
    }
    ensure!(changes.is_empty(), "{} figures have changed; --update writes them", changes.len());
    println!("all {} figures are within the bound", measured.rows.len());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_states_both_bounds() {
        use clap::CommandFactory;
        let help = Args::command().render_long_help().to_string();
        for bound in [compare::SAME_COMPILER, compare::OTHER_COMPILER] {
            assert!(help.contains(&format!("{bound} %")), "{help}");
        }
    }
}
