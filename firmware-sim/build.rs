//! Generates the recording for the controller's image, and links the image.

#[path = "build/recording.rs"]
mod recording;

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, Result};

/// Data set in the image, under `host-tests/data`.
const DATA_SET: &str = "opencv_chess_sift";

fn main() -> Result<()> {
    let out = PathBuf::from(env::var_os("OUT_DIR").context("cargo sets OUT_DIR")?);
    // Read at run time, because working trees may share a target folder.
    let package = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").context("cargo sets it")?);
    let root = package.join("..");
    recording::generate(&root.join("host-tests/data").join(DATA_SET), &out)?;
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        link(&package, &out)?;
    }
    Ok(())
}

/// Passes the memory map, the vector table and the log sections to the linker. Only images need them.
fn link(package: &Path, out: &Path) -> Result<()> {
    let memory = package.join("../memory.x");
    fs::copy(&memory, out.join("memory.x")).context("memory.x of the workspace")?;
    println!("cargo::rerun-if-changed={}", memory.display());
    let vectors = package.join("device.x");
    fs::copy(&vectors, out.join("device.x")).context("device.x of the board")?;
    println!("cargo::rerun-if-changed={}", vectors.display());
    println!("cargo::rustc-link-search={}", out.display());
    for kind in ["bins", "examples"] {
        for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
            println!("cargo::rustc-link-arg-{kind}={argument}");
        }
    }
    Ok(())
}
