//! Damaged files of every format give a rig or a refusal that names the file, without a panic or Rust debug output.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rigs::formats::{Files, Format, import, rig_of};

use crate::samples::samples;

/// Words of Rust debug output, which a message for people never has.
#[rustfmt::skip]
const RUST: [&str; 16] = [
    "Some(", "None", "Ok(", "Err(", "Option<", "Vec<", "f64", "u16", "usize", "String", "invalid type", "missing field",
    "deserialize", "unwrap", "::", "Error {",
];

/// Every refusal has one of these words: they tell what to do.
#[rustfmt::skip]
const ADVICE: [&str; 13] = [
    "expected ", "use ", "write ", "give ", "print ", "calibrate ", "must ", "compare ", "choose ", "are read",
    "Known formats", "Write ", "(--size ",
];

/// Number of damaged files of each format: of a usual run, and with `CAMPAIGN=1`.
const EACH: [usize; 2] = [40, 200];

/// Every so many rounds, the rig of the damaged files is also written again in all formats, if it is read.
const WRITTEN: usize = 10;

/// Adds a random damage to a text.
fn damaged(text: &str, random: &mut ChaCha8Rng) -> String {
    let text = if text.is_empty() { "\n" } else { text };
    let lines: Vec<&str> = text.lines().collect();
    let line = random.random_range(0..lines.len().max(1));
    let with_line = |new: &str| {
        let mut all = lines.clone();
        all[line] = new;
        all.join("\n")
    };
    let words: Vec<&str> = text.split_inclusive([' ', ',', '\n', '[', ']']).collect();
    let with_number = |new: &str, random: &mut ChaCha8Rng| {
        let numbers: Vec<usize> = (0..words.len())
            .filter(|&i| words[i].trim_end_matches([' ', ',', '\n', ']']).parse::<f64>().is_ok())
            .collect();
        let Some(&chosen) = numbers.get(random.random_range(0..numbers.len().max(1))) else {
            return text.to_owned();
        };
        let number = words[chosen].trim_end_matches([' ', ',', '\n', ']']);
        let replaced = words[chosen].replacen(number, new, 1);
        words
            .iter()
            .enumerate()
            .map(|(i, word)| if i == chosen { replaced.as_str() } else { *word })
            .collect()
    };
    match random.random_range(0..12) {
        0 => with_line(""),
        1 => with_line(&lines[line].replace([':', '='], " ")),
        2 => with_line(lines[line].split([':', '=']).next().unwrap_or("")),
        3 => lines[..line].join("\n"),
        4 => with_number("0", random),
        5 => with_number(".nan", random),
        6 => with_number("1e300", random),
        7 => with_number("-7", random),
        8 => with_number("text", random),
        9 => with_number("", random),
        10 => [&lines[..line], &lines[line..], &lines[line..]].concat().join("\n"),
        _ => {
            let at = random.random_range(0..text.len().max(1));
            let mut bytes = text.as_bytes().to_vec();
            if let Some(byte) = bytes.get_mut(at) {
                *byte = random.random_range(32..127);
            }
            String::from_utf8_lossy(&bytes).into_owned()
        }
    }
}

#[test]
fn damaged_files_of_every_format_are_read_or_refused_by_name() {
    for (seed, sample) in (0..).zip(samples()) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let [few, many] = EACH;
        for round in 0..test_support::runs(few, many) {
            let mut files = sample.files.clone();
            let which = random.random_range(0..files.len());
            for _ in 0..=random.random_range(0..2) {
                files[which].1 = damaged(&files[which].1, &mut random);
            }
            let texts = files.iter().map(|(name, text)| ((*name).into(), text.clone())).collect();
            let ended = catch_unwind(AssertUnwindSafe(|| {
                let meta = rig_of(&Files::of(texts)?, sample.unknowns)?;
                let some = Format::ALL.iter().filter(|_| round % WRITTEN == 0);
                anyhow::Ok(some.map(|format| format.write(&meta).err()).collect::<Vec<_>>())
            }));
            let ended = ended
                .unwrap_or_else(|_| panic!("{} {round} panics:\n{}", sample.name, files[which].1));
            let refused = match ended {
                Ok(written) => {
                    written.into_iter().flatten().map(|why| format!("{why:#}")).collect()
                }
                Err(why) => {
                    let why = format!("{why:#}");
                    let name = sample.files.iter().any(|(name, _)| why.contains(name));
                    assert!(name, "{} {round}: no file in: {why}\n{}", sample.name, files[which].1);
                    vec![why]
                }
            };
            for why in refused {
                let rust = RUST.iter().find(|word| why.contains(**word));
                assert_eq!(rust, None, "{} {round}: {why}\n{}", sample.name, files[which].1);
                let advises =
                    ADVICE.iter().any(|words| format!(" {why}").contains(&format!(" {words}")));
                assert!(advises, "{} {round}: no advice in: {why}", sample.name);
                assert!(why.len() > 30, "{why}");
            }
        }
    }
}

#[test]
fn empty_files_and_binary_files_are_refused_by_name() {
    for bytes in
        [&b""[..], b"\xff\xfe\x00binary", b"hello", b"{", b"[1, 2]", b"<a>", b"a: [", b"---\n---\n"]
    {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rig.yaml");
        std::fs::write(&path, bytes).unwrap();
        let why =
            format!("{:#}", import(&[&path], rigs::formats::Unknowns::default()).unwrap_err());
        assert!(why.contains("rig.yaml"), "{why}");
        assert_eq!(RUST.iter().find(|word| why.contains(**word)), None, "{why}");
    }
}
