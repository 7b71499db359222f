//! Builds the controller's image with the project's script.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use serde_json::Value;
use tempfile::{NamedTempFile, TempPath};
use thiserror::Error;

use emulator::Machine;
const TARGET: &str = "thumbv7em-none-eabihf";

/// Cargo's variable for the flags of that target.
const RUSTFLAGS: &str = "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS";

/// Why the image could not be built.
#[derive(Debug, Error)]
pub(super) enum ImageError {
    /// The script is missing: the program runs outside of its workspace.
    #[error("{}: {why}; give an image with --image", .script.display())]
    NoScript {
        /// Its path.
        script: PathBuf,
        /// The error of the system.
        why: io::Error,
    },
    /// The build failed and has printed its errors.
    #[error("the image for the controller was not built ({0}); see above")]
    NotBuilt(ExitStatus),
    /// The build reported no executable.
    #[error("the build named no image")]
    NotNamed,
    /// The image could not be copied.
    #[error("cannot copy {}: {why}", .image.display())]
    Copy {
        /// The image.
        image: PathBuf,
        /// The error of the system.
        why: io::Error,
    },
}

/// Builds the image for a board with the instruction set of its core. Returns a copy for this run: a build
/// for another board writes to the same path.
///
/// # Errors
/// [`ImageError`].
pub(super) fn build(machine: Machine) -> Result<TempPath, ImageError> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let script = workspace.join(".cargo/for-target");
    // Held until the copy is made, so that no other run builds in between.
    let _alone = match locked(&script) {
        Ok(lock) => lock,
        Err(why) => return Err(ImageError::NoScript { script, why }),
    };
    let mut build = Command::new(&script);
    build
        .current_dir(&workspace)
        .args([TARGET, "build", "-p", "firmware-sim", "--bin", "firmware-pil"])
        .args(["--features", "pil", "--message-format=json-render-diagnostics"])
        .envs(machine.rustflags().map(|flags| (RUSTFLAGS, flags)))
        .stderr(Stdio::inherit());
    let build = build.output().map_err(|why| ImageError::NoScript { script, why })?;
    if !build.status.success() {
        return Err(ImageError::NotBuilt(build.status));
    }
    let image = named(&build.stdout).ok_or(ImageError::NotNamed)?;
    copy(&image).map_err(|why| ImageError::Copy { image, why })
}

/// Locks a file until the value is dropped.
fn locked(file: &Path) -> io::Result<File> {
    let file = File::open(file)?;
    file.lock()?;
    Ok(file)
}

fn copy(image: &Path) -> io::Result<TempPath> {
    let copy = NamedTempFile::new()?.into_temp_path();
    fs::copy(image, &copy)?;
    Ok(copy)
}

/// The executable among cargo's messages.
fn named(messages: &[u8]) -> Option<PathBuf> {
    let messages = serde_json::Deserializer::from_slice(messages).into_iter::<Value>();
    messages.flatten().filter_map(|m| m["executable"].as_str().map(PathBuf::from)).last()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_executable_is_found_among_the_messages() {
        let messages = br#"{"reason":"compiler-artifact","executable":null}
{"reason":"compiler-artifact","executable":"/a/firmware-pil"}
{"reason":"build-finished","success":true}
"#;
        assert_eq!(named(messages), Some("/a/firmware-pil".into()));
        assert_eq!(named(br#"{"reason":"build-finished","success":true}"#), None);
    }
}
