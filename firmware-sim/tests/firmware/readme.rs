//! The pictures of the README, and the commands of the simulation in the documents.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use test_support::document::code;

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_firmware-sim"));
    command.current_dir(env!("CARGO_TARGET_TMPDIR")).args(arguments).output().unwrap()
}

#[test]
fn the_picture_of_the_readme_is_the_plot_of_the_replay() {
    let plot = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme.svg");
    let output = run(&["--plot", plot.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0));
    let drawn = fs::read_to_string(plot).unwrap();
    let advice = "cp target/firmware-sim/opencv_chess_sift.svg firmware-sim/";
    assert!(drawn == include_str!("../../opencv_chess_sift.svg"), "the plot has changed: {advice}");
    assert!(drawn.len() < 30_000, "{} bytes", drawn.len());
}

#[test]
fn the_knock_of_the_readme_is_the_plot_of_its_command() {
    let plot = Path::new(env!("CARGO_TARGET_TMPDIR")).join("knock.svg");
    let arguments = ["flight", "--pairs", "40", "--knock", "1", "--plot", plot.to_str().unwrap()];
    assert_eq!(run(&arguments).status.code(), Some(0));
    let drawn = fs::read_to_string(plot).unwrap();
    let advice = "cargo run -- flight --pairs 40 --knock 1 --plot firmware-sim/knock.svg";
    assert!(drawn == include_str!("../../knock.svg"), "the plot has changed: {advice}");
}

#[test]
fn the_commands_of_the_documents_are_known() {
    let documents = [
        include_str!("../../../README.md"),
        include_str!("../../../core/docs/controller.md"),
        include_str!("../../../.github/CONTRIBUTING.md"),
        include_str!("../../../host-tests/EVIDENCE.md"),
    ];
    let code = documents.into_iter().flat_map(code);
    let calls: Vec<_> =
        code.filter_map(|line| line.strip_prefix("cargo run -- ").map(str::to_owned)).collect();
    assert!(calls.len() >= 3, "{calls:?}");
    for call in calls {
        let arguments: Vec<&str> = call.split_whitespace().chain(["--help"]).collect();
        assert_eq!(run(&arguments).status.code(), Some(0), "{call}");
    }
}
