//! The command as a user runs it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use host_tests::dataset::Dataset;

/// An empty folder.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> (Output, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_firmware-sim"));
    let output = command.current_dir(folder).args(arguments).output().unwrap();
    let [out, err] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8(bytes.clone()).unwrap());
    (output, out, err)
}

#[test]
fn without_arguments_it_plays_the_chessboard_sift_set_and_plots() {
    let folder = folder("no_arguments");
    let (output, out, err) = run(&folder, &[]);
    assert_eq!(output.status.code(), Some(0), "{err}");
    assert!(out.contains("opencv_chess_sift: 13 pairs, 2781 matches"), "{out}");
    assert!(out.contains("Applied, generation 1: p_r = R p_l + t"), "{out}");
    let svg = fs::read_to_string(folder.join("target/firmware-sim/opencv_chess_sift.svg"));
    assert!(svg.unwrap().ends_with("</svg>\n"));
    assert_eq!(err, "");
}

#[test]
fn matches_beyond_capacity_are_counted() {
    let folder = folder("beyond_capacity");
    let (output, out, err) = run(&folder, &["aloe_sift", "--plot", "a/b.svg"]);
    assert_eq!(output.status.code(), Some(0), "{err}");
    assert!(out.contains("432 of 944 matches not taken"), "{out}");
    assert!(folder.join("a/b.svg").exists());
}

#[test]
fn an_unknown_data_set_is_refused_with_the_names_of_the_known_ones() {
    let (output, out, err) = run(&folder("unknown"), &["nowhere"]);
    assert_eq!((output.status.code(), out.as_str()), (Some(1), ""));
    assert!(err.starts_with("error: nowhere") && err.contains("opencv_chess_corners"), "{err}");
}

#[test]
fn without_an_estimate_it_plots_and_says_so_and_fails() {
    let folder = folder("no_estimate");
    let mut set = Dataset::load(&Dataset::shipped().join("opencv_chess_corners")).unwrap();
    set.pairs.iter_mut().for_each(|pair| pair.truncate(5));
    set.save(&folder.join("sparse")).unwrap();
    let (output, out, err) = run(&folder, &["sparse"]);
    assert_eq!(output.status.code(), Some(1), "{out}");
    assert!(out.contains("not solved: 5 usable correspondences, 12 needed"), "{out}");
    assert!(err.contains("no pair has been fused"), "{err}");
    assert!(folder.join("target/firmware-sim/sparse.svg").exists());
}
