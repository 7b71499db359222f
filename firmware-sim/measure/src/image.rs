//! Sizes in flash and RAM of a linked program, and the version of its compiler.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, SectionKind};
use semver::Version;

/// Size of a program, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Image {
    /// Code and constants, in flash.
    pub(crate) code: u64,
    /// Initial values, in flash and in RAM.
    pub(crate) data: u64,
    /// Zeroed RAM.
    pub(crate) zeroed: u64,
}

impl Image {
    pub(crate) fn of(program: &Path) -> Result<Self> {
        let bytes = read(program)?;
        let file = parse(&bytes, program)?;
        let sized = |kinds: &[SectionKind]| {
            let sections = file.sections().filter(|section| kinds.contains(&section.kind()));
            sections.map(|section| section.size()).sum()
        };
        Ok(Self {
            // The linker marks constants as strings if any of them is one.
            code: sized(&[
                SectionKind::Text,
                SectionKind::ReadOnlyData,
                SectionKind::ReadOnlyString,
            ]),
            data: sized(&[SectionKind::Data]),
            zeroed: sized(&[SectionKind::UninitializedData]),
        })
    }

    /// The difference to a smaller program.
    pub(crate) fn less(self, other: Self) -> Self {
        Self {
            code: self.code.saturating_sub(other.code),
            data: self.data.saturating_sub(other.data),
            zeroed: self.zeroed.saturating_sub(other.zeroed),
        }
    }
}

/// The version of the compiler, as its `.comment` section states it.
pub(crate) fn compiler(program: &Path) -> Result<Version> {
    let bytes = read(program)?;
    let file = parse(&bytes, program)?;
    let comment =
        file.section_by_name(".comment").context("the program has no .comment section")?;
    let names = comment.data().context("the .comment section cannot be read")?;
    let names = String::from_utf8_lossy(names);
    let rustc = names.split('\0').find_map(|name| name.strip_prefix("rustc version "));
    let version = rustc.and_then(|version| version.split_whitespace().next());
    Ok(version.context("the .comment section names no rustc")?.parse()?)
}

fn read(program: &Path) -> Result<Vec<u8>> {
    fs::read(program).with_context(|| format!("cannot read {}", program.display()))
}

fn parse<'a>(bytes: &'a [u8], program: &Path) -> Result<object::File<'a>> {
    object::File::parse(bytes).with_context(|| format!("{} is not a program", program.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_binary_has_code_and_names_its_compiler() {
        let program = std::env::current_exe().unwrap();
        assert!(Image::of(&program).unwrap().code > 10_000);
        assert!(compiler(&program).unwrap() > Version::new(1, 89, 0));
    }

    #[test]
    fn images_are_subtracted_by_section_kind() {
        let image = |code, data, zeroed| Image { code, data, zeroed };
        assert_eq!(image(9, 5, 1).less(image(2, 5, 0)), image(7, 0, 1));
    }

    #[test]
    fn a_file_that_is_not_a_program_is_refused_by_name() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert!(Image::of(&file).unwrap_err().to_string().contains("Cargo.toml"));
    }
}
