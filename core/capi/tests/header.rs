//! The committed header is what the source gives.
//!
//! Update: `UPDATE_EXPECT=1 cargo test -p stereo-selfcal-capi --test header`.

use std::path::Path;

use cbindgen::{Builder, Config};
use expect_test::expect_file;

/// In the order of the header.
const SOURCES: [&str; 14] = [
    "capacity",
    "code",
    "storage",
    "config",
    "camera",
    "extrinsics",
    "push",
    "link",
    "pair",
    "estimate",
    "health",
    "apply",
    "rectify",
    "record",
];

#[test]
fn the_header_is_that_of_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = Config::from_file(root.join("cbindgen.toml")).unwrap();
    let builder = SOURCES.iter().fold(Builder::new().with_config(config), |builder, name| {
        builder.with_src(root.join("src").join(name).with_extension("rs"))
    });
    let mut header = Vec::new();
    builder.generate().unwrap().write(&mut header);
    expect_file!["../include/stereo_selfcal.h"].assert_eq(&String::from_utf8(header).unwrap());
}
