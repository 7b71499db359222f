//! Checks the table of `docs/thresholds.md` against the doc comments of the thresholds. With the environment variable
//! `UPDATE_EXPECT`, writes the table.

extern crate std;

use std::fs;
use std::string::String;
use std::vec::Vec;

const FILES: [&str; 7] = [
    include_str!("geometry.rs"),
    include_str!("pair.rs"),
    include_str!("fusion.rs"),
    include_str!("lens.rs"),
    include_str!("depth.rs"),
    include_str!("outcome.rs"),
    include_str!("paper.rs"),
];

/// Returns the name and value of a line that defines a threshold.
fn defined(line: &str) -> Option<(&str, &str)> {
    let (name, rest) = line.trim_start().strip_prefix("pub(crate) const ")?.split_once(':')?;
    Some((name, rest.split_once(" = ")?.1.trim_end_matches(';')))
}

/// Returns the table in markdown: one row for each doc comment, with the thresholds below it.
fn table() -> String {
    let mut rows = String::from("| threshold | value | meaning |\n|---|---|---|\n");
    for block in FILES.iter().flat_map(|file| file.split("\n\n")) {
        let lines = block.lines().map(str::trim_start);
        let (names, values): (Vec<_>, Vec<_>) = lines.clone().filter_map(defined).unzip();
        if names.is_empty() {
            continue;
        }
        let meaning: Vec<_> = lines.filter_map(|line| line.strip_prefix("/// ")).collect();
        assert!(!meaning.is_empty(), "{names:?} without documentation");
        let names: Vec<_> = names.iter().map(|name| std::format!("`{name}`")).collect();
        let meaning =
            meaning.join(" ").replace("[`crate::", "`").replace("[`", "`").replace("`]", "`");
        let [names, values] = [names.join(", "), values.join(", ")];
        let cells = [names, values, meaning.replace('|', "\\|")].join(" | ");
        rows += &["| ", &cells, " |\n"].concat();
    }
    rows
}

#[test]
fn the_page_has_the_table_of_thresholds() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/thresholds.md");
    let text = fs::read_to_string(path).unwrap();
    let (before, _) = text.split_once("| threshold |").unwrap();
    let table = table();
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(path, [before, &table].concat()).unwrap();
    } else {
        assert_eq!(&text[before.len()..], table, "UPDATE_EXPECT=1 writes it");
    }
}
