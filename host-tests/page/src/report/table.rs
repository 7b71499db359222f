//! Tables: a click on a heading sorts the rows; numbers are aligned.

use maud::{Markup, html};

use super::numbers::Csv;

/// Length above which the text of a cell gets a least width on narrow screens, bytes.
const LONG: usize = 40;

/// Tables of more columns than this are wider than a phone.
const WIDE: usize = 3;

/// Content of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    shown: String,
    /// In full, for the CSV file.
    full: String,
    /// Sort key.
    number: Option<f64>,
    class: &'static str,
    /// Hint on hovering.
    hint: Option<String>,
}

/// Rows under headings, with their explanation.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of its CSV file, without its ending.
    pub name: String,
    /// Names of the columns, with units.
    pub heading: Vec<String>,
    /// Rows as long as the heading.
    pub rows: Vec<Vec<Cell>>,
    /// Description and origin.
    pub caption: String,
    /// The command that makes it.
    pub command: String,
}

impl Cell {
    /// Words.
    pub fn text(words: impl Into<String>) -> Self {
        let full = words.into();
        let class = if full.len() > LONG { "words" } else { "" };
        Self { shown: full.clone(), full, number: None, class, hint: None }
    }

    /// A number, shown with so many decimals and kept in full.
    pub fn number(value: f64, decimals: usize) -> Self {
        let shown = format!("{value:.decimals$}");
        Self { shown, full: value.to_string(), number: Some(value), class: "number", hint: None }
    }

    /// As [`Cell::number`]; for an unknown value a dash, and the reason on hovering.
    pub fn known(value: Option<f64>, decimals: usize, why: &str) -> Self {
        value.map_or_else(|| Self::missing("-", why), |value| Self::number(value, decimals))
    }

    /// A whole number.
    pub fn count(value: usize) -> Self {
        let number = u32::try_from(value).map_or(f64::INFINITY, f64::from);
        Self { full: value.to_string(), ..Self::number(number, 0) }
    }

    /// A cell without a value: it shows `shown`, and the reason on hovering.
    pub fn missing(shown: &str, why: impl Into<String>) -> Self {
        let why = why.into();
        let full = format!("{shown}: {why}");
        Self { shown: shown.to_owned(), full, number: None, class: "missing", hint: Some(why) }
    }

    /// Marks the cell as the best of its row.
    pub fn best(self) -> Self {
        Self { class: "number best", ..self }
    }

    /// Greys the cell out, because it is not evidence.
    pub fn faint(self) -> Self {
        let class = if self.number.is_some() { "number faint" } else { "faint" };
        Self { class, ..self }
    }

    /// Highlights the cell.
    pub fn alarming(self) -> Self {
        let class = if self.class == "words" { "words alarm" } else { "alarm" };
        Self { class, ..self }
    }

    /// Adds a hint on hovering.
    pub fn with_hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }

    /// The text that the cell shows.
    #[must_use]
    pub fn shown(&self) -> &str {
        &self.shown
    }

    fn markup(&self) -> Markup {
        let key = self.number.map(|number| number.to_string());
        html! {
            td class=(self.class) data-key=[key] title=[self.hint.as_ref()] {
                // A name of a data set may break after an underscore.
                @for (i, part) in self.shown.split_inclusive('_').enumerate() {
                    @if i > 0 { wbr; }
                    (part)
                }
            }
        }
    }
}

impl Table {
    /// A table without rows.
    pub fn new(name: &str, heading: impl IntoIterator<Item = String>) -> Self {
        Self {
            name: name.to_owned(),
            heading: heading.into_iter().collect(),
            rows: Vec::new(),
            caption: String::new(),
            command: String::new(),
        }
    }

    /// Adds a row.
    pub fn push(&mut self, row: Vec<Cell>) {
        self.rows.push(row);
    }

    /// Sets the caption and the command that makes the table.
    pub fn explained(self, caption: impl Into<String>, command: impl Into<String>) -> Self {
        Self { caption: caption.into(), command: command.into(), ..self }
    }

    pub(super) fn numbers(&self) -> Csv {
        let rows = self.rows.iter().map(|row| row.iter().map(|cell| cell.full.clone()).collect());
        let rows = rows.collect();
        Csv { name: self.name.clone(), heading: self.heading.clone(), rows }
    }

    pub(super) fn markup(&self) -> Markup {
        let numeric = |i: usize| {
            let of_row = |row: &Vec<Cell>| row.get(i).is_some_and(|cell| cell.number.is_some());
            self.rows.iter().any(of_row)
        };
        html! {
            @if self.heading.len() > WIDE { p.more { "Scroll sideways for all columns." } }
            div.scroll {
                table {
                    thead { tr {
                        @for (i, name) in self.heading.iter().enumerate() {
                            th scope="col" class=(if numeric(i) { "number" } else { "" }) { (name) }
                        }
                    } }
                    tbody {
                        @for row in &self.rows { tr { @for cell in row { (cell.markup()) } } }
                    }
                }
            }
        }
    }
}
