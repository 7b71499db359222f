//! Damaged copies of bags of every kind: wrong lengths, bits, cuts and blocks. A copy gives all its pairs, or says what
//! it lost, or is refused by name, in bounded memory. `CAMPAIGN=1` damages 10,000 copies of each kind.

use std::fs;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use image::GrayImage;
use images::source::{Item, RigOf, Source, Wanted};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use test_support::runs;

use crate::images::mcap_bag::{Bag, info, raw_image};
use crate::images::{ros1, sqlite_bag};

/// Most memory of the test's process, bytes.
const MOST_BYTES: u64 = 1 << 30;

/// Lengths that a damaged field may state.
const LENGTHS: [u64; 8] = [0, 1, 5, 1 << 20, 1 << 31, u32::MAX as u64, 1 << 62, u64::MAX];

/// Small pairs with some texture.
fn moments() -> Vec<[GrayImage; 2]> {
    let image = |seed: u32| {
        GrayImage::from_fn(24, 16, |u, v| {
            image::Luma([u8::try_from((u * 7 + v * 13 + seed * 31) % 251).unwrap()])
        })
    };
    (0..5).map(|i| [image(2 * i), image(2 * i + 1)]).collect()
}

fn mcap(path: &Path, compression: &'static str) {
    let mut bag = Bag::create(path, 1024, compression);
    let topics = ["left", "right"].map(|side| {
        bag.calibration(&info(&format!("/stereo/{side}/camera_info"), side == "right"));
        bag.topic(&format!("/stereo/{side}/image_raw"), "Image")
    });
    for (i, pair) in (0..).zip(&moments()) {
        for (topic, image) in topics.iter().zip(pair) {
            let pixels = (image.as_raw().clone(), image.width());
            bag.write(*topic, i, &raw_image(image, (100 + i, 0), "mono8", pixels));
        }
    }
    bag.finish();
}

fn damaged(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let at = random.random_range(0..bytes.len().max(1));
    let length = random.random_range(1..512).min(bytes.len() - at.min(bytes.len()));
    match random.random_range(0..7) {
        0 => bytes
            .iter_mut()
            .skip(at)
            .take(1)
            .for_each(|byte| *byte ^= 1 << random.random_range(0..8)),
        1 | 2 => {
            let stated = LENGTHS[random.random_range(0..LENGTHS.len())].to_le_bytes();
            let width = if random.random_range(0..2) == 0 { 4 } else { 8 };
            for (byte, new) in bytes.iter_mut().skip(at).zip(&stated[..width]) {
                *byte = *new;
            }
        }
        3 => bytes.truncate(at),
        4 => random.fill_bytes(&mut bytes[at..at + length]),
        5 => drop(bytes.drain(at..at + length)),
        _ => bytes[at..at + length].fill(0),
    }
}

/// The number of pairs that are read, and whether something is said to be lost.
fn read(path: &Path) -> anyhow::Result<(usize, bool)> {
    let source = Source::open(&[path.to_owned()], &Wanted::default(), 0.005)?;
    if let RigOf::Infos(infos) = &source.rig {
        // A damaged calibration is refused by name where the rig is needed.
        let _ = infos.rig();
    }
    let (mut pairs, mut lost) = (0, false);
    source.read(&mut |item| {
        match item {
            Item::Pair(frames) if frames.iter().all(|frame| frame.picture().is_ok()) => pairs += 1,
            _ => lost = true,
        }
        ControlFlow::Continue(())
    })?;
    Ok((pairs, lost))
}

/// Largest memory of the process so far, bytes, where the system tells it.
fn peak() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib << 10)
}

/// Writes a whole bag.
type Write<'a> = &'a dyn Fn(&Path);

/// The reference library (`mcap` 0.26) wrote the files, each with another compression.
#[test]
fn bags_of_the_reference_library_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mcap");
    for name in ["plain", "lz4", "zstd"] {
        let path = folder.join(name).with_extension("mcap");
        assert_eq!(read(&path).unwrap(), (5, false), "{name}");
    }
}

#[test]
fn damaged_copies_of_bags_give_all_pairs_or_say_what_is_lost() {
    let dir = tempfile::tempdir().unwrap();
    let whole = dir.path().join("whole");
    let ros = |compression: &'static str| {
        move |path: &Path| fs::write(path, ros1::bag(&moments(), compression)).unwrap()
    };
    let kinds: [(&str, usize, Write<'_>); 7] = [
        ("plain.mcap", 5, &|path| mcap(path, "")),
        ("lz4.mcap", 5, &|path| mcap(path, "lz4")),
        ("zstd.mcap", 5, &|path| mcap(path, "zstd")),
        ("plain.bag", 4, &ros("none")),
        ("lz4.bag", 4, &ros("lz4")),
        ("bz2.bag", 4, &ros("bz2")),
        ("humble.db3", 5, &|path| sqlite_bag::write(path, &moments())),
    ];
    for (seed, (name, pairs, write)) in (0..).zip(kinds) {
        let _ = fs::remove_file(&whole);
        write(&whole);
        let bytes = fs::read(&whole).unwrap();
        let path = dir.path().join(name);
        fs::write(&path, &bytes).unwrap();
        // The bag of ROS 1 lacks one right image.
        assert_eq!(read(&path).unwrap(), (pairs, pairs == 4), "{name}");
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let [mut answered, mut refused] = [0; 2];
        for round in 0..runs(60, 10_000) {
            let mut copy = bytes.clone();
            for _ in 0..random.random_range(1..3) {
                damaged(&mut copy, &mut random);
            }
            fs::write(&path, &copy).unwrap();
            let ended = catch_unwind(AssertUnwindSafe(|| read(&path)));
            match ended.unwrap_or_else(|_| panic!("{name} {round} panics")) {
                Ok((read, lost)) => {
                    assert!(read == pairs || lost, "{name} {round}: {read} pairs, silently");
                    answered += 1;
                }
                Err(why) => {
                    let why = format!("{why:#}");
                    assert!(why.contains(name) && why.len() > 30, "{name} {round}: {why}");
                    refused += 1;
                }
            }
        }
        println!("{name}: {answered} answered, {refused} refused");
        assert!(answered > 0 && refused > 0, "{name}");
    }
    if let Some(peak) = peak() {
        println!("at most {} MiB", peak >> 20);
        assert!(peak < MOST_BYTES, "{peak} bytes");
    }
}
