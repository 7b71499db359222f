//! Matches of many pairs in one file, and on standard input.

use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

use rigs::data::{Dataset, Match};
use serde_json::{Value, json};

use crate::call::{PATH, failure, json, selfcal, stdout};

const SET: &str = "opencv_chess_sift";

/// The rows of pairs as CSV; frame numbers increase in steps, as if a matcher skipped images.
fn by_frame(pairs: &[Vec<Match>]) -> String {
    let mut text = "frame,ul,vl,ur,vr,score\n".to_owned();
    for (frame, pair) in (100..).step_by(7).zip(pairs) {
        for Match { ul, vl, ur, vr, score, .. } in pair {
            writeln!(text, "{frame},{ul},{vl},{ur},{vr},{score}").unwrap();
        }
    }
    text
}

fn shipped() -> Dataset {
    Dataset::load(&Dataset::shipped().join(SET)).unwrap()
}

/// JSON output of a call with this standard input.
fn piped(input: impl Into<Vec<u8>>, args: &[&str]) -> Value {
    serde_json::from_str(&selfcal(args).reading(input).stdout()).unwrap()
}

/// Standard error of a failing call with this standard input.
fn refused(input: impl Into<Vec<u8>>, args: &[&str]) -> String {
    selfcal(args).reading(input).failure(1)
}

#[test]
fn one_file_of_all_pairs_replays_as_the_folder_wherever_it_comes_from() {
    let set = shipped();
    let text = by_frame(&set.pairs);
    let expected = json(&["replay", SET, "--json"]);
    assert_eq!(piped(text.clone(), &["replay", "-", "--rig", SET, "--json"]), expected);
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("set");
    fs::create_dir(&folder).unwrap();
    let file = folder.join("pairs.csv");
    fs::write(&file, &text).unwrap();
    let [folder, file] = [&folder, &file].map(|path| path.to_str().unwrap());
    assert_eq!(json(&["replay", file, "--rig", SET, "--json"]), expected);
    let error = failure(&["replay", file], 1);
    assert!(error.contains("meta.json") && error.contains("--rig"), "{error}");
    fs::copy(Dataset::shipped().join(SET).join("meta.json"), format!("{folder}/meta.json"))
        .unwrap();
    assert_eq!(json(&["replay", file, "--json"]), expected);
    assert_eq!(json(&["replay", folder, "--json"]), expected);
    // Pairs are turned on arrival.
    let turned = ["--view", "left", "--turned", "both", "--json"];
    let expected = json(&[&["replay", SET][..], &turned].concat());
    assert_eq!(piped(text, &[&["replay", "-", "--rig", SET][..], &turned].concat()), expected);
    fs::create_dir(format!("{folder}/pairs")).unwrap();
    assert!(failure(&["replay", folder], 1).contains("both pairs/ and pairs.csv"));
    fs::write(format!("{folder}/rigs.csv"), "").unwrap();
    assert!(failure(&["replay", file], 1).contains("replay its folder"));
}

#[test]
fn lines_trace_and_page_of_a_pipe_match_the_folder() {
    let dir = tempfile::tempdir().unwrap();
    let text = by_frame(&shipped().pairs);
    let place = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let [trace, traced, page] = ["a.csv", "b.csv", "page"].map(place);
    let folder = stdout(&["replay", SET, "--trace", &trace]);
    let args = ["replay", "-", "--rig", SET, "--trace", &traced, "--report", &page];
    let pipe = selfcal(&args).reading(text.clone()).stdout();
    let lines = |text: &str| {
        let lines = text.lines().skip(1).filter(|line| !line.starts_with("page"));
        lines.map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(lines(&folder), lines(&pipe));
    assert_eq!(fs::read(&trace).unwrap(), fs::read(&traced).unwrap());
    assert!(fs::read_to_string(format!("{page}/index.html")).unwrap().contains("standard input"));
    let args = ["replay", "-", "--rig", SET, "--trace", &traced];
    let pipe = selfcal(&args).reading(text).stdout();
    assert_eq!(lines(&folder), lines(&pipe));
    assert_eq!(fs::read(&trace).unwrap(), fs::read(&traced).unwrap());
    assert!(pipe.starts_with("pairs of standard input: "), "{pipe}");
}

#[test]
fn frames_on_standard_input_replay_as_those_of_a_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("flight.scmf");
    let file = path.to_str().unwrap();
    stdout(&["record", SET, file, "--damaged", "0.3", "--seed", "3"]);
    let expected = json(&["replay", file, "--rig", SET, "--json"]);
    assert!(expected["pairs"].as_u64().unwrap() < 13);
    let bytes = fs::read(&path).unwrap();
    let args = ["replay", "-", "--rig", SET, "--json"];
    let output = selfcal(&args).reading(bytes.clone()).ends_with(0);
    assert_eq!(serde_json::from_str::<Value>(&output.out).unwrap(), expected);
    let counters = output.err;
    assert!(counters.contains("whole frames") && counters.contains("checksum"), "{counters}");
    // The stream starts inside a frame, as a log may.
    assert!(piped(&bytes[9..], &args)["pairs"].as_u64().unwrap() > 3);
    assert!(refused(&bytes[..99], &args).contains("not one whole frame in standard input"));
    let other = ["replay", "-", "--rig", "motorcycle_sift"];
    assert!(refused(bytes, &other).contains("640 x 480"));
}

#[test]
fn a_pair_is_solved_before_the_input_ends() {
    let text = by_frame(&shipped().pairs[..3]);
    let mut child = Command::new(PATH)
        .args(["replay", "-", "--rig", SET])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all(text.as_bytes()).unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    // More matches of the last frame may follow, so it is solved at the end of the input.
    assert!(lines.any(|line| line.starts_with("   1 ")));
    drop(input);
    let rest: Vec<String> = lines.collect();
    assert!(rest[0].starts_with("   2 "), "{rest:?}");
    assert!(child.wait().unwrap().success());
}

