//! The committed header is the one generated from the source.
//!
//! Update: `UPDATE_EXPECT=1 cargo test -p stereo-selfcal-capi --test header`.

use std::fs;
use std::path::Path;

use cbindgen::{Builder, Config};
use expect_test::expect_file;

/// In the order of the header.
const SOURCES: [&str; 19] = [
    "capacity",
    "error",
    "instance",
    "lifecycle",
    "config",
    "lens",
    "camera",
    "extrinsics",
    "calibration",
    "push",
    "link",
    "encoder",
    "pair",
    "estimate",
    "health",
    "apply",
    "rectify",
    "record",
    "witness",
];

/// Declarations inside of `c_enum!`, which cbindgen does not expand.
fn enumerations(source: &str) -> String {
    let items = syn::parse_file(source).unwrap().items.into_iter();
    let declarations = items.filter_map(|item| match item {
        syn::Item::Macro(item) if item.mac.path.is_ident("c_enum") => Some(item.mac.tokens),
        _ => None,
    });
    declarations.map(|tokens| tokens.to_string()).collect()
}

#[test]
fn the_header_is_generated_from_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let unwrapped = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let config = Config::from_file(root.join("cbindgen.toml")).unwrap();
    let builder = SOURCES.iter().fold(Builder::new().with_config(config), |builder, name| {
        let source = root.join("src").join(name).with_extension("rs");
        let enumerations = enumerations(&fs::read_to_string(&source).unwrap());
        let unwrapped = unwrapped.join(name).with_extension("rs");
        fs::write(&unwrapped, enumerations).unwrap();
        builder.with_src(unwrapped).with_src(source)
    });
    let mut header = Vec::new();
    builder.generate().unwrap().write(&mut header);
    expect_file!["../include/stereo_selfcal.h"].assert_eq(&String::from_utf8(header).unwrap());
}
