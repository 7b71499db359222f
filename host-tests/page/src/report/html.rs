//! The page as HTML: style and script inside.

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::figure::Figure;
use super::inline::variable;
use super::numbers::Csv;
use super::page::{Block, Page, Section};
use super::table::Table;
use crate::chart::palette::{Color, Rgb, SERIES};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

impl Page {
    /// The whole page.
    pub fn html(&self) -> String {
        page(self).into_string()
    }

    /// Writes `index.html` and `csv/*.csv` into a folder, which is made; earlier files of these names are replaced.
    /// Returns the path of the page.
    ///
    /// # Errors
    /// If two tables or figures have the same name, or a file cannot be written: names it.
    pub fn write(&self, dir: &Path) -> Result<PathBuf> {
        let mut all: Vec<Csv> = self.sections.iter().flat_map(Section::numbers).collect();
        all.sort_by(|a, b| a.name.cmp(&b.name));
        for two in all.windows(2) {
            ensure!(two[0].name != two[1].name, "{} is written twice", two[0].link());
        }
        for numbers in &all {
            numbers.write(dir)?;
        }
        let path = dir.join("index.html");
        crate::write(&path, &self.html())?;
        Ok(path)
    }
}

fn page(page: &Page) -> Markup {
    let light = variables(|color| color.light);
    let dark = variables(|color| color.dark);
    let colors =
        format!(":root{{{light}}}\n@media (prefers-color-scheme:dark){{:root{{{dark}}}}}\n");
    let mut count = Count::default();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (page.title) }
                style { (PreEscaped(colors)) (PreEscaped(STYLE)) }
            }
            body {
                header { h1 { (page.title) } p.lead { (page.lead) } }
                nav aria-label="Contents" {
                    ol {
                        @for (i, section) in page.sections.iter().enumerate() {
                            li { a href=(format!("#{}", anchor(i))) { (section.title) } }
                        }
                    }
                }
                main {
                    @for (i, section) in page.sections.iter().enumerate() {
                        (self::section(&anchor(i), section, &mut count))
                    }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

/// The colours of all series, for one scheme of the page.
fn variables(of: fn(&Color) -> Rgb) -> String {
    let named = |(i, color)| format!("{}:{}", variable(i), of(color).hex());
    SERIES.iter().enumerate().map(named).collect::<Vec<_>>().join(";")
}

fn anchor(section: usize) -> String {
    format!("section-{}", section + 1)
}

/// Tables and figures so far, each numbered through the page.
#[derive(Default)]
struct Count {
    tables: usize,
    figures: usize,
}

fn section(id: &str, section: &Section, count: &mut Count) -> Markup {
    html! {
        section id=(id) {
            h2 { (section.title) }
            @for block in &section.blocks {
                @match block {
                    Block::Text(words) => p { (words) },
                    Block::Alarm(words) => p.alarm { (words) },
                    Block::Table(table) => (self::table(table, count)),
                    Block::Figure(figure) => (self::figure(figure, count)),
                    Block::Listing { name, text } => {
                        details { summary { code { (name) } } pre { code { (text) } } }
                    },
                }
            }
        }
    }
}

fn table(table: &Table, count: &mut Count) -> Markup {
    count.tables += 1;
    let title = format!("Table {}", count.tables);
    let link = table.numbers().link();
    html! {
        figure.table id=(format!("table-{}", table.name)) {
            (caption(&title, &table.caption, &table.command, &link))
            (table.markup())
        }
    }
}

fn figure(figure: &Figure, count: &mut Count) -> Markup {
    count.figures += 1;
    let title = format!("Figure {}", count.figures);
    html! {
        figure id=(format!("figure-{}", figure.numbers.name)) {
            (figure.markup())
            (caption(&title, &figure.caption, &figure.command, &figure.numbers.link()))
        }
    }
}

fn caption(title: &str, caption: &str, command: &str, link: &str) -> Markup {
    html! {
        figcaption {
            b { (title) ". " } (caption)
            span.made { code { (command) } " " a href=(link) { "numbers (CSV)" } }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::report::{Cell, Picture};

    fn table(name: &str) -> Table {
        let mut table = Table::new(name, ["data".into(), "e_t, rad".into()]);
        table.push(vec![Cell::text("a <b>"), Cell::number(1.0 / 3.0, 2).best()]);
        table.push(vec![Cell::text("c"), Cell::missing("failed", "no estimate")]);
        table.explained("Its description.", "selfcal evaluate")
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
            caption: "Its content.".into(),
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
            "Its description.",
            "<code>selfcal evaluate</code>",
            "href=\"csv/t.csv\"",
            "Its content.",
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
    fn two_tables_of_one_name_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let twice = page(vec![Block::Table(table("t")), Block::Figure(figure("t"))]);
        let error = twice.write(dir.path()).unwrap_err().to_string();
        assert!(error.contains("csv/t.csv"), "{error}");
    }
}
