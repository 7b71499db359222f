//! Builds the programs for a board, with rustup's or Debian's toolchain.

use std::collections::HashMap;
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::variant::{Board, Variant};

const TARGET: &str = "thumbv7em-none-eabihf";

/// A message of cargo, the fields used here.
#[derive(Deserialize)]
struct Message {
    target: Option<Named>,
    executable: Option<PathBuf>,
}

#[derive(Deserialize)]
struct Named {
    name: String,
}

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Builds all programs of a variant. Returns their paths by name.
pub(crate) fn programs(variant: Variant) -> Result<HashMap<String, PathBuf>> {
    let root = root();
    let target_dir = env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    // One folder per board: their programs have the same names.
    let target_dir = match variant.board {
        // Shares the standard library and the core with the other builds of these profiles.
        Board::CortexM4F => target_dir,
        Board::CortexM7 => target_dir.join("measure/m7"),
    };
    let programs = variant.board.programs();
    let mut command = Command::new(root.join(".cargo/for-target"));
    command
        .args([TARGET, "build", "--package", "measure-board"])
        .args(["--profile", variant.optimisation.profile()])
        .args(["--message-format", "json-render-diagnostics", "--quiet"])
        .args(programs.iter().flat_map(|name| ["--bin", name]))
        .current_dir(&root)
        .env("CARGO_TARGET_DIR", target_dir)
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .envs(variant.board.rustflags().map(|flags| ("RUSTFLAGS", flags)))
        .stderr(Stdio::inherit());
    let output = command.output().context("cannot start .cargo/for-target")?;
    if !output.status.success() {
        bail!("cannot build for {variant}; .ci/install-toolchain installs the toolchain");
    }
    let built = executables(&output.stdout)?;
    for name in &programs {
        built.contains_key(name).then_some(()).with_context(|| format!("cargo built no {name}"))?;
    }
    Ok(built)
}

fn executables(messages: &[u8]) -> Result<HashMap<String, PathBuf>> {
    let messages = serde_json::Deserializer::from_slice(messages).into_iter::<Message>();
    let mut executables = HashMap::new();
    for message in messages {
        let message = message.context("cannot parse a message of cargo")?;
        if let (Some(target), Some(executable)) = (message.target, message.executable) {
            executables.insert(target.name, executable);
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
}
