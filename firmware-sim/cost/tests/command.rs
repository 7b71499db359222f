//! The options of `controller-cost`.

use test_support::Program;

#[test]
fn invalid_options_are_refused() {
    for (arguments, named) in [
        (&["--check", "--update"][..], "--update"),
        (&["--repeat", "0"], "--repeat"),
        (&["--other-compiler"], "--check"),
        (&["--board", "m5"], "m4f, m7"),
        (&["--opt", "2"], "3, s"),
    ] {
        let said = Program::new(env!("CARGO_BIN_EXE_cost"), arguments).failure(2);
        assert!(said.contains(named), "{said}");
    }
}
