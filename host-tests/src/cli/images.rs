//! `selfcal images`, `check` and `matcher`: handed over to a program of its own.
//!
//! The readers of images and bags take minutes to build, which all other commands should not wait for.

use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};

use clap::Args;

/// The other program.
const PROGRAM: &str = "selfcal-images";

/// Arguments of a command that another program understands.
#[derive(Debug, Args)]
pub(crate) struct ImagesArgs {
    /// As the command's --help says.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Runs a command of the other program, and returns its status.
pub(crate) fn hand_over(name: &str, args: &ImagesArgs) -> ExitCode {
    let status = program().arg(name).args(&args.arguments).status();
    match status.map(|status| status.code()) {
        // A signal has no code.
        Ok(code) => ExitCode::from(code.and_then(|code| u8::try_from(code).ok()).unwrap_or(1)),
        Err(why) => {
            eprintln!("error: cannot run {PROGRAM}: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Below cargo, the one that cargo builds; otherwise the one beside this program.
fn program() -> Command {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.toml");
    match env::var_os("CARGO") {
        Some(cargo) if workspace.is_file() => {
            let mut command = Command::new(cargo);
            command.args(["run", "--release", "--manifest-path"]).arg(workspace);
            // Without --package, as the alias of `selfcal`: both share one build.
            command.args([
                "--features",
                "host-tests/selfcal,selfcal-images/command",
                "--bin",
                PROGRAM,
            ]);
            command.arg("--");
            command
        }
        _ => {
            let own = env::current_exe().unwrap_or_default();
            Command::new(own.with_file_name(format!("{PROGRAM}{}", env::consts::EXE_SUFFIX)))
        }
    }
}
