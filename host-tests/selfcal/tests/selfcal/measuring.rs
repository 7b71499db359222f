//! The commands `campaign` and `bench`, and the help.

use std::fs;

use crate::call;

#[test]
fn the_campaign_of_real_rigs_has_a_row_a_case() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("real.csv");
    let args =
        ["campaign", "real", "--trials=1", "--pairs=6", "--only", "altitude/sky", "lens/f_r=1%"];
    let text = call::stdout(&[&args[..], &["--csv", file.to_str().unwrap()]].concat());
    let csv = fs::read_to_string(&file).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[0][..3], ["group", "case", "runs"]);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    for (row, case) in rows[1..].iter().zip([["altitude", "sky"], ["lens", "f_r=1%"]]) {
        assert_eq!(row[..2], case);
        assert!(text.contains(&format!("\n  {} ", case[1])), "{text}");
    }
    assert!(call::failure(&["campaign", "real", "--only", "nothing"], 1).contains("nothing"));
    assert!(call::failure(&["campaign", "fused", "--only", "altitude"], 1).contains("--only"));
}

#[test]
fn bench_judges_the_pairs_that_synth_has_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("near.pairs");
    let file = path.to_str().unwrap();
    let synth = ["synth", "--pairs", "5", "--matches", "64", "--rotation", "1,2,3", "--rays", file];
    assert!(call::stdout(&synth).contains("5 pairs written"));
    assert!(call::failure(&synth, 1).contains("nothing is overwritten"));
    let object = call::json(&["bench", file, "--rounds", "1", "--json"]);
    let mut fields: Vec<&str> = object.as_object().unwrap().keys().map(String::as_str).collect();
    fields.sort_unstable();
    let expected = [
        "e_t_deg",
        "e_theta_deg",
        "failures",
        "matches",
        "median_us",
        "p99_us",
        "pairs",
        "passes",
        "push_median_us",
        "refused",
    ];
    assert_eq!(fields, expected);
    assert_eq!([&object["pairs"], &object["matches"], &object["failures"]], [5, 64, 0]);
    assert!(
        call::stdout(&["bench", file, "--preset", "paper", "--scalar", "f64"])
            .contains("failures  0")
    );
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    assert!(call::failure(&["bench", file], 1).contains("5 pairs of 64 correspondences are"));
}

#[test]
fn help_teaches() {
    let help = call::stdout(&["replay", "--help"]);
    for word in ["meta.json", "Examples", "--initial", "p_r", "rad"] {
        let found = help.contains(word) || call::stdout(&["--help"]).contains(word);
        assert!(found, "{word} is missing:\n{help}");
    }
}
