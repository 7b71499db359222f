//! Passes the board's memory map to the linker.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let variable = |name| PathBuf::from(env::var_os(name).expect("cargo sets the variable"));
    let map = variable("CARGO_MANIFEST_DIR").join("../../../memory.x");
    let out = variable("OUT_DIR");
    println!("cargo:rerun-if-changed={}", map.display());
    fs::copy(map, out.join("memory.x")).expect("the memory map is at the root");
    println!("cargo:rustc-link-search={}", out.display());
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
}
