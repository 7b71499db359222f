//! A page of evidence: one HTML file with its pictures inside, and a CSV file for each table and each figure.
//!
//! A page has sections; a section has paragraphs, tables and figures. A table or a figure comes with a caption, the
//! command that reproduces it, and its numbers. The page loads nothing.

mod figure;
mod html;
mod inline;
mod numbers;
mod page;
mod table;

pub use crate::chart::legend::Mark;
pub use figure::{Entry, Figure, Picture};
pub use inline::inline;
pub use numbers::Csv;
pub use page::{Block, Page, Section};
pub use table::{Cell, Table};
