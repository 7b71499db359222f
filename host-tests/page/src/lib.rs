//! Charts, pages of sections, and the page of a run.
//!
//! [`chart`] draws SVG pictures: a new chart is a function of `chart::curves`, or draws on a `Plot`. [`report`] has the
//! blocks of a page: text, tables, figures. [`run`] is the page of one run: each section is a module with a function
//! `section`, which `Replayed::page` calls.
#![allow(
    clippy::missing_errors_doc,
    clippy::must_use_candidate,
    clippy::return_self_not_must_use,
    reason = "only this workspace uses the package"
)]

pub mod chart;
pub mod report;
pub mod run;

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

/// Writes a text; missing folders are created, an existing file is replaced.
///
/// # Errors
/// Names the file that cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
    folder
        .and_then(|()| fs::write(path, text))
        .with_context(|| format!("cannot write {}", path.display()))
}
