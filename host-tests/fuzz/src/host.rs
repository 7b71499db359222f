//! Files that a host reads, of any bytes: rig files, bags, images, tables of matches. Each gives an answer or an error
//! that names the file.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use images::picture::Picture;
use images::source::{Item, RigOf, Source, Wanted};
use rigs::data::FrameRows;
use rigs::formats::{Unknowns, import};

/// Names that matter to a reader of rig files: an ending, or that of a table.
const NAMES: [&str; 4] = ["rig.yaml", "rig.json", "cameras.txt", "calibration.txt"];

/// Hands a file of these bytes to a reader.
fn with_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> anyhow::Result<()>) {
    let dir = tempfile::tempdir().expect("a folder for the file");
    let path = dir.path().join(name);
    fs::write(&path, bytes).expect("a file in it");
    if let Err(why) = read(&path) {
        let why = format!("{why:#}");
        assert!(why.contains(name), "no name in: {why}");
    }
}

/// Reads the bytes as a rig file, under several names.
///
/// # Panics
/// If the reader panics, or an error does not name the file.
pub fn run_rigs(bytes: &[u8]) {
    let unknowns = Unknowns { sizes: Some([[640, 480]; 2]), ..Unknowns::default() };
    for name in NAMES {
        with_file(name, bytes, |path| {
            if let Ok(meta) = import(&[path], unknowns) {
                meta.cameras::<f64>().expect("a rig that was read is valid");
            }
            import(&[path], Unknowns { cameras: Some([1, 0]), ..unknowns }).map(drop)
        });
    }
}

/// Reads the bytes as a bag of any kind: topics, calibration, pairs.
///
/// # Panics
/// If the reader panics, or an error does not name the file.
pub fn run_bags(bytes: &[u8]) {
    with_file("any.mcap", bytes, |path| {
        let source = Source::open(&[PathBuf::from(path)], &Wanted::default(), 0.005)?;
        if let RigOf::Infos(infos) = &source.rig {
            let _ = infos.rig();
        }
        source.read(&mut |item| {
            if let Item::Pair(frames) = item {
                for frame in &frames {
                    drop(frame.picture());
                }
            }
            ControlFlow::Continue(())
        })
    });
}

/// Decodes the bytes as an image.
///
/// # Panics
/// If the decoder panics.
pub fn run_images(bytes: &[u8]) {
    if let Ok(picture) = Picture::decode(bytes) {
        let [width, height] = picture.size().map(usize::from);
        assert_eq!(picture.pixels().len(), width * height);
    }
}

/// Reads the bytes as a table of matches with frames.
///
/// # Panics
/// If the reader panics, hands out a number that is not finite, or an error names no line.
pub fn run_tables(bytes: &[u8]) {
    let Ok(rows) = FrameRows::open(bytes) else { return };
    for pair in rows {
        let Ok(pair) = pair else { return };
        assert!(!pair.is_empty() && pair.iter().all(|m| m.ul.is_finite() && m.score.is_finite()));
    }
}
