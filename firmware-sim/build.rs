//! Names the recording for the program, and links the controller's image.

use std::env;
use std::path::PathBuf;

fn main() {
    // Read at run time, because working trees may share a target folder.
    let variable = |name| env::var_os(name).map(PathBuf::from);
    let package = variable("CARGO_MANIFEST_DIR").unwrap_or_default();
    let recording = variable("RECORDING").unwrap_or_else(|| package.join("recording"));
    println!("cargo::rerun-if-env-changed=RECORDING");
    println!("cargo::rustc-env=RECORDING={}", recording.display());
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    // The memory map, the vector table of the board, and the log.
    for script in ["../memory.x", "device.x"].map(|name| package.join(name)) {
        println!("cargo::rerun-if-changed={}", script.display());
        println!("cargo::rustc-link-search={}", script.with_file_name("").display());
    }
    for kind in ["bins", "examples"] {
        for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
            println!("cargo::rustc-link-arg-{kind}={argument}");
        }
    }
}
