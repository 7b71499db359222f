//! Documents: links, paths, names of tests, commands, and the figures that are quick to reproduce.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use stereo_selfcal::{Calibrator, FactoryCalibration};
use test_support::document::code;

use crate::call::selfcal;

const README: &str = include_str!("../../../../README.md");
const CRATE: &str = include_str!("../../../../core/docs/crate.md");
const BY_TESTS: &str = include_str!("../../../evidence/tables/by-tests.md");
const RECORDED: &str = include_str!("../../../evidence/tables/recorded.csv");

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap()
}

/// Adds the files with this extension in a folder and in its subfolders. Hidden folders and builds are left out.
fn add_files(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() && !name.starts_with('.') && name != "target" {
            add_files(&path, extension, found);
        } else if path.extension().is_some_and(|of| of == extension) {
            found.push(path);
        }
    }
}

/// The files of the project with this extension.
fn files(extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for top in [".github", "core", "firmware-sim", "host-tests"] {
        add_files(&root().join(top), extension, &mut found);
    }
    found
}

/// The documents, each with the folder that its links start from. Changes name files that are gone.
fn documents() -> Vec<(PathBuf, String)> {
    let of_the_root = Some(root().join("README.md"));
    let all = files("md").into_iter().chain(of_the_root);
    let all = all.filter(|path| !path.ends_with("CHANGELOG.md"));
    all.map(|path| (path.parent().unwrap().into(), fs::read_to_string(&path).unwrap())).collect()
}

fn all_code() -> Vec<String> {
    documents().iter().flat_map(|(_, document)| code(document)).collect()
}

fn commands(start: &str) -> Vec<String> {
    let all = all_code().into_iter();
    let found: Vec<_> = all.filter_map(|c| c.strip_prefix(start).map(str::to_owned)).collect();
    assert!(!found.is_empty(), "no `{start}`");
    found
}

