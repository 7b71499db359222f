//! Replay of every shipped set, kept as text in `host-tests/golden`. A change of behaviour changes a table, which must
//! then be updated on purpose.
//!
//! Update: `UPDATE_EXPECT=1 cargo test -p sim golden`.

use std::fmt::Write;

use expect_test::expect_file;
use rigs::data::Dataset;
use sim::run::{Method, Start, Step, replay};
use stereo_selfcal::Config;
use stereo_selfcal::paper::Settings;

fn table(name: &str) -> String {
    let set = Dataset::load(&Dataset::shipped().join(name)).unwrap();
    let mut text = String::new();
    let methods: [(_, Method); 2] =
        [("robust", Config::robust().into()), ("paper", Settings::DEFAULT.into())];
    for (preset, method) in methods {
        writeln!(text, "{name}, {preset} preset, f32\npair {}", Step::HEADING).unwrap();
        let mut index = 0;
        let run = replay::<f32>(&set, method, Start::usual(&set.meta).unwrap(), |step| {
            writeln!(text, "{index:>4} {step}").unwrap();
            index += 1;
        });
        let summary = run.unwrap().summary(&set).unwrap();
        writeln!(text, "\n{summary}\n").unwrap();
    }
    text
}

#[test]
fn recorded_sets_replay_as_they_did() {
    expect_file!["../../../golden/opencv_chess_corners.txt"]
        .assert_eq(&table("opencv_chess_corners"));
    expect_file!["../../../golden/opencv_chess_sift.txt"].assert_eq(&table("opencv_chess_sift"));
    expect_file!["../../../golden/motorcycle_sift.txt"].assert_eq(&table("motorcycle_sift"));
    expect_file!["../../../golden/aloe_sift.txt"].assert_eq(&table("aloe_sift"));
    expect_file!["../../../golden/oak_sift.txt"].assert_eq(&table("oak_sift"));
}
