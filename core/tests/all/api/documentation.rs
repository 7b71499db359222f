//! The documentation against manifest and code.

use std::fs;
use std::path::{Path, PathBuf};

const MANIFEST: &str = include_str!("../../../Cargo.toml");
const CRATE: &str = include_str!("../../../src/lib.rs");
const DERIVATION: &str = include_str!("../../../ESTIMATOR.md");
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
