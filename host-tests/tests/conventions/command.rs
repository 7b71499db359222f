//! The commands `selfcal import` and `selfcal export`.

use assert_cmd::Command;

fn selfcal(args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("selfcal").unwrap().args(args).assert()
}

fn stderr(of: &assert_cmd::assert::Assert) -> String {
    String::from_utf8(of.get_output().stderr.clone()).unwrap()
}

#[test]
fn a_calibrated_rig_goes_out_and_starts_the_next_run_where_this_one_ended() {
    let dir = tempfile::tempdir().unwrap();
    for format in ["opencv", "ros"] {
        let out = dir.path().join(format);
        let out = out.to_str().unwrap();
        let args =
            ["export", "opencv_chess_corners", "--replayed", "--format", format, "--out", out];
        let exported = selfcal(&args).success();
        assert!(stderr(&exported).contains("written as 1"), "{}", stderr(&exported));
        let replay = ["replay", "opencv_chess_corners", "--initial", out, "--json"];
        let run = selfcal(&replay).success();
        let json: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
        let [before, after] =
            ["rms_px_before", "rms_px_after"].map(|key| json[key].as_f64().unwrap());
        // From the usual start it is 2.36 px before.
        assert!(before < 0.2 && (before - after).abs() < 0.01, "{before} {after}");
        let again = selfcal(&args).failure();
        assert!(stderr(&again).contains("nothing is overwritten"));
    }
}

#[test]
fn what_is_exported_imports_as_the_rig_of_a_stream() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (chain, meta, stream) = (path("chain"), path("meta.json"), path("flight.scmf"));
    let set = "motorcycle_sift";
    selfcal(&["export", set, "--format", "kalibr", "--out", &chain]).success();
    selfcal(&["import", &chain, "--out", &meta]).success();
    selfcal(&["record", set, &stream]).success();
    let replayed = |rig: &str| {
        let run = selfcal(&["replay", &stream, "--rig", rig, "--json"]).success();
        run.get_output().stdout.clone()
    };
    assert_eq!(replayed(&meta), replayed(set));
    assert_eq!(replayed(&format!("{chain}/camchain.yaml")), replayed(set));
    let again = selfcal(&["import", &chain, "--out", &meta]).failure();
    assert!(stderr(&again).contains("nothing is overwritten"));
}

#[test]
fn help_teaches_the_signs() {
    for command in ["import", "export"] {
        let help = selfcal(&[command, "--help"]).success();
        let help = String::from_utf8(help.get_output().stdout.clone()).unwrap();
        // Line breaks depend on the width of the terminal.
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in ["x_2 = R x_1 + T", "T_cn_cnm1", "P[0][3] = -fx b", "Examples"] {
            assert!(help.contains(word), "{word} is missing:\n{help}");
        }
    }
}
