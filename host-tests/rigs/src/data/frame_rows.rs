//! Matches of many pairs in one CSV file: one row for each match, with a column `frame` that names its pair.
//!
//! The first line names the columns, in any order: `frame,ul,vl,ur,vr`, and optionally `score` (default 1) and `step`
//! (default 0). The numbers have the same meaning as in a pair file. `frame` is a whole number from 0; the rows of a
//! frame follow each other. Empty lines are skipped. This module splits lines itself, because the `csv` crate accepts
//! lines of any length, and a pipe may never end its line.

use std::collections::BTreeSet;
use std::io::{BufRead, Read};

use anyhow::{Context, Result, bail, ensure};

use super::csv_file::cause;
use super::frame_numbers::FrameNumbers;
use super::matches::Match;

/// Longest line with its line feed, bytes.
pub const LONGEST_LINE: usize = 4096;

/// Most rows of a frame.
const MOST_ROWS: usize = 1 << 20;

/// Names of the columns; the last two may be missing.
const COLUMNS: [&str; 7] = ["frame", "ul", "vl", "ur", "vr", "score", "step"];

/// Number of required columns.
const NEEDED: usize = 5;

/// Iterator over the pairs of a file of matches by frame. It holds one pair in memory, and ends after an error.
#[derive(Debug)]
pub struct FrameRows<R> {
    input: R,
    /// Number of lines read.
    line: u64,
    /// Position of each of [`COLUMNS`] in a row; `None` for a missing column.
    places: [Option<usize>; COLUMNS.len()],
    /// Number of fields in the header.
    fields: usize,
    /// First row of the next pair, which was read to find the end of the previous one.
    ahead: Option<(u64, Match)>,
    /// Frames of the pairs handed out.
    seen: FrameNumbers,
    ended: bool,
}

impl<R: BufRead> FrameRows<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// If the input cannot be read, or does not start with the names of the columns; names the line, from 1.
    pub fn open(input: R) -> Result<Self> {
        let mut rows = Self {
            input,
            line: 0,
            places: [None; COLUMNS.len()],
            fields: 0,
            ahead: None,
            seen: FrameNumbers::default(),
            ended: false,
        };
        let header = rows.next_line()?.context("it is empty")?;
        (rows.places, rows.fields) =
            columns(&header).with_context(|| format!("line {}", rows.line))?;
        Ok(rows)
    }

    /// The next line that is not empty, without its end.
    fn next_line(&mut self) -> Result<Option<String>> {
        loop {
            let mut bytes = Vec::new();
            // Reads one byte beyond the limit, to notice a longer line.
            let most = u64::try_from(LONGEST_LINE).unwrap_or(u64::MAX).saturating_add(1);
            if (&mut self.input).take(most).read_until(b'\n', &mut bytes)? == 0 {
                return Ok(None);
            }
            self.line += 1;
            if let Some(cause) = cause(&bytes).filter(|_| self.fields == 0 || bytes.contains(&0)) {
                bail!("line {}: {cause}", self.line);
            }
            let text = String::from_utf8(bytes).ok().filter(|text| text.len() <= LONGEST_LINE);
            let text = text.with_context(|| {
                format!("line {}: not text, or longer than {LONGEST_LINE} bytes", self.line)
            })?;
            if !text.trim().is_empty() {
                return Ok(Some(text.trim().to_owned()));
            }
        }
    }

    /// The next row.
    fn next_row(&mut self) -> Result<Option<(u64, Match)>> {
        let Some(text) = self.next_line()? else { return Ok(None) };
        let line = self.line;
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let (found, expected) = (fields.len(), self.fields);
        ensure!(found == expected, "line {line}: {found} fields; the header has {expected}");
        let field = |i: usize| self.places[i].and_then(|place| fields.get(place)).copied();
        let frame = field(0).unwrap_or_default();
        let frame = frame.parse().ok().with_context(|| {
            format!("line {line}: frame `{frame}` is not a whole number from 0")
        })?;
        let number = |i: usize, missing: f64| {
            let Some(field) = field(i) else { return Ok(missing) };
            let number = field.parse().ok().filter(|x: &f64| x.is_finite());
            let column = COLUMNS[i];
            number
                .with_context(|| format!("line {line}: {column} `{field}` is not a finite number"))
        };
        let row = Match {
            ul: number(1, 0.0)?,
            vl: number(2, 0.0)?,
            ur: number(3, 0.0)?,
            vr: number(4, 0.0)?,
            score: number(5, 1.0)?,
            step: number(6, 0.0)?,
        };
        Ok(Some((frame, row)))
    }

    fn next_pair(&mut self) -> Result<Option<Vec<Match>>> {
        let first = match self.ahead.take() {
            Some(row) => Some(row),
            None => self.next_row()?,
        };
        let Some((frame, row)) = first else {
            ensure!(!self.seen.is_empty(), "there are no matches below the header");
            return Ok(None);
        };
        ensure!(
            self.seen.insert(frame),
            "line {}: frame {frame} continues after another one: the rows of a frame must follow each other",
            self.line
        );
        let mut pair = vec![row];
        while let Some((next, row)) = self.next_row()? {
            if next != frame {
                self.ahead = Some((next, row));
                break;
            }
            let fits = pair.len() < MOST_ROWS;
            ensure!(fits, "line {}: frame {frame} has more than {MOST_ROWS} rows", self.line);
            pair.push(row);
        }
        Ok(Some(pair))
    }
}

