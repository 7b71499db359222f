//! `controller-cost`: instructions, stack, flash and RAM of the core on a controller.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod compare;
mod compile;
mod documents;
mod duration;
mod emulate;
mod image;
mod measurement;
mod table;
mod variant;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use sim::is_broken_pipe;
use sim::run::progress;

use compare::Bound;
use table::{Row, Table};
use variant::Board;

/// Measure the core on an emulated controller: instructions and stack of every call, flash and RAM.
///
/// Builds programs for a Cortex-M4F (f32) and a Cortex-M7 (f32, f64) with .cargo/for-target, runs them
/// in QEMU and prints their counts. QEMU executes one instruction per 1024 ns of its virtual time. The
/// scene: 256 matches, 30 % of them outliers, 0.3 px of noise, 1920x1200 px, focal length 1400 px. The
/// rig starts 5 degrees off about each axis, is knocked by half a degree about each, and then gets
/// batches of outliers until the state is lost.
///
/// Times are estimates: 1.5 cycles an instruction at 168 MHz (Cortex-M4F), 1.0 at 480 MHz (Cortex-M7),
/// memory without wait states.
///
/// Counts repeat exactly, but differ between compiler versions. The committed tables are
/// firmware-sim/measure/costs/VERSION.csv, one for each rustc version. --check takes the table of the
/// rustc that built the programs (rustup's or Debian's, as .cargo/for-target finds it) and allows 3 %.
/// Without a table of that version it takes the one of the nearest version and allows 40 %.
#[derive(Debug, Parser)]
#[command(
    name = "controller-cost",
    version,
    after_help = "Examples:
  cargo controller-cost                 the table
  cargo controller-cost --check         fail where a figure has moved
  cargo controller-cost --check --board m4f    the same for one board, in half the time
  cargo controller-cost --update        write the table of this compiler, and EVIDENCE.md and README.md
  cargo controller-cost --repeat 5      prove that the counts repeat
  cargo controller-cost --calls         every single call as well

Builds: opt-level 3 and s, fat LTO, one codegen unit, panic=abort (profiles controller and
controller-size). .ci/install-toolchain installs the compiler and QEMU."
)]
struct Args {
    /// Compare with the committed table, and fail if a figure has moved by more than 3 %, up or down, or by more than
    /// 40 % from a table of another rustc version.
    #[arg(long, conflicts_with = "update")]
    check: bool,

    /// Measure only this board [default: both].
    #[arg(long, value_enum, conflicts_with = "update")]
    board: Option<Board>,

    /// Write the committed table of the rustc that built the programs, and the figures of the newest table into
    /// EVIDENCE.md and README.md.
    #[arg(long)]
    update: bool,

    /// Number of runs of each program; fail unless all print the same.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=100))]
    repeat: u16,

    /// Print the instructions of every single call before the table.
    #[arg(long)]
    calls: bool,

    /// Folder of the committed tables [default: firmware-sim/measure/costs].
    #[arg(long, value_name = "FOLDER")]
    table: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        // The program that reads the output has closed it: no error.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<()> {
    let default = || compile::root().join("firmware-sim/measure/costs");
    let folder = args.table.clone().unwrap_or_else(default);
    // Read first, so that a missing table is an error before minutes of builds.
    let committed = args.check.then(|| table::read_all(&folder)).transpose()?;
    let repeat = usize::from(args.repeat);
    let boards = args.board.map_or_else(|| Board::ALL.to_vec(), |board| vec![board]);
    let bar = progress::over(measurement::steps(&boards, repeat), "builds and runs");
    let (measured, output) = measurement::table(&boards, repeat, &bar)?;
    bar.finish_and_clear();
    if args.calls {
        print_calls(&output)?;
    }
    print(&measured)?;
    if args.update {
        measured.write(&folder)?;
        documents::write(&compile::root(), &table::read_all(&folder)?)?;
    }
    committed.map_or(Ok(()), |tables| check(&tables, &measured, &boards))
}

/// Prints the lines about single calls.
fn print_calls(output: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    output.lines().filter(|line| line.starts_with('#')).try_for_each(|line| writeln!(out, "{line}"))
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

fn check(tables: &[Table], measured: &Table, boards: &[Board]) -> Result<()> {
    let committed = table::nearest(tables, &measured.compiler).context("no committed table")?;
    let bound = compare::bound(committed, measured);
    println!("\n{}", comparison(committed, measured, bound));
    let is_measured = |row: &&Row| boards.iter().any(|board| board.name() == row.board);
    let rows: Vec<_> = committed.rows.iter().filter(is_measured).cloned().collect();
    let changes = compare::changes(&rows, &measured.rows, bound);
    for change in &changes {
        println!("{change}");
    }
    ensure!(
        changes.is_empty(),
        "{} figures have changed; --update writes the table of rustc {}",
        changes.len(),
        measured.compiler
    );
    println!("all {} figures are within the bound", measured.rows.len());
    Ok(())
}

/// The table and the bound of the check, in one line.
fn comparison(committed: &Table, measured: &Table, bound: Bound) -> String {
    let Bound { percent, .. } = bound;
    let [committed, measured] = [&committed.compiler, &measured.compiler];
    if committed == measured {
        format!("checked against the table of rustc {committed}, bound {percent} %")
    } else {
        format!(
            "no table of rustc {measured}: checked against that of rustc {committed}, the nearest \
             version, bound {percent} %"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_and_the_compiler_are_printed_in_one_line() {
        let [old, new] = ["1.95.0", "1.96.0"]
            .map(|version| Table { compiler: version.parse().unwrap(), rows: Vec::new() });
        let printed = |a, b| comparison(a, b, compare::bound(a, b));
        assert_eq!(printed(&new, &new), "checked against the table of rustc 1.96.0, bound 3 %");
        assert_eq!(
            printed(&new, &old),
            "no table of rustc 1.95.0: checked against that of rustc 1.96.0, the nearest version, \
             bound 40 %"
        );
    }

    #[test]
    fn the_help_states_both_bounds() {
        use clap::CommandFactory;
        let help = Args::command().render_long_help().to_string();
        for bound in [Bound::SAME, Bound::OTHER] {
            assert!(help.contains(&format!("{} %", bound.percent)), "{help}");
        }
    }
}
