//! Builds the framer with Verilator, in two sizes, as libraries. Needs `verilator` and a C++ compiler.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use anyhow::{Context, Result, ensure};

/// Name of each model, and the largest number of matches of its frames. The small model fills often. The large one
/// holds each pair of the set `opencv_chess_sift`.
const MODELS: [(&str, u32); 2] = [("small", 30), ("large", 510)];

fn main() -> Result<()> {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").context("cargo sets it")?);
    let out = PathBuf::from(env::var_os("OUT_DIR").context("cargo sets it")?);
    for folder in ["rtl", "sim"] {
        println!("cargo::rerun-if-changed={}", root.join(folder).display());
    }
    let include = verilator_root()?.join("include");
    let mut runtime = cc::Build::new();
    runtime.cpp(true).std("c++17").warnings(false).include(&include);
    runtime.file(include.join("verilated.cpp")).file(include.join("verilated_threads.cpp"));
    for (name, matches) in MODELS {
        verilate(&root, &out.join(name), name, matches)?;
        model(&root, &out, &include, name)?;
    }
    runtime.compile("verilated");
    Ok(())
}

fn verilator_root() -> Result<PathBuf> {
    let output = Command::new("verilator").args(["--getenv", "VERILATOR_ROOT"]).output();
    let output = output.context("verilator is missing: apt-get install verilator")?;
    Ok(PathBuf::from(String::from_utf8(output.stdout)?.trim()))
}

/// Translates the bench to C++.
fn verilate(root: &Path, to: &Path, name: &str, matches: u32) -> Result<()> {
    let mut command = Command::new("verilator");
    command.args([
        "--cc",
        "-O3",
        "-Wall",
        "--assert",
        "+define+FORMAL",
        "--x-assign",
        "unique",
        "--top",
        "bench",
    ]);
    command.args(["--prefix", &format!("V{name}"), &format!("-GMATCHES={matches}")]);
    command.arg("--Mdir").arg(to).arg(root.join("sim/bench.sv"));
    let mut sources: Vec<PathBuf> =
        fs::read_dir(root.join("rtl"))?.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    sources.sort();
    let status = command.args(sources).status().context("verilator is missing")?;
    ensure!(status.success(), "verilator refused the sources");
    Ok(())
}

/// Compiles the translation and the functions around it.
fn model(root: &Path, out: &Path, include: &Path, name: &str) -> Result<()> {
    let folder = out.join(name);
    let mut build = cc::Build::new();
    build.cpp(true).std("c++17").warnings(false).opt_level(2);
    build.include(include).include(include.join("vltstd")).include(&folder);
    build.define("MODEL_HEADER", format!("\"V{name}.h\"").as_str());
    build.define("MODEL", format!("V{name}").as_str());
    build.define("NAME(x)", format!("selfcal_{name}_##x").as_str());
    for entry in fs::read_dir(&folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "cpp") {
            build.file(path);
        }
    }
    build.file(root.join("sim/shim.cpp")).try_compile(&format!("bench_{name}"))?;
    Ok(())
}
