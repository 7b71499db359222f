//! Generates the frames of a data set as bytes, and its cameras and extrinsics as constants. The tests in
//! `tests/firmware/recording.rs` compare them with the simulated matcher.

use std::ffi::OsStr;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use crc::{CRC_32_ISO_HDLC, Crc};
use serde_json::Value;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Writes `frames.bin` and `recording.rs`.
pub(crate) fn generate(set: &Path, out: &Path) -> Result<()> {
    println!("cargo::rerun-if-changed={}", set.display());
    let mut files: Vec<PathBuf> = fs::read_dir(set.join("pairs"))
        .with_context(|| format!("pairs of {}", set.display()))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_>>()?;
    files.sort();
    let meta = set.join("meta.json");
    let meta: Value = serde_json::from_str(&fs::read_to_string(meta)?).context("meta.json")?;
    let side = |key: &str| meta[key].as_u64().and_then(|n| u16::try_from(n).ok()).context("a size");
    let image_size = [side("width")?, side("height")?];
    let mut bytes = Vec::new();
    for (sequence, file) in (0_u32..).zip(&files) {
        let text = fs::read_to_string(file)?;
        bytes.extend(
            frame(sequence, image_size, &text).with_context(|| file.display().to_string())?,
        );
    }
    fs::write(out.join("frames.bin"), bytes)?;
    fs::write(out.join("recording.rs"), constants(set, &meta, files.len())?)?;
    Ok(())
}

/// Encodes a frame in the wire format of the core's link. Grid step 0 stands for the resolution of the wire.
fn frame(sequence: u32, [width, height]: [u16; 2], csv: &str) -> Result<Vec<u8>> {
    let mut lines = csv.lines();
    ensure!(lines.next() == Some("ul,vl,ur,vr,score"), "columns ul,vl,ur,vr,score are needed");
    let rows: Vec<[f32; 5]> = lines.map(row).collect::<Result<_>>()?;
    let [version, flags, fraction_bits, pyramid_ratio] = [1, 0, 8, 64];
    // 20 Hz.
    let (grid_step, timestamp) = (0_u16, u64::from(sequence) * 50_000);
    let mut bytes = b"SCMF".to_vec();
    bytes.extend([version, flags, fraction_bits, pyramid_ratio]);
    bytes.extend(sequence.to_le_bytes());
    bytes.extend(u16::try_from(rows.len())?.to_le_bytes());
    bytes.extend(grid_step.to_le_bytes());
    bytes.extend(timestamp.to_le_bytes());
    bytes.extend(width.to_le_bytes());
    bytes.extend(height.to_le_bytes());
    let mut crc = CRC.digest();
    crc.update(&bytes);
    bytes.extend(crc.clone().finalize().to_le_bytes());
    for row in rows {
        let record = record(row)?;
        crc.update(&record);
        bytes.extend(record);
    }
    bytes.extend(crc.finalize().to_le_bytes());
    Ok(bytes)
}

fn record([pixels @ .., score]: [f32; 5]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    for px in pixels {
        bytes.extend(&fixed(px, 256.0, 24)?.to_le_bytes()[..3]);
    }
    bytes.extend(u16::try_from(fixed(score, 65_535.0, 16)?)?.to_le_bytes());
    let [level, reserved] = [0, 0];
    bytes.extend([level, reserved]);
    Ok(bytes)
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to f32, as the host does")]
fn row(line: &str) -> Result<[f32; 5]> {
    let numbers: Vec<f32> = line
        .split(',')
        // Through `f64`, like the parser of the host.
        .map(|text| text.parse::<f64>().map(|x| x as f32).context("a number is needed"))
        .collect::<Result<_>>()?;
    numbers.try_into().ok().with_context(|| format!("not five numbers: {line}"))
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a whole number in range"
)]
fn fixed(x: f32, scale: f64, bits: u32) -> Result<u32> {
    let steps = (f64::from(x) * scale).round();
    ensure!(steps >= 0.0 && steps < f64::from(1_u32 << bits), "{x} does not fit the wire");
    Ok(steps as u32)
}

/// Cameras and extrinsics as constants.
fn constants(set: &Path, meta: &Value, pairs: usize) -> Result<String> {
    ensure!(meta["lens"].is_null(), "only the radial-tangential lens is supported");
    let name = set.file_name().and_then(OsStr::to_str).context("a data set has a name")?;
    let mut text = String::new();
    writeln!(text, "pub const NAME: &str = {name:?};")?;
    writeln!(text, "pub const PAIRS: u32 = {pairs};")?;
    writeln!(text, "pub(super) const SIZE: [u16; 2] = [{}, {}];", meta["width"], meta["height"])?;
    for (constant, key, kind) in [
        ("LEFT", "K_l", "[[f64; 3]; 3]"),
        ("RIGHT", "K_r", "[[f64; 3]; 3]"),
        ("LEFT_LENS", "dist_l", "[f64; 5]"),
        ("RIGHT_LENS", "dist_r", "[f64; 5]"),
        ("R", "R", "[[f64; 3]; 3]"),
        ("T", "t", "[f64; 3]"),
    ] {
        writeln!(text, "pub(super) const {constant}: {kind} = {};", meta[key])?;
    }
    Ok(text)
}
