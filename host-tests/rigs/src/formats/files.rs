//! Files as text: a file to write, and files that are read together.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use super::node::{Node, Value};
use super::syntax;
use crate::bounded;

/// Endings of the rig files of a folder, in the order of preference.
const ENDINGS: [&str; 7] = ["yaml", "yml", "json", "xml", "toml", "txt", "conf"];

/// The files of a COLMAP model that describe its rig.
const COLMAP: [&str; 3] = ["cameras.txt", "rigs.txt", "rig_config.json"];

/// A file to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Document {
    /// Usual name of the file.
    pub name: &'static str,
    /// Its content.
    pub text: String,
}

impl Document {
    /// Writes documents into a folder, which is made.
    ///
    /// # Errors
    /// If one of the files exists, before any is written, or the folder or a file cannot be written.
    pub fn save_all(documents: &[Self], dir: &Path) -> Result<Vec<PathBuf>> {
        let paths: Vec<PathBuf> = documents.iter().map(|d| dir.join(d.name)).collect();
        for path in &paths {
            ensure!(!path.exists(), "{} exists: nothing is overwritten", path.display());
        }
        fs::create_dir_all(dir).with_context(|| format!("cannot make {}", dir.display()))?;
        for (document, path) in documents.iter().zip(&paths) {
            fs::write(path, &document.text)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        Ok(paths)
    }
}

/// Files that describe one rig together.
#[derive(Debug, Clone)]
pub struct Files(Vec<File>);

#[derive(Debug, Clone)]
struct File {
    path: PathBuf,
    root: Node,
}

impl File {
    fn value(&self) -> Value<'_> {
        Value::new(&self.root, self.path.display().to_string())
    }
}

impl Files {
    /// Reads files; a folder stands for its rig files, of one kind only: YAML if there is any.
    ///
    /// # Errors
    /// Names the file that cannot be read or understood; an error of syntax also names the line.
    pub fn read(places: &[impl AsRef<Path>]) -> Result<Self> {
        let mut paths = Vec::new();
        for place in places {
            let place = place.as_ref();
            if place.is_dir() {
                paths.extend(rigs_of(place)?);
            } else {
                paths.push(place.to_path_buf());
            }
        }
        let read = |path: PathBuf| -> Result<(PathBuf, String)> {
            let text = text(&path).with_context(|| format!("cannot read {}", path.display()))?;
            Ok((path, text))
        };
        Self::of(paths.into_iter().map(read).collect::<Result<_>>()?)
    }

    /// Files in memory, with their names.
    ///
    /// # Errors
    /// Names the file that cannot be understood; an error of syntax also names the line.
    pub fn of(texts: Vec<(PathBuf, String)>) -> Result<Self> {
        let parse = |(path, text): (PathBuf, String)| -> Result<File> {
            let name = path.display().to_string();
            let root =
                syntax::parse(&name, &text).with_context(|| format!("cannot understand {name}"))?;
            Ok(File { path, root })
        };
        Ok(Self(texts.into_iter().map(parse).collect::<Result<_>>()?))
    }

    /// The files that have one of these keys with a value.
    pub(super) fn with(&self, keys: &[&str]) -> Vec<Value<'_>> {
        self.values().filter(|file| file.get(keys).is_some()).collect()
    }

    /// The one file that has one of these keys.
    pub(super) fn one(&self, keys: &[&str]) -> Result<Value<'_>> {
        let mut found = self.with(keys);
        let count = found.len();
        ensure!(
            count == 1,
            "{self}: one file with {} is a rig of this format, not {count}; give that file",
            keys.join(" or ")
        );
        found.pop().context("there is one")
    }

    /// The first value of these keys in any of the files.
    pub(super) fn find(&self, keys: &[&str], what: &str) -> Result<Value<'_>> {
        let found = self.values().find_map(|file| file.get(keys));
        found.with_context(|| format!("{self}: {} is missing: expected {what}", keys.join(" or ")))
    }

    /// As [`Self::find`]; `None` if no file has these keys.
    pub(super) fn get(&self, keys: &[&str]) -> Option<Value<'_>> {
        self.values().find_map(|file| file.get(keys))
    }

    pub(super) fn values(&self) -> impl Iterator<Item = Value<'_>> {
        self.0.iter().map(File::value)
    }

    /// Reads the file of that name in the folder of the first file and adds it, unless it is among the files.
    pub(super) fn beside(&mut self, name: &str) -> Result<()> {
        let name = Path::new(name);
        let named =
            |file: &File| file.path.ends_with(name) || file.path.file_name() == name.file_name();
        if self.0.iter().any(named) {
            return Ok(());
        }
        let path = self.0.first().context("no file")?.path.with_file_name(name);
        self.0.extend(Self::read(&[path])?.0);
        Ok(())
    }

    /// The file of that name.
    pub(super) fn named(&self, name: &str) -> Option<Value<'_>> {
        let name = Path::new(name).file_name();
        self.0.iter().find(|file| file.path.file_name() == name).map(File::value)
    }
}

impl fmt::Display for Files {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, file) in self.0.iter().enumerate() {
            write!(f, "{}{}", if i > 0 { ", " } else { "" }, file.path.display())?;
        }
        Ok(())
    }
}

fn text(path: &Path) -> Result<String> {
    syntax::text_of(bounded::bytes(path)?)
}

/// The rig files of a folder: those of a COLMAP model if there are at least two. Otherwise the files with the first of
/// [`ENDINGS`] that occurs, where `yaml` and `yml` count as one.
fn rigs_of(dir: &Path) -> Result<Vec<PathBuf>> {
    let name = dir.display();
    let entries = fs::read_dir(dir).with_context(|| format!("cannot list {name}"))?;
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| entry.map(|e| e.path())).collect::<std::io::Result<_>>()?;
    let colmap: Vec<PathBuf> =
        COLMAP.iter().map(|name| dir.join(name)).filter(|path| path.is_file()).collect();
    if colmap.len() > 1 {
        return Ok(colmap);
    }
    let rank = |path: &PathBuf| {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        ENDINGS.iter().position(|known| *known == ending).map(|rank| rank.max(1))
    };
    let best = paths.iter().filter_map(rank).min();
    paths.retain(|path| path.is_file() && rank(path).is_some() && rank(path) == best);
    paths.sort();
    ensure!(!paths.is_empty(), "no rig file (*.{}) in {name}", ENDINGS.join(", *."));
    Ok(paths)
}
