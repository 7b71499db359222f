//! Builds the programs for a board, with whatever toolchain the machine has.

use std::collections::HashMap;
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::variant::Variant;

const TARGET: &str = "thumbv7em-none-eabihf";

/// A line of what cargo reports, as far as it matters here.
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

/// Builds all programs of a variant: each by its name.
pub(crate) fn programs(variant: Variant) -> Result<HashMap<String, PathBuf>> {
    let root = root();
    let target_dir = env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    // One a board: their flags differ, and each would undo the other's build.
    let target_dir = target_dir.join("measure").join(variant.board.name());
    let programs = variant.board.programs();
    let mut command = Command::new(root.join(".cargo/for-target"));
    command
        .args([TARGET, "build", "--package", "measure-board"])
        .args(["--profile", variant.optimisation.profile()])
        .args(["--message-format", "json-render-diagnostics", "--quiet"])
        .args(programs.iter().flat_map(|name| ["--bin", name]))
        .current_dir(&root)
        .env("CARGO_TARGET_DIR", target_dir)
        .env("RUSTFLAGS", variant.board.rustflags())
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .stderr(Stdio::inherit());
    let output = command.output().context("cannot start .cargo/for-target")?;
    if !output.status.success() {
        bail!("cannot build for {variant}; .ci/install-toolchain installs what it takes");
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
        let message = message.context("cargo reports what cannot be read")?;
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
    fn of_what_cargo_reports_the_executables_are_taken() {
        let messages =
            br#"{"reason":"compiler-artifact","target":{"name":"core"},"executable":null}
            {"reason":"compiler-artifact","target":{"name":"bare"},"executable":"a/bare"}
            {"reason":"build-finished","success":true}"#;
        let found = executables(messages).unwrap();
        assert_eq!(found, HashMap::from([("bare".into(), PathBuf::from("a/bare"))]));
        assert!(executables(b"warning: no json").is_err());
    }
}
