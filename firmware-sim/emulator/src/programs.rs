//! Builds programs for a board, with rustup's or Debian's toolchain.

use std::collections::HashMap;
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::Board;

/// The root of the workspace.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Builds programs of the workspace. Returns their paths by name.
///
/// * `configure`: adds the arguments of `cargo build`, and variables.
///
/// # Errors
/// If `.cargo/for-target` does not start, or the build fails; it has printed its errors.
pub fn build(
    board: &Board,
    configure: impl FnOnce(&mut Command) -> &mut Command,
) -> Result<HashMap<String, PathBuf>> {
    let root = root();
    let script = root.join(".cargo/for-target");
    let mut command = Command::new(&script);
    command.args([board.target, "build", "--message-format", "json-render-diagnostics", "--quiet"]);
    command.current_dir(&root).env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
    if !board.rustflags.is_empty() {
        // A folder of its own: programs of both boards have the same names.
        let folder = env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
        command.env("CARGO_TARGET_DIR", folder.join(board.name)).env("RUSTFLAGS", board.rustflags);
    }
    let output = configure(&mut command).stderr(Stdio::inherit()).output();
    let output = output.with_context(|| format!("cannot start {}", script.display()))?;
    ensure!(
        output.status.success(),
        "cannot build for {}; .ci/install-toolchain installs the toolchain",
        board.name
    );
    executables(&output.stdout)
}

/// Builds the plugin of QEMU that counts cycles, the package `cycles`. Returns its path.
///
/// # Errors
/// If this is not Linux, or the build fails; it has printed its errors.
pub fn cycle_counter() -> Result<PathBuf> {
    ensure!(cfg!(target_os = "linux"), "the plugin of QEMU that counts cycles needs Linux");
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["build", "--locked", "--quiet", "--message-format", "json-render-diagnostics"]);
    cargo.args(["--package", "cycles"]).current_dir(root()).stderr(Stdio::inherit());
    let output = cargo.output().context("cannot start cargo")?;
    ensure!(output.status.success(), "cannot build the plugin of QEMU");
    library(&output.stdout)?.context("cargo built no plugin of QEMU")
}

/// The library of the package `cycles` among the messages of cargo.
fn library(messages: &[u8]) -> Result<Option<PathBuf>> {
    for message in serde_json::Deserializer::from_slice(messages).into_iter::<Value>() {
        let message = message.context("cannot parse a message of cargo")?;
        if message["target"]["name"] == "cycles" {
            return Ok(message["filenames"][0].as_str().map(PathBuf::from));
        }
    }
    Ok(None)
}

fn executables(messages: &[u8]) -> Result<HashMap<String, PathBuf>> {
    let messages = serde_json::Deserializer::from_slice(messages).into_iter::<Value>();
    let mut executables = HashMap::new();
    for message in messages {
        let message = message.context("cannot parse a message of cargo")?;
        let [name, path] = [&message["target"]["name"], &message["executable"]].map(Value::as_str);
        if let Some((name, path)) = name.zip(path) {
            executables.insert(name.into(), path.into());
        }
    }
    Ok(executables)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn executables_are_found_among_the_messages_of_cargo() {
        let messages =
            br#"{"reason":"compiler-artifact","target":{"name":"core"},"executable":null}
            {"reason":"compiler-artifact","target":{"name":"bare"},"executable":"a/bare"}
            {"reason":"build-finished","success":true}"#;
        let found = executables(messages).unwrap();
        assert_eq!(found, HashMap::from([("bare".into(), PathBuf::from("a/bare"))]));
        assert!(executables(b"warning: no json").is_err());
    }

    #[test]
    fn the_plugin_is_found_among_the_messages_of_cargo() {
        let messages = br#"{"target":{"name":"cycles"},"filenames":["a/libcycles.so"]}
            {"reason":"build-finished","success":true}"#;
        assert_eq!(library(messages).unwrap(), Some(PathBuf::from("a/libcycles.so")));
        assert_eq!(library(b"{}").unwrap(), None);
    }
}
