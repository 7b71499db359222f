//! The command `campaign`.

use std::fs;

use crate::evidence;

#[test]
fn a_campaign_has_a_row_a_case_and_all_figures_in_its_file() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("lenses.csv");
    let args =
        ["campaign", "lenses", "--trials=1", "--pairs=6", "--only", "lens/none", "lens/f_r=1%"];
    let text = evidence(&[&args[..], &["--csv", file.to_str().unwrap()]].concat()).stdout();
    assert_eq!(text.lines().count(), 3, "{text}");
    assert!(text.starts_with("case") && text.contains("e_t median"), "{text}");
    let csv = fs::read_to_string(&file).unwrap();
    let names: Vec<&str> = csv.lines().filter_map(|line| line.split(',').next()).collect();
    assert_eq!(names, ["case", "lens/none", "lens/f_r=1%"]);
    assert!(csv.lines().all(|line| line.split(',').count() > 40), "{csv}");
    assert!(evidence(&["campaign", "lenses", "--only", "nothing"]).failure(1).contains("nothing"));
    assert!(evidence(&["campaign", "real"]).failure(2).contains("altitude-1000"));
}
