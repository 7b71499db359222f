//! Pages and their sections.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use super::figure::Figure;
use super::html;
use super::numbers::Csv;
use super::table::Table;

/// A page of evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Over the page and in the window's bar.
    pub title: String,
    /// What it says, in a few sentences.
    pub lead: String,
    /// In the order of the page.
    pub sections: Vec<Section>,
}

/// A part of a page, with a place in its contents.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// In order.
    pub blocks: Vec<Block>,
}

/// What a section is made of.
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
        /// Of the file.
        name: String,
        /// What is in it.
        text: String,
    },
}

impl Page {
    /// Without sections yet.
    #[must_use]
    pub fn new(title: impl Into<String>, lead: impl Into<String>) -> Self {
        Self { title: title.into(), lead: lead.into(), sections: Vec::new() }
    }

    /// The whole page.
    #[must_use]
    pub fn html(&self) -> String {
        html::page(self).into_string()
    }

    /// Writes `index.html` and `csv/*.csv` into a folder, which is made; files of theirs there are
    /// replaced. Returns where the page is.
    ///
    /// # Errors
    /// If two tables or figures have one name, or a file cannot be written: names it.
    pub fn write(&self, dir: &Path) -> Result<PathBuf> {
        let mut all: Vec<Csv> = self.sections.iter().flat_map(Section::numbers).collect();
        all.sort_by(|a, b| a.name.cmp(&b.name));
        for two in all.windows(2) {
            ensure!(two[0].name != two[1].name, "{} is written twice", two[0].link());
        }
        fs::create_dir_all(dir).with_context(|| format!("cannot make {}", dir.display()))?;
        for numbers in &all {
            numbers.write(dir)?;
        }
        let path = dir.join("index.html");
        fs::write(&path, self.html())
            .with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    }
}

impl Section {
    /// With nothing in it yet.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), blocks: Vec::new() }
    }

    /// One more paragraph.
    pub fn text(&mut self, words: impl Into<String>) {
        self.blocks.push(Block::Text(words.into()));
    }

    /// One more paragraph that must not be overlooked.
    pub fn alarm(&mut self, words: impl Into<String>) {
        self.blocks.push(Block::Alarm(words.into()));
    }

    /// One more table.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }

    /// One more figure.
    pub fn figure(&mut self, figure: Figure) {
        self.blocks.push(Block::Figure(figure));
    }

    /// One more file.
    pub fn listing(&mut self, name: impl Into<String>, text: impl Into<String>) {
        self.blocks.push(Block::Listing { name: name.into(), text: text.into() });
    }

    fn numbers(&self) -> impl Iterator<Item = Csv> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Text(_) | Block::Alarm(_) | Block::Listing { .. } => None,
            Block::Table(table) => Some(table.numbers()),
            Block::Figure(figure) => Some(figure.numbers.clone()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Cell, Picture};

    fn table(name: &str) -> Table {
        let mut table = Table::new(name, ["data".into(), "e_t, rad".into()]);
        table.push(vec![Cell::text("a <b>"), Cell::number(1.0 / 3.0, 2).best()]);
        table.push(vec![Cell::text("c"), Cell::missing("failed", "no estimate")]);
        table.explained("What it is.", "selfcal evaluate")
    }

    fn figure(name: &str) -> Figure {
        let svg = "<svg width=\"3\" height=\"2\"><g/></svg>";
        let mut numbers = Csv::new(name, &["x"]);
        numbers.push(["1".into()]);
        Figure {
            panels: vec![
                (Picture::Svg(svg.into()), "drawn".into()),
                (Picture::Png(vec![1, 2, 3]), "photographed".into()),
            ],
            legend: Vec::new(),
            caption: "What it shows.".into(),
            command: "selfcal draw".into(),
            numbers,
        }
    }

    fn page(blocks: Vec<Block>) -> Page {
        let section = Section { title: "Errors".into(), blocks };
        Page { sections: vec![section], ..Page::new("Evidence", "It holds.") }
    }

    #[test]
    fn tables_and_figures_have_caption_command_and_numbers() {
        let html = page(vec![Block::Table(table("t")), Block::Figure(figure("f"))]).html();
        for part in [
            "What it is.",
            "<code>selfcal evaluate</code>",
            "href=\"csv/t.csv\"",
            "What it shows.",
            "<code>selfcal draw</code>",
            "href=\"csv/f.csv\"",
            "viewBox=\"0 0 3 2\"",
            "data:image/png;base64,AQID",
            "a &lt;b&gt;",
        ] {
            assert!(html.contains(part), "{part} is missing:\n{html}");
        }
    }

    #[test]
    fn nothing_is_loaded_from_elsewhere() {
        let html = page(vec![Block::Table(table("t")), Block::Figure(figure("f"))]).html();
        for loading in ["src=\"http", "href=\"http", "url(", "@import", "<link"] {
            assert!(!html.contains(loading), "{loading}");
        }
    }

    #[test]
    fn numbers_are_written_in_full_beside_the_page() {
        let dir = tempfile::tempdir().unwrap();
        let page = page(vec![Block::Table(table("t")), Block::Figure(figure("f"))]);
        for _ in 0..2 {
            let path = page.write(&dir.path().join("new")).unwrap();
            assert_eq!(fs::read_to_string(path).unwrap(), page.html());
        }
        let csv = fs::read_to_string(dir.path().join("new/csv/t.csv")).unwrap();
        let third = "0.3333333333333333";
        assert_eq!(csv, format!("data,\"e_t, rad\"\na <b>,{third}\nc,failed: no estimate\n"));
    }

    #[test]
    fn two_of_one_name_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let twice = page(vec![Block::Table(table("t")), Block::Figure(figure("t"))]);
        let error = twice.write(dir.path()).unwrap_err().to_string();
        assert!(error.contains("csv/t.csv"), "{error}");
    }
}