#[test]
fn links_and_paths_lead_to_files_of_the_repository() {
    let mut wrong = Vec::new();
    for (folder, document) in documents() {
        for link in document.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let target = folder.join(link.split('#').next().unwrap());
            if !link.starts_with("https://") && !target.exists() {
                wrong.push(format!("{}: {link}", folder.display()));
            }
        }
    }
    let roots = ["core/", "firmware-sim/", "host-tests/", ".ci/", ".cargo/"];
    for span in all_code() {
        let path = span.split(' ').next().unwrap();
        let ours = roots.iter().any(|root| path.starts_with(root));
        if ours && !alternatives(path).iter().all(|path| root().join(path).exists()) {
            wrong.push(path.to_owned());
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The paths that a path with `{one,other}` stands for.
fn alternatives(path: &str) -> Vec<String> {
    let Some((before, (inner, after))) =
        path.split_once('{').and_then(|(before, rest)| Some((before, rest.split_once('}')?)))
    else {
        return vec![path.into()];
    };
    inner.split(',').map(|one| format!("{before}{one}{after}")).collect()
}

/// A code span of lower case words that five or more `_` join is the name of a test, or its beginning, `...` and its
/// end.
#[test]
fn named_tests_exist() {
    let sources: String =
        files("rs").iter().map(|file| fs::read_to_string(file).unwrap()).collect();
    let tests: Vec<&str> = sources
        .lines()
        .filter_map(|line| line.trim_start().strip_prefix("fn ")?.split('(').next())
        .collect();
    let is_of_a_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_.".contains(c);
    let named: Vec<_> = all_code()
        .into_iter()
        .filter(|span| span.matches('_').count() >= 5 && span.chars().all(is_of_a_name))
        .collect();
    assert!(named.len() > 50, "{named:?}");
    for name in named {
        let found = match name.split_once("...") {
            Some((start, end)) => {
                tests.iter().any(|test| test.starts_with(start) && test.ends_with(end))
            }
            None => tests.contains(&name.as_str()),
        };
        assert!(found, "no test `{name}`");
    }
}

#[test]
fn the_documents_name_every_feature_and_the_oldest_rust() {
    let manifest = fs::read_to_string(root().join("core/Cargo.toml")).unwrap();
    let features = manifest.split_once("[features]\n").unwrap().1.split("\n[").next().unwrap();
    let lines = features.lines().filter(|line| !line.starts_with('#'));
    for feature in lines.filter_map(|line| line.split_once(" = ").map(|(name, _)| name)) {
        assert!(feature == "default" || CRATE.contains(&format!("`{feature}`")), "{feature}");
    }
    let workspace = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let (_, rust) = workspace.split_once("rust-version = \"").unwrap();
    let rust = rust.split('"').next().unwrap();
    assert!(README.contains(&format!("Rust {rust} or later")), "{rust}");
}

#[test]
fn selfcal_knows_the_commands_of_the_documents() {
    for call in commands("cargo selfcal ") {
        let call = call
            .split(" #")
            .next()
            .unwrap()
            .replace("NAME", "opencv_chess_sift")
            .replace("SCENE", "near");
        let call = call.replace("[--view top]", "--view top").replace("PRESET", "robust");
        let arguments: Vec<&str> = call.split_whitespace().chain(["--help"]).collect();
        selfcal(&arguments).stdout();
    }
}

#[test]
fn cargo_knows_the_tests_and_benches_of_the_documents() {
    for call in commands("cargo test -p ").into_iter().chain(commands("cargo bench -p ")) {
        let mut words = call.split(" -- ").next().unwrap().split(' ');
        let mut folder = root().join(match words.next().unwrap() {
            "stereo-selfcal" => "core".into(),
            "stereo-selfcal-capi" => "core/capi".into(),
            package => format!("host-tests/{package}"),
        });
        let mut filter = None;
        while let Some(word) = words.next() {
            match word {
                "--release" => (),
                "--features" => drop(words.next()),
                "--test" => folder = folder.join("tests").join(words.next().unwrap()),
                "--bench" => folder = folder.join("benches").join(words.next().unwrap()),
                word => filter = Some(word),
            }
        }
        let mut files = Vec::new();
        add_files(&folder, "rs", &mut files);
        files.extend(Some(folder.with_extension("rs")).filter(|file| file.exists()));
        assert!(!files.is_empty(), "{call}");
        let Some(filter) = filter else { continue };
        let names = |line: &str| line.trim_start().starts_with("fn ") && line.contains(filter);
        let found = files.iter().any(|file| {
            let named =
                file.file_stem().is_some_and(|stem| stem.to_string_lossy().contains(filter));
            named || fs::read_to_string(file).unwrap().lines().any(names)
        });
        assert!(found, "no test for: {call}");
    }
}

/// Whether `value` rounds to the number in a cell.
fn shows(cell: &str, value: &Value) -> bool {
    let decimals = cell.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    format!("{:.decimals$}", value.as_f64().unwrap()) == cell
}

#[test]
fn the_rows_of_the_recorded_data_are_what_a_replay_gives() {
    let rows: Vec<Vec<&str>> =
        RECORDED.lines().skip(1).map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 13);
    let fields = [
        "pairs",
        "accepted",
        "e_t",
        "e_theta",
        "sd_translation",
        "sd_rotation",
        "rms_px_before",
        "rms_px_after",
    ];
    for row in rows {
        let arguments: Vec<&str> = ["replay"].into_iter().chain(row[0].split(' ')).collect();
        let json = selfcal(&[&arguments[..], &["--json"]].concat()).stdout();
        let json: Value = serde_json::from_str(&json).unwrap();
        let locked = json["state"].as_str().unwrap().starts_with("locked");
        assert!(shows(row[3], &f64::from(u8::from(locked)).into()), "{}: {locked}", row[0]);
        for (cell, field) in row[1..3].iter().chain(&row[4..]).zip(fields) {
            assert!(shows(cell, &json[field]), "{}, {field}: {cell} is {}", row[0], json[field]);
        }
    }
}

/// The number, with a comma between thousands.
fn bytes(n: usize) -> String {
    if n < 1000 { n.to_string() } else { format!("{},{:03}", n / 1000, n % 1000) }
}

#[test]
fn sizes_match_the_types() {
    let calibrator = bytes(size_of::<Calibrator<f32, 256>>());
    assert!(README.contains(&format!("256 matches a pair: {calibrator} bytes")), "{calibrator}");
    assert!(
        BY_TESTS.contains(&format!("each correspondence | {calibrator} bytes")),
        "{calibrator}"
    );
    let record = bytes(Calibrator::<f32, 256>::SNAPSHOT_BYTES);
    let factory = bytes(FactoryCalibration::<f32>::BYTES);
    assert!(BY_TESTS.contains(&format!("| {record} bytes; {factory} |")), "{record}, {factory}");
}
