//! `controller-cost` as far as it needs no emulator.

use assert_cmd::Command;

fn refused(arguments: &[&str]) -> String {
    let output = Command::cargo_bin("measure").unwrap().args(arguments).assert().failure();
    String::from_utf8(output.get_output().stderr.clone()).unwrap()
}

#[test]
fn a_check_without_a_table_fails_before_anything_is_built_and_says_how_to_make_one() {
    let said = refused(&["--check", "--table", "no/such.csv"]);
    assert!(said.contains("no/such.csv") && said.contains("--update"), "{said}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    assert!(refused(&["--check", "--update"]).contains("--update"));
    assert!(refused(&["--repeat", "0"]).contains("--repeat"));
}
