//! Writes the header of the C API from its source.
//!
//! `cargo run -p capi-header` writes it; with `--check` it fails if the committed header differs.

use std::path::Path;
use std::process::ExitCode;
use std::{env, fs};

use anyhow::{Context, Result};
use cbindgen::{Builder, Config};

/// Source files, in the order of their declarations in the header.
const SOURCES: [&str; 25] = [
    "capacity",
    "error",
    "enumeration",
    "instance",
    "config",
    "lens",
    "camera",
    "extrinsics",
    "factory",
    "lifecycle",
    "calibration",
    "push",
    "link",
    "encoder",
    "pair",
    "estimate",
    "verdict",
    "history",
    "details",
    "apply",
    "rectify",
    "record",
    "witness",
    "tracks",
    "paper",
];

/// Returns the declarations inside of `c_enum!`, which cbindgen does not expand.
fn enumerations(source: &str) -> Result<String> {
    let items = syn::parse_file(source)?.items.into_iter();
    let declarations = items.filter_map(|item| match item {
        syn::Item::Macro(item) if item.mac.path.is_ident("c_enum") => Some(item.mac.tokens),
        _ => None,
    });
    Ok(declarations.map(|tokens| tokens.to_string()).collect())
}

fn header(capi: &Path) -> Result<String> {
    let unwrapped = tempfile::tempdir()?;
    let config = Config::from_file(capi.join("cbindgen.toml")).map_err(anyhow::Error::msg)?;
    let mut builder = Builder::new().with_config(config);
    for name in SOURCES {
        let source = capi.join("src").join(name).with_extension("rs");
        let text = fs::read_to_string(&source).with_context(|| source.display().to_string())?;
        let enumerations = unwrapped.path().join(name).with_extension("rs");
        fs::write(&enumerations, self::enumerations(&text)?)?;
        builder = builder.with_src(enumerations).with_src(source);
    }
    let mut header = Vec::new();
    builder.generate()?.write(&mut header);
    Ok(String::from_utf8(header)?)
}

fn main() -> Result<ExitCode> {
    let capi = Path::new(env!("CARGO_MANIFEST_DIR")).parent().context("no folder above")?;
    let path = capi.join("include/stereo_selfcal.h");
    let header = header(capi)?;
    if !env::args().any(|argument| argument == "--check") {
        fs::write(path, header)?;
        return Ok(ExitCode::SUCCESS);
    }
    if fs::read_to_string(&path)? == header {
        println!("{} is the one that the source generates", path.display());
        return Ok(ExitCode::SUCCESS);
    }
    eprintln!(
        "{} is not the one that the source generates: cargo run -p capi-header",
        path.display()
    );
    Ok(ExitCode::FAILURE)
}
