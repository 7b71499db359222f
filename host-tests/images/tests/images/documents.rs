//! The commands of the documents, as far as they read images.

use assert_cmd::Command;

const DOCUMENTS: [&str; 3] = [
    include_str!("../../../../README.md"),
    include_str!("../../../EVIDENCE.md"),
    include_str!("../../../data/README.md"),
];

#[test]
fn the_commands_of_the_documents_are_understood() {
    let mut seen = 0;
    for document in DOCUMENTS {
        let words: Vec<&str> = document.split_whitespace().collect();
        let text = words.join(" ");
        for call in text.split("cargo selfcal ").skip(1) {
            let end = call.find(['`', '#', ';']).unwrap_or(call.len());
            let call = call[..end].split(" cargo ").next().unwrap();
            let arguments: Vec<&str> = call.split(' ').filter(|word| !word.is_empty()).collect();
            if !matches!(arguments.first(), Some(&("images" | "check" | "matcher"))) {
                continue;
            }
            seen += 1;
            let mut command = Command::cargo_bin("selfcal-images").unwrap();
            command.args(&arguments).arg("--help").assert().success();
        }
    }
    assert!(seen >= 6, "{seen} commands");
}
