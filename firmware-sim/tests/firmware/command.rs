//! The command line.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rigs::data::Dataset;

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
fn without_arguments_it_replays_the_chessboard_sift_set_and_plots() {
    let folder = folder("no_arguments");
    let (output, out, err) = run(&folder, &[]);
    assert_eq!(output.status.code(), Some(0), "{err}");
    assert!(out.contains("opencv_chess_sift: 13 pairs, 2781 matches"), "{out}");
    assert!(out.contains("Applied, generation 1: p_r = R p_l + t"), "{out}");
    // The verdict is about the extrinsics of the start, the last lines about the applied ones.
    assert!(out.contains("may arm            no: rows"), "{out}");
    assert!(out.contains("px RMS in use"), "{out}");
    let svg = fs::read_to_string(folder.join("target/firmware-sim/opencv_chess_sift.svg"));
    assert!(svg.unwrap().ends_with("</svg>\n"));
    assert_eq!(err, "");
}

#[test]
fn an_estimate_that_is_not_locked_is_shown_with_the_reason_and_not_applied() {
    let (output, out, err) = run(&folder("one_pair"), &["motorcycle_sift"]);
    assert_eq!(output.status.code(), Some(0), "{err}");
    assert!(out.contains("Not applied: the estimate is acquiring, not locked"), "{out}");
    assert!(out.contains("R = [") && out.contains("no: not locked"), "{out}");
    assert!(!out.contains("depth error"), "{out}");
}

