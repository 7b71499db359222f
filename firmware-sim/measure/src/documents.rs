//! The figures of the newest table in the documents of the repository.
//!
//! A row of a document is found by its label, the first cell. The cells behind the label are replaced, as many as the
//! row has in this module. The rest of the line stays.

use std::path::Path;
use std::{fs, iter};

use anyhow::{Context, Result, ensure};

use crate::duration;
use crate::table::{Row, Table};

/// Board, scalar and optimisation of a column.
type Column = [&'static str; 3];

const M4F: Column = ["m4f", "f32", "3"];
const M4F_SMALL: Column = ["m4f", "f32", "s"];
const M7: Column = ["m7", "f32", "3"];
const COLUMNS: [Column; 4] = [M4F, M4F_SMALL, M7, ["m7", "f64", "3"]];

/// Form of the figures of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Show {
    Exact,
    /// In thousands from ten thousand on.
    Rounded,
    /// As [`Show::Rounded`], and in milliseconds.
    Timed,
    Bytes,
    /// Bytes, for the M4F only.
    Flash,
}

/// Rows of EVIDENCE.md: label, figures, form.
const EVIDENCE: &[(&str, &[&str], Show)] = &[
    (
        "a match and pass: paper, search, robust evaluation",
        &["pass paper", "pass search", "pass judging robust"],
        Show::Exact,
    ),
    ("update, locked", &["update of 256 locked mean"], Show::Timed),
    ("update, acquiring, at most", &["update of 256 acquiring at most"], Show::Timed),
    ("update, of mismatches, at most", &["update of 256 of mismatches at most"], Show::Timed),
    ("longest call of a pair but `solve_pair`", &["longest call"], Show::Timed),
    (
        "last call of `advance_pair`, which fuses; `health`: at most",
        &["advance_pair that fuses at most", "health at most"],
        Show::Rounded,
    ),
    (
        "`push`, pinhole, radial-tangential",
        &["push pinhole mean", "push radial-tangential mean"],
        Show::Exact,
    ),
    (
        "`push` into a full batch: mean, at most",
        &["push into a full batch mean", "push into a full batch at most"],
        Show::Exact,
    ),
    (
        "the same with all matches in one cell of the grid",
        &["push into a full cell mean", "push into a full cell at most"],
        Show::Exact,
    ),
    (
        "frame of 1,000 matches, wire to fused: locked, acquiring at most",
        &[
            "frame of 1000 wire to fused locked mean",
            "frame of 1000 wire to fused acquiring at most",
        ],
        Show::Rounded,
    ),
    ("a match off the wire, its part of the CRC included", &["decode a record mean"], Show::Exact),
    (
        "16 bytes of a damaged stream: only magics, the same within a frame, only headers",
        &[
            "decode 16 bytes of magics mean",
            "decode 16 bytes of magics within a frame mean",
            "decode 16 bytes of headers mean",
        ],
        Show::Exact,
    ),
    (
        "`push_witness` of a range, of 256 tracks",
        &["push_range at most", "push_motion"],
        Show::Rounded,
    ),
    ("`snapshot`, `restore`", &["snapshot", "restore"], Show::Rounded),
    (
        "`Store::open`, `save` at most, `save_if_due`, `resume`, flash in RAM",
        &["Store::open", "save at most", "save_if_due", "resume"],
        Show::Rounded,
    ),
    (
        "deepest stack found: `solve_pair`, `advance_pair`, its last call, `health`, `restore`",
        &[
            "stack of solve_pair",
            "stack of advance_pair",
            "stack of advance_pair that fuses",
            "stack of health",
            "stack of restore",
        ],
        Show::Bytes,
    ),
    (
        "the same: `Store::open`, `save`, `save_if_due`, `resume`",
        &[
            "stack of Store::open",
            "stack of save at most",
            "stack of save_if_due",
            "stack of resume",
        ],
        Show::Bytes,
    ),
    (
        "flash, whole API but link and store, beside the calibrator itself",
        &["flash: code and constants"],
        Show::Flash,
    ),
    (
        "snapshots, records, store and save policy, beside that",
        &["flash: records and store"],
        Show::Flash,
    ),
];

/// Label of a row, and the cells behind it.
type Cells = (String, Vec<String>);

