//! Limits and errors of a CSV file with the matches of many pairs.

use std::error::Error;
use std::fmt;
use std::io;

/// Longest line with its line feed, bytes.
pub const LONGEST_LINE: usize = 4096;

/// Most rows of a frame.
pub const MOST_ROWS: usize = 1 << 20;

/// Why a CSV file of matches by frame is refused. Lines are counted from 1.
#[derive(Debug)]
#[non_exhaustive]
pub enum FrameRowsError {
    /// It cannot be read.
    Io(io::Error),
    /// It has only empty lines, or no line.
    Empty,
    /// The first line that is not empty does not name the columns.
    Header {
        /// The line.
        line: u64,
        /// The error in it.
        why: String,
    },
    /// It has no matches below the header.
    NoRows,
    /// A line is longer than [`LONGEST_LINE`], or not UTF-8 text.
    Line(u64),
    /// The number of fields of a line differs from the header.
    Fields {
        /// The line.
        line: u64,
        /// Number of its fields.
        found: usize,
        /// Number of fields in the header.
        expected: usize,
    },
    /// The number of a frame is not a whole number from 0.
    Frame {
        /// The line.
        line: u64,
        /// Its text.
        field: String,
    },
    /// A field is not a finite number.
    Number {
        /// The line.
        line: u64,
        /// The column.
        column: &'static str,
        /// Its text.
        field: String,
    },
    /// The rows of a frame continue after those of another frame.
    Returned {
        /// The line.
        line: u64,
        /// The frame.
        frame: u64,
    },
    /// A frame has more than [`MOST_ROWS`] rows.
    TooLong {
        /// The line.
        line: u64,
        /// The frame.
        frame: u64,
    },
}

impl fmt::Display for FrameRowsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(why) => why.fmt(f),
            Self::Empty => f.write_str("it is empty"),
            Self::Header { line, why } => write!(
                f,
                "line {line}: {why}; the first line that is not empty names the columns frame,ul,vl,ur,vr and optionally score,step"
            ),
            Self::NoRows => f.write_str("there are no matches below the header"),
            Self::Line(line) => {
                write!(f, "line {line}: not text, or longer than {LONGEST_LINE} bytes")
            }
            Self::Fields { line, found, expected } => {
                write!(f, "line {line}: {found} fields; the header has {expected}")
            }
            Self::Frame { line, field } => {
                write!(f, "line {line}: frame `{field}` is not a whole number from 0")
            }
            Self::Number { line, column, field } => {
                write!(f, "line {line}: {column} `{field}` is not a finite number")
            }
            Self::Returned { line, frame } => write!(
                f,
                "line {line}: frame {frame} continues after another one: the rows of a frame must follow \
                 each other"
            ),
            Self::TooLong { line, frame } => {
                write!(f, "line {line}: frame {frame} has more than {MOST_ROWS} rows")
            }
        }
    }
}

impl Error for FrameRowsError {}
