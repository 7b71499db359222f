//! The figures in the documents of the repository: a page with the whole table, and some rows of others.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::table::{Row, Table, as_f64};

/// The page with all figures.
const PAGE: &str = "host-tests/evidence/tables/costs.md";

/// The part of the core's documentation with the longest calls.
const REAL_TIME: &str = "core/docs/real-time.md";

/// Modules of the core with a row in core/BUILDS.md.
const MODULES: [&str; 12] = [
    "fusion",
    "pair",
    "algebra",
    "geometry",
    "calibrator",
    "outcome",
    "depth",
    "batch",
    "link",
    "store",
    "record",
    "paper",
];

/// Board, scalar and optimisation of a column.
type Column = [&'static str; 3];

const M4F: Column = ["m4f", "f32", "3"];
const M4F_SMALL: Column = ["m4f", "f32", "s"];
const M7: Column = ["m7", "f32", "3"];
const M7_DOUBLE: Column = ["m7", "f64", "3"];

/// Writes the figures into the documents below `root`.
pub(crate) fn write(root: &Path, table: &Table) -> Result<()> {
    for (path, text) in updated(root, table)? {
        fs::create_dir_all(root.join(path).parent().unwrap_or(root))?;
        fs::write(root.join(path), text).with_context(|| format!("cannot write {path}"))?;
    }
    Ok(())
}

/// The documents, by path, with the figures of a table.
fn updated(root: &Path, table: &Table) -> Result<[(&'static str, String); 5]> {
    let of = |path: &'static str, rows: Vec<(&str, Vec<String>)>| {
        let text = fs::read_to_string(root.join(path)).with_context(|| path.to_owned())?;
        let text = rows.iter().try_fold(text, |text, (label, cells)| replaced(&text, label, cells));
        anyhow::Ok((path, text.with_context(|| path.to_owned())?))
    };
    let evidence = of("host-tests/EVIDENCE.md", evidence(table)?)?;
    let real_time = (REAL_TIME, real_time(table)?);
    let builds = of("core/BUILDS.md", builds(table)?)?;
    Ok([(PAGE, page(table)), real_time, builds, evidence, of("README.md", readme(table)?)?])
}

/// The longest calls, for the page of the core.
fn real_time(table: &Table) -> Result<String> {
    let of = |what: &str| anyhow::Ok(grouped(figure(table, M4F, what)?.value));
    let at_most = |what: &str| of(&format!("{what} at most"));
    let both = |what: &str| {
        anyhow::Ok(format!(
            "{} in the mean, at most {}",
            of(&format!("{what} mean"))?,
            at_most(what)?
        ))
    };
    let rows = [
        ("decoding of a record ([`link`])", of("decode a record mean")?, "one per match"),
        ("[`Calibrator::push`], full batch", both("push into a full batch")?, "one per match"),
        (
            "[`Calibrator::push`], all matches in one place",
            both("push into a full cell")?,
            "one per match",
        ),
        (
            "[`Calibrator::advance_pair`], the first one",
            at_most("advance_pair that begins")?,
            "one per pair",
        ),
        (
            "[`Calibrator::advance_pair`], a pass",
            at_most("advance_pair")?,
            "2 in a track, in a search up to [`Config::with_max_passes`]",
        ),
        (
            "[`Calibrator::advance_pair`], the last pass",
            at_most("advance_pair that evaluates")?,
            "one per pair",
        ),
        (
            "[`Calibrator::advance_pair`], the fusion",
            at_most("advance_pair that fuses")?,
            "one per pair",
        ),
        (
            "[`Calibrator::advance_pair`], the verdict",
            at_most("advance_pair that judges")?,
            "one per pair",
        ),
        ("[`Calibrator::details`]", at_most("details")?, "as needed"),
        ("[`Calibrator::apply`]", at_most("apply")?, "as needed"),
    ];
    let rows =
        rows.map(|(call, instructions, calls)| format!("| {call} | {instructions} | {calls} |\n"));
    Ok(format!(
        "| call | instructions | calls |\n|---|---|---|\n{}\n\
         * A frame of 1,000 matches takes from its first byte to its outcome at most {} instructions while the \
         estimate is\n  locked, and {} while it is acquiring. A pair of mismatches alone takes {}.\n",
        rows.concat(),
        at_most("frame of 1000 wire to fused locked")?,
        at_most("frame of 1000 wire to fused acquiring")?,
        at_most("update of 256 of mismatches")?,
    ))
}

/// Flash of the builds and of the modules of the core.
fn builds(table: &Table) -> Result<Vec<(&'static str, Vec<String>)>> {
    let columns = [M4F, M4F_SMALL];
    let both = |what: &str| {
        let size = |column| anyhow::Ok(kilobytes(figure(table, column, what)?.value, 1));
        columns.map(size).into_iter().collect::<Result<Vec<_>>>()
    };
    let mut rows = vec![
        ("the estimator", both("flash: code and constants")?),
        ("records and the flash store, in addition", both("flash: records and store")?),
    ];
    for module in MODULES {
        let alone = both(&format!("flash of {module}")).unwrap_or_else(|_| vec![String::new(); 2]);
        let every = both(&format!("flash of {module} with every call"))?;
        rows.push((module, [alone, every].concat()));
    }
    Ok(rows)
}

/// All figures, a line for each of the first column.
fn page(table: &Table) -> String {
    let columns = [M4F, M4F_SMALL, M7, M7_DOUBLE];
    let heads = columns.map(|[board, scalar, opt]| format!("{board}, `{scalar}`, opt-level {opt}"));
    let mut text = format!(
        "# Cost on a controller\n\n\
         `cargo controller-cost --update` writes this page. Programs of rustc {}, fat LTO, in QEMU, which counts \
         instructions\nexactly. Scene: 256 matches, 30 % outliers. Numbers without a unit are instructions. Times are not \
         measured.\nm4f: cycles of [the model](../../../firmware-sim/cycles/README.md) of the Cortex-M4F at 168 MHz, flash \
         without wait states.\nm7: one cycle an instruction at 480 MHz, because the manual of the Cortex-M7 has no table of \
         cycles.\n\n| | {} |\n|---|{}\n",
        table.compiler,
        heads.join(" | "),
        "--:|".repeat(columns.len()),
    );
    let rows = table.rows.iter().filter(|row| row.key[..3] == M4F && !row.is_in_cycles());
    for what in rows.map(|row| &row.key[3]) {
        let cell = |[board, scalar, opt]: Column| {
            let key = [board, scalar, opt, what];
            table.get(key).map(|row| cell(row, table.ms(key)))
        };
        let cells = columns.map(|column| cell(column).unwrap_or_default());
        text += &["| ", what, " | ", &cells.join(" | "), " |\n"].concat();
    }
    text
}

fn cell(row: &Row, ms: Option<f64>) -> String {
    match ms.filter(|_| row.value >= 10_000) {
        Some(ms) => format!("{} k, {ms:.2} ms", grouped((row.value + 500) / 1000)),
        None if row.unit == "bytes" => format!("{} bytes", grouped(row.value)),
        None => grouped(row.value),
    }
}

/// A text with the cells behind the label of one row replaced.
fn replaced(text: &str, label: &str, cells: &[String]) -> Result<String> {
    let mut found = 0;
    let lines = text.lines().map(|line| {
        let Some(rest) = line.strip_prefix(&format!("| {label} | ")) else { return line.into() };
        found += 1;
        let rest: Vec<_> = rest.split(" | ").skip(cells.len()).collect();
        let end = if rest.is_empty() { " |".into() } else { format!(" | {}", rest.join(" | ")) };
        format!("| {label} | {}{end}", cells.join(" | "))
    });
    let lines: Vec<String> = lines.collect();
    ensure!(found == 1, "{found} rows `{label}` instead of one");
    Ok(lines.join("\n") + "\n")
}

fn figure<'a>(table: &'a Table, [board, scalar, opt]: Column, what: &str) -> Result<&'a Row> {
    table.get([board, scalar, opt, what]).with_context(|| format!("no figure {board}, {what}"))
}