/// Writes the figures of the newest of the tables into the documents below `root`.
pub(crate) fn write(root: &Path, tables: &[Table]) -> Result<()> {
    for (path, text) in updated(root, tables)? {
        fs::write(root.join(path), text).with_context(|| format!("cannot write {path}"))?;
    }
    Ok(())
}

/// The documents, by path, with the figures of the newest of the tables.
fn updated(root: &Path, tables: &[Table]) -> Result<[(&'static str, String); 2]> {
    let newest = tables.iter().max_by_key(|table| &table.compiler).context("no table")?;
    let figures = Figures(&newest.rows);
    let of = |path: &'static str, rows: &[Cells]| {
        let text = fs::read_to_string(root.join(path)).with_context(|| path.to_owned())?;
        anyhow::Ok((path, replaced(&text, rows).with_context(|| path.to_owned())?))
    };
    let evidence = of("host-tests/EVIDENCE.md", &figures.evidence()?)?;
    Ok([evidence, of("README.md", &figures.readme()?)?])
}

/// A text with the cells of its rows replaced.
fn replaced(text: &str, rows: &[Cells]) -> Result<String> {
    let mut found = vec![0; rows.len()];
    let lines: Vec<String> = text
        .lines()
        .map(|line| {
            let label = line.split(" | ").next().and_then(|cell| cell.strip_prefix("| "));
            let Some(at) = rows.iter().position(|(of, _)| label == Some(of)) else {
                return line.into();
            };
            found[at] += 1;
            let (label, cells) = &rows[at];
            let rest = line.split(" | ").skip(1 + cells.len()).collect::<Vec<_>>().join(" | ");
            let end = if rest.is_empty() { " |".into() } else { format!(" | {rest}") };
            format!("| {label} | {}{end}", cells.join(" | "))
        })
        .collect();
    for ((label, _), found) in rows.iter().zip(found) {
        ensure!(found == 1, "{found} rows `{label}` instead of one");
    }
    Ok(lines.join("\n") + "\n")
}

/// The rows of a table.
struct Figures<'a>(&'a [Row]);

impl Figures<'_> {
    fn row(&self, [board, scalar, opt]: Column, what: &str) -> Result<&Row> {
        let key = [board, scalar, opt, what];
        let row = self.0.iter().find(|row| row.key() == key);
        row.with_context(|| format!("no figure {}", key.join(", ")))
    }

    fn value(&self, column: Column, what: &str) -> Result<u64> {
        Ok(self.row(column, what)?.value)
    }

    /// Milliseconds of a figure in instructions.
    fn ms(&self, column: Column, what: &str) -> Result<String> {
        let estimated = duration::estimated(self.row(column, what)?);
        Ok(format!("{:.1} ms", estimated.context("not in instructions")?.0))
    }

    /// Cells of a row of EVIDENCE.md: one for each column, or of flash for each optimisation of the M4F.
    fn cells(&self, whats: &[&str], show: Show) -> Result<Vec<String>> {
        let of = |&column: &Column| {
            let value = |what| self.value(column, what);
            let all = whats.iter().map(|what| {
                anyhow::Ok(match show {
                    Show::Exact | Show::Bytes | Show::Flash => grouped(value(what)?),
                    Show::Rounded => rounded(value(what)?),
                    Show::Timed => format!("{}, {}", rounded(value(what)?), self.ms(column, what)?),
                })
            });
            let cell = all.collect::<Result<Vec<_>>>()?.join(", ");
            let is_bytes = matches!(show, Show::Bytes | Show::Flash);
            Ok(if is_bytes { cell + " bytes" } else { cell })
        };
        let columns = if show == Show::Flash { &COLUMNS[..2] } else { &COLUMNS };
        columns.iter().map(of).collect()
    }

    /// Deepest stack of any call of a board in `f32`, over both optimisations.
    fn stack(&self, board: &str) -> Result<String> {
        let is_stack = |row: &&Row| {
            let [of, scalar, _, what] = row.key();
            of == board && scalar == "f32" && what.starts_with("stack of ")
        };
        let most = self.0.iter().filter(is_stack).map(|row| row.value).max();
        Ok(kilobytes(most.context("no stack")?, 1))
    }

    fn evidence(&self) -> Result<Vec<Cells>> {
        let headline = format!(
            "{}; {}; {}, {} at opt-level `s`",
            self.ms(M4F, "update of 256 locked mean")?,
            kilobytes(self.value(M4F, "size_of Calibrator")?, 1),
            kilobytes(self.value(M4F, "flash: code and constants")?, 0),
            kilobytes(self.value(M4F_SMALL, "flash: code and constants")?, 0),
        );
        let rows = EVIDENCE.iter().map(|(label, whats, show)| {
            anyhow::Ok(((*label).to_owned(), self.cells(whats, *show)?))
        });
        let headline = (
            "A locked pair of 256 matches on a Cortex-M4F at 168 MHz; RAM; flash".to_owned(),
            vec![headline],
        );
        iter::once(Ok(headline)).chain(rows).collect()
    }

    fn readme(&self) -> Result<Vec<Cells>> {
        let times = |label: &str, what| {
            anyhow::Ok((label.to_owned(), vec![self.ms(M4F, what)?, self.ms(M7, what)?]))
        };
        let size = kilobytes(self.value(M4F, "size_of Calibrator")?, 1);
        let flash = |column| Ok(kilobytes(self.value(column, "flash: code and constants")?, 0));
        let [fast, small]: [Result<String>; 2] = [M4F, M4F_SMALL].map(flash);
        Ok(vec![
            times("a pair, locked", "update of 256 locked mean")?,
            times(
                "a pair while acquiring: at most; on the host the mean",
                "update of 256 acquiring at most",
            )?,
            times(
                "any pair, at most: one of mismatches only",
                "update of 256 of mismatches at most",
            )?,
            ("RAM of the calibrator".into(), vec![size; 3]),
            (
                "stack of the core, with the flash store, at most (opt-level `s`)".into(),
                vec![self.stack("m4f")?, self.stack("m7")?],
            ),
            (
                "flash, whole API without link and store".into(),
                vec![format!("{}; {} at opt-level `s`", fast?, small?)],
            ),
        ])
    }
}

