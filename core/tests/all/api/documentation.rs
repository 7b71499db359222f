//! The crate documentation against the manifest.

const MANIFEST: &str = include_str!("../../../Cargo.toml");
const CRATE: &str = include_str!("../../../src/lib.rs");
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