#[test]
fn changes_of_the_state_are_printed() {
    let (_, out, _) = run(&folder("state"), &["opencv_chess_corners"]);
    assert!(out.contains("acquiring -> locked"), "{out}");
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
fn without_an_estimate_it_plots_and_fails_with_the_reason() {
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

#[test]
fn a_flight_prints_its_changes_and_its_outcome_and_plots() {
    let folder = folder("flight");
    let flight = ["flight", "--pairs", "60", "--baseline", "0.2", "--plot", "a/b.svg"];
    let (output, out, err) = run(&folder, &flight);
    assert_eq!((output.status.code(), err.as_str()), (Some(0), ""), "{out}");
    let said = ["0.2 m baseline", "acquiring", "the right camera is knocked", "took over"];
    for part in said.into_iter().chain(["final error in use", "row offset in use"]) {
        assert!(out.contains(part), "{part}: {out}");
    }
    let svg = fs::read_to_string(folder.join("a/b.svg")).unwrap();
    assert!(svg.contains("knocked by 0.3° at pair 30") && svg.ends_with("</svg>\n"));
    assert_eq!(run(&folder, &flight).1, out, "not the same flight for the same seed");
}

#[test]
fn a_flight_with_an_invalid_option_is_refused_by_its_name() {
    let folder = folder("no_flight");
    for (option, bad) in [
        ("--pairs", "1"),
        ("--baseline", "0"),
        ("--baseline", "-1"),
        ("--knock", "nan"),
        ("--seed", "x"),
    ] {
        let (output, out, err) = run(&folder, &["flight", option, bad]);
        assert_eq!((output.status.code(), out.as_str()), (Some(2), ""), "{option} {bad}");
        assert!(err.contains(option), "{err}");
    }
    assert_eq!(run(&folder, &["opencv_chess_sift", "flight"]).0.status.code(), Some(2));
}

#[test]
fn a_flight_that_does_not_end_locked_plots_and_fails_with_the_reason() {
    let folder = folder("short_flight");
    let (output, out, err) = run(&folder, &["flight", "--pairs", "2"]);
    assert_eq!(output.status.code(), Some(1), "{out}");
    assert!(err.contains("the flight ends acquiring, not locked"), "{err}");
    assert!(folder.join("target/firmware-sim/flight.svg").exists());
}

#[test]
fn in_the_loop_a_missing_image_or_qemu_is_named() {
    let folder = folder("in_the_loop");
    let (output, _, err) = run(&folder, &["pil", "--image", "none.elf"]);
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(err.contains("there is no image none.elf"), "{err}");

    fs::write(folder.join("some.elf"), "").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_firmware-sim"));
    // A path without QEMU.
    command.current_dir(&folder).env("PATH", &folder).args(["pil", "--image", "some.elf"]);
    let output = command.output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(err.contains(".ci/install-toolchain"), "{err}");
}

/// Runs `pil` with a script in place of QEMU, and a timeout of one second.
#[cfg(unix)]
fn with_qemu(folder: &Path, script: &str) -> (Option<i32>, String, String) {
    use std::os::unix::fs::PermissionsExt;
    let qemu = folder.join("qemu-system-arm");
    fs::write(&qemu, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&qemu, fs::Permissions::from_mode(0o755)).unwrap();
    fs::write(folder.join("some.elf"), "").unwrap();
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap());
    let mut command = Command::new(env!("CARGO_BIN_EXE_firmware-sim"));
    command.args(["pil", "--image", "some.elf", "--timeout", "1"]);
    let output = command.current_dir(folder).env("PATH", path).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[cfg(unix)]
#[test]
fn in_the_loop_one_bit_that_differs_fails_and_names_the_first_pair() {
    use firmware_sim::recording::{FRAMES, factory};
    let mut controller = Box::new(firmware_sim::start(factory().unwrap().cameras));
    let mut checksums = Vec::new();
    firmware_sim::checksums(FRAMES, &mut controller, |checksum| checksums.push(checksum)).unwrap();
    let run = |checksums: &[u32]| {
        let lines: Vec<String> =
            checksums.iter().map(|checksum| format!("{checksum:08x}")).collect();
        with_qemu(&folder("checksums"), &format!("printf '{}\\n'", lines.join("\\n")))
    };
    let (code, out, err) = run(&checksums);
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("13 of 13 pairs are bit-identical"), "{out}");

    let mut different = checksums.clone();
    different[7] ^= 1;
    different[9] ^= 1;
    let (code, out, err) = run(&different);
    assert_eq!(code, Some(1));
    assert!(out.contains("DIFFER pair 7\n") && err.contains("first in pair 7"), "{out}{err}");

    let mut at_the_end = checksums.clone();
    at_the_end[13] ^= 1;
    assert!(run(&at_the_end).2.contains("first in the applied calibration"));
    let (code, _, err) = run(&checksums[..5]);
    assert_eq!(code, Some(1));
    assert!(err.contains("printed 5 checksums instead of 14"), "{err}");
}

#[cfg(unix)]
#[test]
fn in_the_loop_a_qemu_that_fails_or_hangs_is_reported() {
    let (code, _, err) = with_qemu(&folder("short_qemu"), "exit 3");
    assert_eq!(code, Some(1));
    assert!(err.contains("exit status: 3"), "{err}");

    let folder = folder("late_qemu");
    let (code, _, err) = with_qemu(&folder, "echo $$ > pid; exec sleep 600");
    assert_eq!(code, Some(1));
    assert!(err.contains("has not ended after 1s"), "{err}");
    let pid = fs::read_to_string(folder.join("pid")).unwrap();
    let alive = Command::new("kill").args(["-0", pid.trim()]).output().unwrap();
    assert!(!alive.status.success(), "it still runs");
}

#[test]
fn in_the_loop_an_invalid_option_is_refused_by_its_name() {
    let folder = folder("in_no_loop");
    for (option, bad) in [("--board", "mps3"), ("--timeout", "0"), ("--timeout", "1.5")] {
        let (output, out, err) = run(&folder, &["pil", option, bad]);
        assert_eq!((output.status.code(), out.as_str()), (Some(2), ""), "{option} {bad}");
        assert!(err.contains(option), "{err}");
    }
    let (_, _, err) = run(&folder, &["pil", "nowhere", "--image", "none.elf"]);
    assert!(err.contains("nowhere does not exist"), "{err}");
}

#[test]
fn the_help_covers_every_command() {
    let folder = folder("help");
    let (_, out, _) = run(&folder, &["--help"]);
    assert!(out.contains("cargo run -- flight") && out.contains("DATASET"), "{out}");
    let (_, out, _) = run(&folder, &["flight", "--help"]);
    assert!(out.contains("--baseline") && out.contains("Exit status"), "{out}");
    let (_, out, _) = run(&folder, &["pil", "--help"]);
    assert!(out.contains("m4f, m7") && out.contains("Exit status"), "{out}");
}
