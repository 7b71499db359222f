//! The command `campaign`.

use std::fs;

use crate::evidence;

#[test]
fn the_campaign_of_real_rigs_has_a_row_a_case() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("real.csv");
    let args =
        ["campaign", "real", "--trials=1", "--pairs=6", "--only", "altitude/sky", "lens/f_r=1%"];
    let text = evidence(&[&args[..], &["--csv", file.to_str().unwrap()]].concat()).stdout();
    let csv = fs::read_to_string(&file).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[0][..3], ["group", "case", "runs"]);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    for (row, case) in rows[1..].iter().zip([["altitude", "sky"], ["lens", "f_r=1%"]]) {
        assert_eq!(row[..2], case);
        assert!(text.contains(&format!("\n  {} ", case[1])), "{text}");
    }
    assert!(evidence(&["campaign", "real", "--only", "nothing"]).failure(1).contains("nothing"));
    assert!(evidence(&["campaign", "fused", "--only", "altitude"]).failure(1).contains("--only"));
}