/// The number, with a comma between thousands.
fn grouped(value: u64) -> String {
    match value / 1000 {
        0 => value.to_string(),
        thousands => format!("{},{:03}", grouped(thousands), value % 1000),
    }
}

/// The number, in thousands from ten thousand on.
fn rounded(value: u64) -> String {
    if value < 10_000 { grouped(value) } else { format!("{} k", grouped((value + 500) / 1000)) }
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^52")]
fn kilobytes(bytes: u64, decimals: usize) -> String {
    format!("{:.decimals$} kB", bytes as f64 / 1000.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{compile, table};

    #[test]
    fn the_documents_have_the_figures_of_the_newest_table() {
        let root = compile::root();
        let tables = table::read_all(&root.join("firmware-sim/measure/costs")).unwrap();
        for (path, text) in updated(&root, &tables).unwrap() {
            let committed = fs::read_to_string(root.join(path)).unwrap();
            let differ = committed.lines().zip(text.lines()).filter(|(old, new)| old != new);
            let differ: Vec<_> = differ.collect();
            assert!(
                differ.is_empty(),
                "{path}: `cargo controller-cost --update` writes {differ:#?}"
            );
        }
    }

    #[test]
    fn cells_behind_the_label_are_replaced_and_the_rest_stays() {
        let rows = [("push".to_owned(), vec!["1".to_owned(), "2".to_owned()])];
        let text = "| | a | b | c |\n| push | 7 | 8 | 9 |\n| other | 7 |\n";
        let updated = "| | a | b | c |\n| push | 1 | 2 | 9 |\n| other | 7 |\n";
        assert_eq!(replaced(text, &rows).unwrap(), updated);
        assert_eq!(replaced("| push | 7 | 8 |\n", &rows).unwrap(), "| push | 1 | 2 |\n");
        assert!(replaced("| other | 7 |\n", &rows).is_err());
        assert!(replaced(&text.repeat(2), &rows).is_err());
    }

    #[test]
    fn numbers_read_as_in_print() {
        assert_eq!([7, 1_060, 9_999].map(rounded), ["7", "1,060", "9,999"]);
        assert_eq!([43_950, 1_221_455].map(rounded), ["44 k", "1,221 k"]);
        assert_eq!(
            (grouped(1_002_003), kilobytes(11_756, 1)),
            ("1,002,003".into(), "11.8 kB".into())
        );
    }
}
