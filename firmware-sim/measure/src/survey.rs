//! Builds and runs everything: the rows of the table.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use host_tests::run::progress::Bar;

use crate::image::{Image, compiler};
use crate::table::{Row, Table};
use crate::variant::{Board, Variant};
use crate::{compile, emulate};

/// Builds and runs of a survey.
pub(crate) fn steps(repeat: usize) -> usize {
    let runs: usize = Variant::all().map(|variant| variant.board.scalars().len()).sum();
    Variant::all().count() + runs * repeat
}

/// Measures every variant.
///
/// * `repeat`: runs of each program, which must all print the same.
/// * `calls`: is given what each program prints of single calls.
pub(crate) fn table(repeat: usize, progress: &Bar, mut calls: impl FnMut(&str)) -> Result<Table> {
    let mut table = Table { compiler: String::new(), rows: Vec::new() };
    for variant in Variant::all() {
        progress.set_message(format!("builds and runs, building for {variant}"));
        let programs = compile::programs(variant)?;
        progress.inc(1);
        progress.set_message(format!("builds and runs, on {variant}"));
        for scalar in variant.board.scalars() {
            let program = &programs[&format!("cost-{scalar}")];
            let text = repeated(variant.board, program, repeat, progress)?;
            calls(&text);
            table.rows.extend(printed(&text, variant, scalar)?);
            table.compiler = compiler(program)?;
        }
        if variant.board == Board::CortexM4F {
            table.rows.extend(sizes(&programs, variant)?);
        }
    }
    Ok(table)
}

fn repeated(board: Board, program: &Path, repeat: usize, progress: &Bar) -> Result<String> {
    let mut texts = (0..repeat).map(|_| {
        let text = emulate::output(board, program);
        progress.inc(1);
        text
    });
    let first = texts.next().context("nothing to run")??;
    for text in texts {
        ensure!(text? == first, "{} counts otherwise when it is run again", program.display());
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

/// What the core adds to a program that calls all of its facade.
fn sizes(programs: &HashMap<String, PathBuf>, variant: Variant) -> Result<[Row; 3]> {
    let core = Image::of(&programs["facade"])?.beyond(Image::of(&programs["bare"])?);
    let row = |what, value| row(variant, "f32", what, "bytes", value);
    Ok([
        row("flash: code and constants", core.code),
        row("flash: initial values of a static calibrator", core.data),
        row("RAM: statics", core.data + core.zeroed),
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
    fn rows_are_read_and_remarks_are_not() {
        let rows = printed("# locked\npush,instructions,365\n", VARIANT, "f64").unwrap();
        assert_eq!(rows, [row(VARIANT, "f64", "push", "instructions", 365)]);
        assert_eq!(rows[0].key(), ["m7", "f64", "s", "push"]);
    }

    #[test]
    fn what_is_no_row_is_refused() {
        for text in ["panicked at survey.rs", "push,instructions,many"] {
            assert!(printed(text, VARIANT, "f64").is_err(), "{text}");
        }
    }

    #[test]
    fn every_repetition_is_a_step() {
        assert_eq!([steps(1), steps(5)], [4 + 6, 4 + 30]);
    }
}
