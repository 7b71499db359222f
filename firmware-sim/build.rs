//! What the controller's image is linked with, and the recording that is baked into it.

#[path = "build/bake.rs"]
mod bake;

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, Result};

/// Data set in the image, under `host-tests/data`.
const BAKED: &str = "opencv_chess_sift";

fn main() -> Result<()> {
    let out = PathBuf::from(env::var_os("OUT_DIR").context("cargo sets OUT_DIR")?);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    bake::bake(&root.join("host-tests/data").join(BAKED), &out)?;
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        link(&root, &out)?;
    }
    Ok(())
}

/// Memory map, vector table and the sections of the log, for images alone: a library has none.
fn link(root: &Path, out: &Path) -> Result<()> {
    let memory = root.join("memory.x");
    fs::copy(&memory, out.join("memory.x")).context("memory.x of the workspace")?;
    println!("cargo::rerun-if-changed={}", memory.display());
    let vectors = Path::new(env!("CARGO_MANIFEST_DIR")).join("device.x");
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