impl<R: BufRead> Iterator for FrameRows<R> {
    type Item = Result<Vec<Match>>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let pair = self.next_pair().transpose();
        self.ended = !matches!(pair, Some(Ok(_)));
        pair
    }
}

/// Position of each column, and the number of columns.
fn columns(header: &str) -> Result<([Option<usize>; COLUMNS.len()], usize)> {
    // Spreadsheets write a byte order mark first, and quote the names.
    let header = header.trim_start_matches('\u{feff}');
    let names: Vec<&str> =
        header.split(',').map(|name| name.trim().trim_matches('"').trim()).collect();
    let places = COLUMNS.map(|column| names.iter().position(|name| *name == column));
    let missing = COLUMNS.iter().zip(places).take(NEEDED).find(|(_, place)| place.is_none());
    let why = if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        "there is no header".to_owned()
    } else if let Some(name) = names.iter().find(|name| !COLUMNS.contains(name)) {
        format!("`{name}` is not one of the columns")
    } else if names.iter().collect::<BTreeSet<_>>().len() != names.len() {
        "a column occurs twice".to_owned()
    } else if let Some((column, _)) = missing {
        format!("there is no column `{column}`")
    } else {
        return Ok((places, names.len()));
    };
    bail!(
        "{why}; the first line that is not empty names the columns frame,ul,vl,ur,vr and optionally score,step"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Vec<Match>>, String> {
        let read = || FrameRows::open(text.as_bytes())?.collect::<Result<_>>();
        read().map_err(|why| format!("{why:#}"))
    }

    #[test]
    fn rows_are_split_into_pairs_by_frame_for_any_order_of_the_columns() {
        let row = |ul: f64| Match { ul, vl: 2.0, ur: 3.0, vr: 4.0, score: 1.0, step: 0.0 };
        let pairs = vec![vec![row(1.0), row(1.5)], vec![row(-5.0)]];
        for text in [
            "frame,ul,vl,ur,vr\n7,1,2,3,4\n7,1.5,2,3,4\n3,-5,2,3,4\n",
            "\u{feff}\"frame\",\"ul\",\"vl\",\"ur\",\"vr\"\r\n\r\n7,1,2,3,4\r\n7,1.5,2,3,4\r\n3,-5,2,3,4",
            "vr, score, ur, vl, ul, frame\n 4, 1, 3, 2, 1, 7\n4,1,3,2,1.5,7\n\n4,1,3,2,-5,3\n",
        ] {
            assert_eq!(read(text), Ok(pairs.clone()), "{text}");
        }
        let text = "frame,ul,vl,ur,vr,step,score\n0,1,2,3,4,0.5,0.25\n";
        let with_both = Match { score: 0.25, step: 0.5, ..row(1.0) };
        assert_eq!(read(text), Ok(vec![vec![with_both]]));
    }

    #[test]
    fn errors_are_named_with_their_line() {
        let good = "frame,ul,vl,ur,vr\n0,1,2,3,4\n";
        for (text, said) in [
            (String::new(), "empty"),
            ("frame;ul;vl;ur;vr\n0;1,5;2;3;4\n".into(), "semicolons"),
            ("frame\tul\tvl\n".into(), "tabs"),
            ("\u{0}f\u{0}r\n".into(), "bytes of 0"),
            ("0,1,2,3,4\n".into(), "line 1: there is no header"),
            ("\nframe,ul,vl,ur\n".into(), "line 2: there is no column `vr`"),
            ("frame,ul,vl,ur,vr,scores\n".into(), "`scores` is not one"),
            ("frame,ul,vl,ur,vr,ul\n".into(), "twice"),
            ("frame,ul,vl,ur,vr\n".into(), "no matches below the header"),
            (format!("{good}\n0,1,2,3\n"), "line 4: 4 fields; the header has 5"),
            (format!("{good}1.5,1,2,3,4\n"), "line 3: frame `1.5` is not a whole number"),
            (format!("{good}-1,1,2,3,4\n"), "line 3: frame `-1` is not a whole number"),
            (format!("{good}0,1,NaN,3,4\n"), "line 3: vl `NaN` is not a finite number"),
            (format!("{good}0,1,2,1e999,4\n"), "line 3: ur `1e999` is not a finite number"),
            (format!("{good}1,1,2,3,4\n0,1,2,3,4\n"), "line 4: frame 0 continues"),
            (format!("{good}{}\n", "0".repeat(LONGEST_LINE + 1)), "line 3: not text"),
        ] {
            let error = read(&text).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        let longest = "0,1,2,3,4\n".repeat(MOST_ROWS - 1);
        assert_eq!(read(&format!("{good}{longest}")).unwrap()[0].len(), MOST_ROWS);
        let error = read(&format!("{good}{longest}0,1,2,3,4\n")).unwrap_err();
        assert!(error.contains("frame 0 has more than 1048576 rows"), "{error}");
    }

    #[test]
    fn nothing_follows_an_error() {
        let text = "frame,ul,vl,ur,vr\n0,1,2,3,4\n1,1,2,3\n2,1,2,3,4\n";
        let mut rows = FrameRows::open(text.as_bytes()).unwrap();
        assert!(rows.next().unwrap().is_err());
        assert!(rows.next().is_none());
    }
}
