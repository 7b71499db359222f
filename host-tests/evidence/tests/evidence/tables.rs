//! The command `tables`, and the committed tables and pages.

use std::fs;
use std::path::{Path, PathBuf};

use crate::evidence;

const EVIDENCE: &str = include_str!("../../../EVIDENCE.md");

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files of the tables with this ending.
fn files(ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(package().join("tables")).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        paths.filter(|path| path.extension().unwrap() == ending).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

/// EVIDENCE.md and the pages of the tables, each with its folder.
fn pages() -> Vec<(PathBuf, String)> {
    let pages = files("md").into_iter().chain([package().join("../EVIDENCE.md")]);
    let read =
        |path: PathBuf| (path.parent().unwrap().to_owned(), fs::read_to_string(path).unwrap());
    pages.map(read).collect()
}

#[test]
fn the_quick_cases_are_what_they_measure() {
    let text = evidence(&["tables", "--check", "--quick"]).stdout();
    assert!(text.lines().count() >= 8, "{text}");
}

#[test]
fn a_planted_difference_fails() {
    let dir = tempfile::tempdir().unwrap();
    let table = fs::read_to_string(package().join("tables/garbage.csv")).unwrap();
    let planted = table.replace("20 wrong matches a pair,0.0000", "20 wrong matches a pair,0.0300");
    assert_ne!(planted, table);
    fs::write(dir.path().join("garbage.csv"), planted).unwrap();
    let check = ["tables", "garbage", "--check", "--quick", "--dir", dir.path().to_str().unwrap()];
    let error = evidence(&check).failure(1);
    assert!(error.contains("garbage, 20 wrong matches a pair, ever locked: 0.0300"), "{error}");
}

#[test]
fn a_table_is_written_below_its_words() {
    let dir = tempfile::tempdir().unwrap();
    let page = dir.path().join("recorded.md");
    fs::write(&page, "# Words\n\nstay.\n\n| old |\n").unwrap();
    let text = evidence(&["tables", "recorded", "--dir", dir.path().to_str().unwrap()]).stdout();
    assert_eq!(text, "recorded: written\n");
    let written = fs::read_to_string(dir.path().join("recorded.csv")).unwrap();
    assert_eq!(written, fs::read_to_string(package().join("tables/recorded.csv")).unwrap());
    let page = fs::read_to_string(page).unwrap();
    assert!(page.starts_with("# Words\n\nstay.\n\n| case | pairs |"), "{page}");
}

#[test]
fn every_table_and_picture_is_shown_and_every_page_has_its_table() {
    for file in files("csv") {
        let page = fs::read_to_string(file.with_extension("md")).unwrap();
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(&file).unwrap();
        for (i, record) in reader.records().enumerate() {
            let line = record.unwrap().iter().collect::<Vec<_>>().join(" | ");
            assert!(page.contains(&format!("| {line} |\n")), "{} row {i}", file.display());
        }
    }
    for file in files("md").into_iter().chain(files("svg")) {
        let name = file.file_name().unwrap().to_str().unwrap();
        assert!(EVIDENCE.contains(&format!("(evidence/tables/{name})")), "{name}");
    }
    assert_eq!(files("svg").len(), 5);
    assert!(EVIDENCE.lines().count() <= 150);
}

#[test]
fn links_lead_to_files_and_commands_are_known() {
    for (folder, page) in pages() {
        for link in page.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let file = link.split('#').next().unwrap();
            assert!(folder.join(file).exists(), "{link}");
        }
        let code = page.split('`').skip(1).step_by(2);
        let code = code.map(|code| code.split_whitespace().collect::<Vec<_>>().join(" "));
        for call in code.filter_map(|code| code.strip_prefix("cargo evidence ").map(str::to_owned))
        {
            let call = call.replace("NAME", "single");
            let arguments: Vec<&str> = call.split_whitespace().chain(["--help"]).collect();
            evidence(&arguments).stdout();
        }
    }
}

#[test]
fn the_means_of_the_matcher_are_what_it_measures() {
    let text = evidence(&["matcher"]).stdout();
    let means = text.trim_end().rsplit_once("over SIFT ").unwrap().1;
    let [t, r] = <[&str; 2]>::try_from(means.split(", ").collect::<Vec<_>>()).unwrap();
    let page = fs::read_to_string(package().join("tables/images.md")).unwrap();
    assert!(page.contains(&format!("15 views: `e_t` {t}, `e_R` {r} times")), "{text}");
}