#[test]
fn bad_input_is_named() {
    let header = "frame,ul,vl,ur,vr,score\n";
    let good = format!("{header}0,100,100,90,100,1\n");
    let args = ["replay", "-", "--rig", SET];
    for (text, said) in [
        (String::new(), "standard input is empty"),
        ("0,100,100,90,100,1\n".into(), "line 1: there is no header"),
        (header.into(), "no matches below the header"),
        ("frame,u,v\n".into(), "line 1: `u` is not one of the columns"),
        ("ul,vl,ur,vr,score\n1,2,3,4,1\n".into(), "no column `frame`"),
        (format!("{good}0,100,100,90\n"), "line 3: 4 fields; the header has 6"),
        (format!("{good}1.0,100,100,90,100,1\n"), "line 3: frame `1.0` is not a whole number"),
        (format!("{good}0,100,inf,90,100,1\n"), "line 3: vl `inf` is not a finite number"),
        (format!("{good}0,100,100,90,100,nan\n"), "line 3: score `nan` is not a finite number"),
        (format!("{good}0,x,100,90,100,1\n"), "line 3: ul `x` is not a finite number"),
        (format!("{good}1,5,5,4,5,1\n\n0,5,5,4,5,1\n"), "line 5: frame 0 continues"),
    ] {
        let error = refused(text, &args);
        assert!(error.contains(said) && error.contains("standard input"), "{error}");
    }
    let error = refused(good, &["replay", "-"]);
    assert!(error.contains("--rig"), "{error}");
    // Errors in files name the line too.
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bad.csv");
    fs::write(&path, format!("{header}0,1,2,3,4,1\n0,1\n")).unwrap();
    let error = failure(&["replay", path.to_str().unwrap(), "--rig", SET], 1);
    assert!(error.contains("bad.csv: line 3: 2 fields"), "{error}");
    fs::write(&path, "").unwrap();
    let error = failure(&["replay", path.to_str().unwrap(), "--rig", SET], 1);
    assert!(error.contains("bad.csv is empty"), "{error}");
}

#[test]
fn refused_matches_are_counted_by_reason() {
    let mut pairs = shipped().pairs;
    let count: usize = pairs.iter().map(Vec::len).sum();
    let m = pairs[0][0];
    pairs[0].extend([
        Match { score: 2.0, ..m },
        Match { score: -1.0, ..m },
        Match { ul: -9.0, ..m },
    ]);
    pairs[5].push(Match { vr: 1e6, ..m });
    let left_out = pairs[7].len() - 3;
    pairs[7].truncate(3);
    let text = by_frame(&pairs);
    let args = ["replay", "-", "--rig", SET];
    let found = piped(text.clone(), &[&args[..], &["--json"]].concat());
    let expected = json!({
        "left_pixel_outside_image": 1, "right_pixel_outside_image": 1, "score": 2
    });
    assert_eq!(found["refused_matches"], expected);
    assert_eq!(found["rejected_pairs"], json!({ "too_few": 1 }));
    assert_eq!(found["matches"], count + 4 - left_out);
    assert_eq!([&found["pairs"], &found["accepted"]], [13, 12]);
    let text = selfcal(&args).reading(text).stdout();
    let words = "\nmatches refused    4 of ";
    assert!(
        text.contains(words) && text.contains(": score 2, left pixel outside image 1,"),
        "{text}"
    );
    assert!(text.contains("\npairs not fused    too few 1\n"), "{text}");
}

#[test]
fn a_long_run_is_thinned_for_its_row_offsets_only() {
    let set = shipped();
    // The run has more matches than are held in memory.
    let pairs: Vec<Vec<Match>> = set.pairs.iter().cycle().take(1400).cloned().collect();
    assert!(pairs.iter().map(Vec::len).sum::<usize>() > 1 << 18);
    let text = by_frame(&pairs);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("long.csv");
    fs::write(&path, text).unwrap();
    let args = ["replay", path.to_str().unwrap(), "--rig", SET, "--capacity", "256"];
    let thinned = json(&[&args[..], &["--json"]].concat());
    assert_eq!([&thinned["pairs"], &thinned["rms_pairs"]], [1400, 700]);
    let folder = dir.path().join("folder");
    Dataset { pairs, ..set }.save(&folder).unwrap();
    let whole = ["replay", folder.to_str().unwrap(), "--capacity", "256", "--json"];
    let whole = json(&whole);
    assert_eq!(whole["rms_pairs"], 1400);
    let number = |of: &Value, name: &str| of[name].as_f64().unwrap();
    for name in ["rms_px_before", "rms_px_after"] {
        let ratio = number(&thinned, name) / number(&whole, name);
        assert!((ratio - 1.0).abs() < 0.01, "{name}: {ratio}");
    }
    for same in ["R", "t", "accepted", "state", "sigma_t", "sigma_pairs", "tracked_t", "locked_at"]
    {
        assert_eq!(thinned[same], whole[same], "{same}");
    }
    let text = stdout(&args);
    assert!(text.contains(" px after, over 700 of 1400 pairs\n"), "{text}");
}

#[test]
fn help_shows_such_a_file() {
    let help = stdout(&["replay", "--help"]);
    assert!(help.contains("selfcal replay - --rig"), "{help}");
    let (_, example) = help.split_once("  frame,ul,vl").unwrap();
    let text: String =
        format!("frame,ul,vl{example}").lines().map(|line| line.trim().to_owned() + "\n").collect();
    let found = refused(text, &["replay", "-", "--rig", SET]);
    assert!(found.contains("none of the 2 pairs could be fused"), "{found}");
}
