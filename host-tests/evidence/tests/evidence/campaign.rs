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

#[test]
fn alarms_are_counted_in_recordings_of_ones_own() {
    let set = format!("{}/../data/opencv_chess_sift", env!("CARGO_MANIFEST_DIR"));
    let rest = ["campaign", "rest", "--trials=1", "--pairs=40"];
    let table = evidence(&[&rest[..], &["--set", &set]].concat()).stdout();
    assert!(table.contains("opencv_chess_sift/rest") && !table.contains("oak_sift"), "{table}");
    let one_pair = evidence(&[&rest[..], &["--set", "aloe_sift"]].concat()).failure(1);
    assert!(one_pair.contains("two pairs or more"), "{one_pair}");
    let made = evidence(&["campaign", "fused", "--set", &set]).failure(1);
    assert!(made.contains("--set is for knocks and rest"), "{made}");
}