fn ms(table: &Table, [board, scalar, opt]: Column, what: &str) -> Result<String> {
    let ms = table.ms([board, scalar, opt, what]);
    let ms = ms.with_context(|| format!("no time of {board}, {what}"))?;
    Ok(format!("{ms:.1} ms"))
}

fn size(table: &Table) -> Result<String> {
    Ok(kilobytes(figure(table, M4F, "size_of Calibrator")?.value, 1))
}

fn flash(table: &Table, column: Column) -> Result<String> {
    Ok(kilobytes(figure(table, column, "flash: code and constants")?.value, 0))
}

/// Deepest stack of any call of a board in `f32`, over both optimisations.
fn stack(table: &Table, board: &str) -> Result<String> {
    let rows = table.rows.iter().filter(|Row { key: [of, scalar, _, what], .. }| {
        of == board && scalar == "f32" && what.starts_with("stack of ")
    });
    Ok(kilobytes(rows.map(|row| row.value).max().context("no stack")?, 1))
}

fn evidence(table: &Table) -> Result<Vec<(&'static str, Vec<String>)>> {
    let cell = format!(
        "{}; {}; {}, {} at opt-level `s`",
        ms(table, M4F, "update of 256 locked mean")?,
        size(table)?,
        flash(table, M4F)?,
        flash(table, M4F_SMALL)?,
    );
    let label = "A locked pair of 256 matches on a Cortex-M4F at 168 MHz; RAM; flash";
    Ok(vec![(label, vec![cell])])
}

