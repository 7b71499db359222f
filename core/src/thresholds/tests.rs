#[test]
fn every_threshold_stands_in_the_derivation_with_its_value() {
    let table = include_str!("../../ESTIMATOR.md");
    let mut found = 0;
    let files =
        [include_str!("../thresholds.rs"), include_str!("pair.rs"), include_str!("paper.rs")];
    for line in files.iter().flat_map(|file| file.lines()) {
        let Some(constant) = line.trim_start().strip_prefix("pub(crate) const ") else {
            continue;
        };
        let (name, rest) = constant.split_once(':').unwrap();
        let value = rest.split_once(" = ").unwrap().1.trim_end_matches(';');
        let stands = |row: &&str| {
            let mut cells = row.split(" | ");
            let [names, values] = [cells.next(), cells.next()].map(Option::unwrap_or_default);
            let quoted = names.split('`').any(|cell| cell == name);
            quoted && values.contains(value)
        };
        assert!(table.lines().any(|row| stands(&row)), "{name} = {value}");
        found += 1;
    }
    assert!(found > 90, "{found}");
}
