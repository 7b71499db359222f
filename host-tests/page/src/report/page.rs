//! Pages and their sections.

use super::figure::Figure;
use super::numbers::Csv;
use super::table::Table;

/// A page of evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Title of the page and of the window.
    pub title: String,
    /// Summary, in a few sentences.
    pub lead: String,
    /// Sections in order.
    pub sections: Vec<Section>,
}

/// A part of a page, with a place in its contents.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// Blocks in order.
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A paragraph that must not be overlooked.
    Alarm(String),
    /// A table.
    Table(Table),
    /// A figure.
    Figure(Figure),
    /// Lines of a file, folded up under its name.
    Listing {
        /// Name of the file.
        name: String,
        /// Its content.
        text: String,
    },
}

impl Page {
    /// A page without sections.
    pub fn new(title: impl Into<String>, lead: impl Into<String>) -> Self {
        Self { title: title.into(), lead: lead.into(), sections: Vec::new() }
    }
}

impl Section {
    /// An empty section.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), blocks: Vec::new() }
    }

    /// Adds a paragraph.
    pub fn text(&mut self, words: impl Into<String>) {
        self.blocks.push(Block::Text(words.into()));
    }

    /// Adds a paragraph that must not be overlooked.
    pub fn alarm(&mut self, words: impl Into<String>) {
        self.blocks.push(Block::Alarm(words.into()));
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }

    /// Adds a figure.
    pub fn figure(&mut self, figure: Figure) {
        self.blocks.push(Block::Figure(figure));
    }

    /// Adds a file.
    pub fn listing(&mut self, name: impl Into<String>, text: impl Into<String>) {
        self.blocks.push(Block::Listing { name: name.into(), text: text.into() });
    }

    pub(super) fn numbers(&self) -> impl Iterator<Item = Csv> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Text(_) | Block::Alarm(_) | Block::Listing { .. } => None,
            Block::Table(table) => Some(table.numbers()),
            Block::Figure(figure) => Some(figure.numbers.clone()),
        })
    }
}