fn readme(table: &Table) -> Result<Vec<(&'static str, Vec<String>)>> {
    let times = |what| anyhow::Ok(vec![ms(table, M4F, what)?, ms(table, M7, what)?]);
    let [fast, small] = [M4F, M4F_SMALL].map(|column| flash(table, column));
    Ok(vec![
        ("a pair, locked", times("update of 256 locked mean")?),
        (
            "a pair while acquiring: at most; on the host the mean",
            times("update of 256 acquiring at most")?,
        ),
        (
            "any pair, at most: one of mismatches only",
            times("update of 256 of mismatches at most")?,
        ),
        ("RAM of the calibrator", vec![size(table)?; 3]),
        (
            "stack of the core, with the flash store, at most (opt-level `s`)",
            vec![stack(table, "m4f")?, stack(table, "m7")?],
        ),
        (
            "flash, estimator without link and store",
            vec![format!("{}; {} at opt-level `s`", fast?, small?)],
        ),
    ])
}

/// The number, with a comma between thousands.
fn grouped(value: u64) -> String {
    match value / 1000 {
        0 => value.to_string(),
        thousands => format!("{},{:03}", grouped(thousands), value % 1000),
    }
}

fn kilobytes(bytes: u64, decimals: usize) -> String {
    format!("{:.decimals$} kB", as_f64(bytes) / 1000.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documents_have_the_figures_of_the_table() {
        let root = emulator::root();
        let table = Table::read(&crate::table_file()).unwrap();
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            return write(&root, &table).unwrap();
        }
        for (path, text) in updated(&root, &table).unwrap() {
            let committed = fs::read_to_string(root.join(path)).unwrap();
            assert!(committed == text, "{path}: UPDATE_EXPECT=1 writes it");
        }
    }

    #[test]
    fn cells_behind_the_label_are_replaced_and_the_rest_stays() {
        let cells = ["1", "2"].map(String::from);
        let text = "| | a | b | c | d |\n| push | 7 | 8 | 9 | |\n| other | 7 |\n";
        let updated = "| | a | b | c | d |\n| push | 1 | 2 | 9 | |\n| other | 7 |\n";
        assert_eq!(replaced(text, "push", &cells).unwrap(), updated);
        assert_eq!(replaced("| push | 7 | 8 |\n", "push", &cells).unwrap(), "| push | 1 | 2 |\n");
        assert!(replaced("| other | 7 |\n", "push", &cells).is_err());
        assert!(replaced(&text.repeat(2), "push", &cells).is_err());
    }

    #[test]
    fn numbers_read_as_in_print() {
        let of = |unit, value, ms| cell(&Row::new(["m4f", "f32", "3", "push"], unit, value), ms);
        assert_eq!(of("instructions", 9_999, Some(0.1)), "9,999");
        assert_eq!(of("instructions", 1_221_455, Some(10.906)), "1,221 k, 10.91 ms");
        assert_eq!(of("bytes", 11_756, None), "11,756 bytes");
        assert_eq!(kilobytes(11_756, 1), "11.8 kB");
    }
}
