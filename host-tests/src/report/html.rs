//! The page as HTML: style and script inside.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::figure::Figure;
use super::page::{Block, Page, Section};
use super::palette;
use super::table::Table;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

pub(super) fn page(page: &Page) -> Markup {
    let light = palette::variables(|color| color.light);
    let dark = palette::variables(|color| color.dark);
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
