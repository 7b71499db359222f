//! Files as text: one that is written, and several that are read together.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde::de::{DeserializeOwned, IgnoredAny};

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
    /// If one of the files exists, before anything is written, or cannot be written.
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

/// YAML files that tell of one rig together.
#[derive(Debug, Clone)]
pub struct Files(Vec<File>);

#[derive(Debug, Clone)]
struct File {
    path: PathBuf,
    text: String,
    keys: Vec<String>,
}

impl Files {
    /// Reads files; a folder stands for its `*.yaml` and `*.yml`.
    ///
    /// # Errors
    /// Names the file, and the line that is not YAML.
    pub fn read(places: &[impl AsRef<Path>]) -> Result<Self> {
        let mut paths = Vec::new();
        for place in places {
            let place = place.as_ref();
            if place.is_dir() {
                paths.extend(yaml_of(place)?);
            } else {
                paths.push(place.to_path_buf());
            }
        }
        let read = |path: PathBuf| -> Result<(PathBuf, String)> {
            let text = fs::read_to_string(&path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            Ok((path, text))
        };
        Self::of(paths.into_iter().map(read).collect::<Result<_>>()?)
    }

    /// Files that are read already, with their names.
    ///
    /// # Errors
    /// Names the file, and the line that is not YAML.
    pub fn of(texts: Vec<(PathBuf, String)>) -> Result<Self> {
        let parse = |(path, text): (PathBuf, String)| -> Result<File> {
            let name = path.display();
            // OpenCV's header is not of YAML, and older files have no `---` after it: a comment.
            let text = as_yaml(text.replacen("%YAML:", "#YAML:", 1));
            #[expect(clippy::zero_sized_map_values, reason = "values are passed over")]
            let keys: BTreeMap<String, IgnoredAny> = serde_saphyr::from_str(&text)
                .with_context(|| format!("cannot understand {name}"))?;
            Ok(File { text, keys: keys.into_keys().collect(), path })
        };
        Ok(Self(texts.into_iter().map(parse).collect::<Result<_>>()?))
    }

    /// Whether one of them has a key.
    pub(super) fn have(&self, key: &str) -> bool {
        self.0.iter().any(|file| file.keys.iter().any(|k| k == key))
    }

    /// All of them, understood, each with its name.
    pub(super) fn parsed<T: DeserializeOwned>(&self) -> Result<Vec<(String, T)>> {
        let parse = |file: &File| {
            let name = file.path.display().to_string();
            let content = serde_saphyr::from_str(&file.text)
                .with_context(|| format!("cannot understand {name}"))?;
            Ok((name, content))
        };
        self.0.iter().map(parse).collect()
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

/// Middlebury's `name=value` as YAML; anything else as it is.
fn as_yaml(text: String) -> String {
    if !text.trim_start().starts_with("cam0=") {
        return text;
    }
    let line = |line: &str| match line.split_once('=') {
        Some((name, value)) if value.starts_with('[') => format!("{name}: \"{value}\"\n"),
        Some((name, value)) => format!("{name}: {value}\n"),
        None => format!("{line}\n"),
    };
    text.lines().map(|one| line(one.trim())).collect()
}

fn yaml_of(dir: &Path) -> Result<Vec<PathBuf>> {
    let name = dir.display();
    let entries = fs::read_dir(dir).with_context(|| format!("cannot list {name}"))?;
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| entry.map(|e| e.path())).collect::<std::io::Result<_>>()?;
    paths.retain(|path| path.extension().is_some_and(|e| e == "yaml" || e == "yml"));
    paths.sort();
    ensure!(!paths.is_empty(), "no *.yaml or *.yml in {name}");
    Ok(paths)
}
