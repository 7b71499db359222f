//! Builds and runs all programs: the rows of the table.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::thread::{self, ScopedJoinHandle};

use anyhow::{Context, Result, anyhow, ensure};
use indicatif::ProgressBar;
use semver::Version;

use crate::image::{Image, compiler};
use crate::table::{Row, Table};
use crate::variant::{Board, Variant};
use crate::{compile, emulate};

/// Number of builds and runs.
pub(crate) fn steps(boards: &[Board], repeat: usize) -> usize {
    let of_variant = |variant: Variant| 1 + variant.board.scalars().len() * repeat;
    boards.iter().flat_map(|board| Variant::of(*board)).map(of_variant).sum()
}

/// The figures of a board, and the output of its programs.
struct BoardFigures {
    compiler: Version,
    rows: Vec<Row>,
    output: String,
}

/// Measures every variant of some boards. Returns the table, and the output of all programs.
///
/// * `repeat`: runs of each program, which must all print the same.
pub(crate) fn table(
    boards: &[Board],
    repeat: usize,
    progress: &ProgressBar,
) -> Result<(Table, String)> {
    // A thread per board: while the programs of one board run, which takes one core, those of the other are built.
    let figures = thread::scope(|scope| {
        let start = |board: &Board| {
            let board = *board;
            scope.spawn(move || figures(board, repeat, progress))
        };
        let threads: Vec<_> = boards.iter().map(start).collect();
        let join = |thread: ScopedJoinHandle<'_, _>| {
            thread.join().map_err(|_| anyhow!("a measurement panicked"))?
        };
        threads.into_iter().map(join).collect::<Result<Vec<BoardFigures>>>()
    })?;
    let compiler = figures.first().context("no board")?.compiler.clone();
    let same = figures.iter().all(|board| board.compiler == compiler);
    ensure!(same, "the boards were built by different compilers");
    let (rows, output): (Vec<_>, Vec<_>) =
        figures.into_iter().map(|board| (board.rows, board.output)).unzip();
    Ok((Table { compiler, rows: rows.concat() }, output.concat()))
}

fn figures(board: Board, repeat: usize, progress: &ProgressBar) -> Result<BoardFigures> {
    let (mut version, mut rows, mut output) = (None, Vec::new(), String::new());
    for variant in Variant::of(board) {
        progress.set_message(format!("builds and runs, building for {variant}"));
        let programs = compile::programs(variant)?;
        progress.inc(1);
        progress.set_message(format!("builds and runs, on {variant}"));
        for scalar in board.scalars() {
            let program = &programs[&format!("cost-{scalar}")];
            let text = repeated(board, program, repeat, progress)?;
            rows.extend(printed(&text, variant, scalar)?);
            version = Some(compiler(program)?);
            output += &text;
        }
        if board == Board::CortexM4F {
            rows.extend(sizes(&programs, variant)?);
        }
    }
    Ok(BoardFigures { compiler: version.context("nothing was built")?, rows, output })
}

fn repeated(board: Board, program: &Path, repeat: usize, progress: &ProgressBar) -> Result<String> {
    let mut texts = (0..repeat).map(|_| {
        let text = emulate::output(board, program);
        progress.inc(1);
        text
    });
    let first = texts.next().context("no run")??;
    for text in texts {
        ensure!(text? == first, "{} counts differently in another run", program.display());
    }
    Ok(first)
}

/// The rows that a program printed.
fn printed(text: &str, variant: Variant, scalar: &str) -> Result<Vec<Row>> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines
        .map(|line| {
            let fields: Vec<_> = line.split(',').collect();
            let [what, unit, value] = fields.as_slice() else {
                anyhow::bail!("not a row: {line}");
            };
            let value = value.parse().with_context(|| format!("not a number: {line}"))?;
            Ok(row(variant, scalar, what, unit, value))
        })
        .collect()
}

/// Flash and RAM of the core: a program that calls the whole facade less an empty one, and a program that also calls
/// the store less the first.
fn sizes(programs: &HashMap<String, PathBuf>, variant: Variant) -> Result<[Row; 4]> {
    let size = |program: &str| Image::of(&programs[program]);
    let core = size("facade")?.less(size("bare")?);
    let store = size("facade-store")?.less(size("facade")?);
    let row = |what, value| row(variant, "f32", what, "bytes", value);
    Ok([
        row("flash: code and constants", core.code),
        row("flash: initial values of a static calibrator", core.data),
        row("RAM: statics", core.data + core.zeroed),
        row("flash: records and store", store.code),
    ])
}

fn row(variant: Variant, scalar: &str, what: &str, unit: &str, value: u64) -> Row {
    Row {
        board: variant.board.name().into(),
        scalar: scalar.into(),
        opt: variant.optimisation.level().into(),
        what: what.into(),
        unit: unit.into(),
        value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variant::Optimisation;

    const VARIANT: Variant = Variant { board: Board::CortexM7, optimisation: Optimisation::Size };

    #[test]
    fn rows_are_parsed_and_comments_skipped() {
        let rows = printed("# locked\npush,instructions,365\n", VARIANT, "f64").unwrap();
        assert_eq!(rows, [row(VARIANT, "f64", "push", "instructions", 365)]);
        assert_eq!(rows[0].key(), ["m7", "f64", "s", "push"]);
    }

    #[test]
    fn output_other_than_rows_is_refused() {
        for text in ["panicked at pair.rs", "push,instructions,many"] {
            assert!(printed(text, VARIANT, "f64").is_err(), "{text}");
        }
    }

    #[test]
    fn every_repetition_is_a_step() {
        assert_eq!([steps(&Board::ALL, 1), steps(&Board::ALL, 5)], [4 + 6, 4 + 30]);
        assert_eq!(steps(&[Board::CortexM4F], 1), 2 + 2);
    }
}
