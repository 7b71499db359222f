//! The parts of `controller-cost` that need no emulator.

use test_support::Program;

fn refused(arguments: &[&str]) -> String {
    let ended = Program::new(env!("CARGO_BIN_EXE_measure"), arguments).ended();
    assert_ne!(ended.status, 0, "{}", ended.out);
    ended.err
}

#[test]
fn a_check_without_tables_fails_before_the_builds_and_says_how_to_write_one() {
    let said = refused(&["--check", "--table", "no/such/folder"]);
    assert!(said.contains("no/such/folder") && said.contains("--update"), "{said}");
}

#[test]
fn invalid_options_are_refused() {
    assert!(refused(&["--check", "--update"]).contains("--update"));
    assert!(refused(&["--repeat", "0"]).contains("--repeat"));
}
