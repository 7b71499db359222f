//! The documentation against manifest and code.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

const MANIFEST: &str = include_str!("../../../Cargo.toml");
const CRATE: &str = include_str!("../../../src/lib.rs");
const DERIVATION: &str =
    concat!(include_str!("../../../ESTIMATOR.md"), include_str!("../../../docs/code.md"));
const README: &str = include_str!("../../../README.md");

#[test]
fn every_feature_is_in_the_table() {
    let features = MANIFEST.split("[features]").nth(1).unwrap().split("\n[").next().unwrap();
    let names = features.lines().filter_map(|line| line.split_once(" = ")).map(|(name, _)| name);
    for name in names.filter(|name| *name != "default") {
        assert!(CRATE.contains(&format!("//! | `{name}`")), "{name}");
    }
}

#[test]
fn the_rust_version_matches_the_manifest() {
    let stated = format!("Minimum supported Rust version: {}.", env!("CARGO_PKG_RUST_VERSION"));
    assert!(CRATE.contains(&stated) && README.contains(&stated), "{stated}");
}

#[test]
fn every_test_that_the_derivation_names_exists() {
    let tests = sources(Path::new(env!("CARGO_MANIFEST_DIR")));
    let mut names = 0;
    for quoted in DERIVATION.split('`').skip(1).step_by(2) {
        let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        let name = quoted.trim_end_matches("...");
        if name.chars().all(is_name) && name.matches('_').count() >= 3 {
            assert!(tests.contains(&format!("fn {name}")), "{quoted}");
            names += 1;
        }
    }
    assert!(names > 20, "{names}");
}

#[test]
fn every_name_in_the_table_of_symbols_exists() {
    let code = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    let words: HashSet<&str> = code.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let (_, rows) = DERIVATION.split_once("| name in the code |\n|---|---|---|---|\n").unwrap();
    let cells = rows.lines().take_while(|row| row.starts_with('|'));
    let cells = cells.map(|row| row.trim_end_matches(" |").rsplit(" | ").next().unwrap());
    let spans = cells.flat_map(|cell| cell.split('`').skip(1).step_by(2));
    let names: Vec<_> = spans.filter(|span| !span.contains('^')).collect();
    assert!(names.len() > 20, "{names:?}");
    for name in names {
        assert!(name.split("::").all(|part| words.contains(part)), "{name}");
    }
}

/// A path of the derivation is relative to `core/src` or to the root of the project; `{one,other}` stands for both.
#[test]
fn every_file_that_the_derivation_names_exists() {
    let core = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = 0;
    for quoted in DERIVATION.split('`').skip(1).step_by(2) {
        let Some(path) = quoted.strip_suffix(".rs") else { continue };
        let (before, names) = path.split_once('{').unwrap_or((path, ""));
        for name in names.trim_end_matches('}').split(',') {
            let file = format!("{before}{name}.rs");
            let exists =
                core.join("src").join(&file).exists() || core.join("..").join(&file).exists();
            assert!(exists, "{file}");
            files += 1;
        }
    }
    assert!(files > 50, "{files}");
}

/// The text of all Rust files in a folder and in its subfolders, except `target`.
fn sources(folder: &Path) -> String {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of = |path: PathBuf| match path.extension() {
        Some(extension) if extension == "rs" => fs::read_to_string(path).unwrap(),
        _ if path.is_dir() && !path.ends_with("target") => sources(&path),
        _ => String::new(),
    };
    entries.map(of).collect()
}
