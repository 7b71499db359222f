//! What is in a linked program: bytes of flash and RAM, and the compiler that made it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, SectionKind};

/// Bytes that a program takes.
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
            code: sized(&[SectionKind::Text, SectionKind::ReadOnlyData]),
            data: sized(&[SectionKind::Data]),
            zeroed: sized(&[SectionKind::UninitializedData]),
        })
    }

    /// What this one has more of.
    pub(crate) fn beyond(self, other: Self) -> Self {
        Self {
            code: self.code.saturating_sub(other.code),
            data: self.data.saturating_sub(other.data),
            zeroed: self.zeroed.saturating_sub(other.zeroed),
        }
    }
}

/// The version of the compiler that a program names.
pub(crate) fn compiler(program: &Path) -> Result<String> {
    let bytes = read(program)?;
    let file = parse(&bytes, program)?;
    let comment = file.section_by_name(".comment").context("the program names no compiler")?;
    let names = comment.data().context("the program names no compiler")?;
    let names = String::from_utf8_lossy(names);
    let rustc = names.split('\0').find_map(|name| name.strip_prefix("rustc version "));
    let version = rustc.and_then(|version| version.split_whitespace().next());
    Ok(version.context("the program names no rustc")?.to_owned())
}

fn read(program: &Path) -> Result<Vec<u8>> {
    fs::read(program).with_context(|| format!("cannot read {}", program.display()))
}

fn parse<'a>(bytes: &'a [u8], program: &Path) -> Result<object::File<'a>> {
    object::File::parse(bytes).with_context(|| format!("{} is no program", program.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_very_test_has_code_and_names_its_compiler() {
        let program = std::env::current_exe().unwrap();
        assert!(Image::of(&program).unwrap().code > 10_000);
        assert!(compiler(&program).unwrap().starts_with("1."));
    }

    #[test]
    fn the_difference_of_two_images_is_taken_kind_by_kind() {
        let image = |code, data, zeroed| Image { code, data, zeroed };
        assert_eq!(image(9, 5, 1).beyond(image(2, 5, 0)), image(7, 0, 1));
    }

    #[test]
    fn what_is_no_program_is_refused_by_name() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert!(Image::of(&file).unwrap_err().to_string().contains("Cargo.toml"));
    }
}
