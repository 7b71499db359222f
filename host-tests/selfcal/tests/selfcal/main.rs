//! The program `selfcal` as a user calls it.

mod call;
mod commands;
mod documents;
mod images;

#[test]
fn help_teaches() {
    let help = call::stdout(&["replay", "--help"]);
    for word in ["meta.json", "Examples", "--initial", "p_r", "rad"] {
        let found = help.contains(word) || call::stdout(&["--help"]).contains(word);
        assert!(found, "{word} is missing:\n{help}");
    }
}
