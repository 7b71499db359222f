//! The firmware: on a host with a simulated matcher, on the controller with a recording in flash.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

#[cfg(target_os = "none")]
mod flash;
#[cfg(not(target_os = "none"))]
mod sim;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    sim::main()
}
