//! The files of a bag, in order: a file, or the folder that `ros2 bag record` or a split recording makes.

use std::fs;
use std::fs::File;
use std::io::Read;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use super::parts::{Part, Parts, TakePart};
use super::{mcap, ros1};
use crate::source::fields::Encoding;

/// Longest `metadata.yaml`, bytes.
const LONGEST: u64 = 4 << 20;

/// First bytes of a file of SQLite.
const SQLITE: &[u8] = b"SQLite format 3\0";

/// Format of the files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Mcap,
    Ros1,
    Sqlite,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Mcap, Self::Ros1, Self::Sqlite];

    fn ending(self) -> &'static str {
        match self {
            Self::Mcap => "mcap",
            Self::Ros1 => "bag",
            Self::Sqlite => "db3",
        }
    }

    /// The kind of a file by its first bytes, or else by its ending. `None` if it is no bag.
    fn of(file: &Path) -> Option<Self> {
        let mut start = Vec::new();
        // A file that cannot be opened is reported when it is read.
        let _ = File::open(file).map(|file| file.take(16).read_to_end(&mut start));
        let magic = |kind: &Self| {
            start.starts_with(match kind {
                Self::Mcap => mcap::MAGIC,
                Self::Ros1 => ros1::MAGIC,
                Self::Sqlite => SQLITE,
            })
        };
        let named = |kind: &Self| file.extension().is_some_and(|ending| ending == kind.ending());
        Self::ALL.into_iter().find(magic).or_else(|| Self::ALL.into_iter().find(named))
    }

    fn encoding(self) -> Encoding {
        if self == Self::Ros1 { Encoding::Packed } else { Encoding::Cdr }
    }

    fn messages(self, file: &Path, out: &mut Parts<'_>) -> Result<ControlFlow<()>> {
        match self {
            Self::Mcap => mcap::messages(file, out),
            Self::Ros1 => ros1::messages(file, out),
            #[cfg(feature = "sqlite")]
            Self::Sqlite => super::sqlite::messages(file, out),
            #[cfg(not(feature = "sqlite"))]
            Self::Sqlite => bail!(
                "is a bag of SQLite, which this build does not read: convert it to MCAP (`ros2 bag convert`, with \
                 storage_id: mcap)"
            ),
        }
    }
}

/// The files of a bag.
#[derive(Debug, Clone)]
pub(crate) struct Recording {
    name: String,
    kind: Kind,
    files: Vec<PathBuf>,
    /// Number of messages that `metadata.yaml` states.
    stated: Option<u64>,
}

impl Recording {
    /// The bag at a place: a file, or a folder with `metadata.yaml`. `None` if there is no bag.
    ///
    /// # Errors
    /// If `metadata.yaml` cannot be read, or names files that are missing or compressed.
    pub(crate) fn at(place: &Path) -> Result<Option<Self>> {
        let name = place.display().to_string();
        if place.is_file() {
            let files = vec![place.to_owned()];
            return Ok(Kind::of(place).map(|kind| Self { name, kind, files, stated: None }));
        }
        let metadata = place.join("metadata.yaml");
        let text = if metadata.is_file() { text(&metadata)? } else { String::new() };
        if !text.contains("rosbag2_bagfile_information") {
            return Ok(None);
        }
        let about = Metadata::of(&text).with_context(|| metadata.display().to_string())?;
        let files = about.files(place).with_context(|| metadata.display().to_string())?;
        Self::of(name, files, about.message_count).map(Some)
    }

    /// The bag files of a folder without `metadata.yaml`, in the order of their numbers: a recorder that was killed
    /// writes none. `None` if the folder has no bag files.
    ///
    /// # Errors
    /// If the folder cannot be listed, or has bags of several kinds.
    pub(crate) fn in_folder(place: &Path) -> Result<Option<Self>> {
        let name = place.display().to_string();
        let entries = fs::read_dir(place).with_context(|| format!("cannot list {name}"))?;
        let mut files: Vec<PathBuf> =
            entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
        let is_bag = |file: &PathBuf| {
            Kind::ALL.iter().any(|kind| file.extension().is_some_and(|e| e == kind.ending()))
        };
        files.retain(is_bag);
        files.sort_by_key(|file| numbered(file));
        if files.is_empty() { Ok(None) } else { Self::of(name, files, None).map(Some) }
    }

    fn of(name: String, files: Vec<PathBuf>, stated: Option<u64>) -> Result<Self> {
        let kinds: Vec<Option<Kind>> = files.iter().map(|file| Kind::of(file)).collect();
        let Some(&Some(kind)) = kinds.first() else { bail!("{name}: its files are no bags") };
        ensure!(
            kinds.iter().all(|of| *of == Some(kind)),
            "{name}: bags of several kinds: give one of its files"
        );
        Ok(Self { name, kind, files, stated })
    }

    /// Name for people.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Hands out the parts of all files.
    ///
    /// # Errors
    /// If a file cannot be opened.
    pub(super) fn read(&self, take: TakePart<'_>) -> Result<()> {
        let mut whole = Some(0);
        for file in &self.files {
            let name = file.file_name().unwrap_or_default().display().to_string();
            let mut out = Parts::new(name, self.kind.encoding(), take);
            // `Break` without an end by the receiver means that the rest of this file is lost.
            let _ =
                self.kind.messages(file, &mut out).with_context(|| file.display().to_string())?;
            if out.is_ended() {
                return Ok(());
            }
            whole = whole.zip(out.whole()).map(|(before, here)| before + here);
        }
        if let (Some(count), Some(stated)) = (whole, self.stated)
            && count != stated
        {
            let why = format!("{count} messages, where metadata.yaml states {stated}");
            // This is the last part, so the answer does not matter.
            let _ = take(Part::Damaged(why));
        }
        Ok(())
    }
}

/// `metadata.yaml`.
#[derive(Debug, Deserialize)]
struct Metadata {
    rosbag2_bagfile_information: Information,
}

#[derive(Debug, Deserialize)]
struct Information {
    #[serde(default)]
    relative_file_paths: Vec<String>,
    #[serde(default)]
    compression_format: String,
    #[serde(default)]
    compression_mode: String,
    message_count: Option<u64>,
}

impl Metadata {
    fn of(text: &str) -> Result<Information> {
        let all: Self = serde_saphyr::from_str(text).ok().context(
            "is not as `ros2 bag record` writes it: `ros2 bag reindex` writes it again; or give the files of the bag",
        )?;
        Ok(all.rosbag2_bagfile_information)
    }
}

impl Information {
    /// The files, in order, which are in the folder: early versions wrote its name too.
    fn files(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        let Self { relative_file_paths: names, compression_format, compression_mode, .. } = self;
        ensure!(
            compression_format.is_empty() || compression_mode.is_empty(),
            "the bag is compressed as a whole ({compression_format}): `ros2 bag convert` writes it without compression_mode; \
             compression within MCAP is read"
        );
        ensure!(!names.is_empty(), "names no files: `ros2 bag reindex` writes it again");
        let file = |name: &String| -> Result<PathBuf> {
            let file = folder.join(Path::new(name).file_name().unwrap_or_default());
            ensure!(file.is_file(), "names {name}, which is not in the folder");
            Ok(file)
        };
        names.iter().map(file).collect()
    }
}

fn text(path: &Path) -> Result<String> {
    let name = path.display();
    let file = File::open(path).with_context(|| format!("cannot open {name}"))?;
    let mut text = String::new();
    let read = file.take(LONGEST).read_to_string(&mut text);
    read.with_context(|| format!("cannot read {name}"))?;
    Ok(text)
}

/// The parts of a name that order the files of a split recording: the name before the number at its end, the number.
fn numbered(file: &Path) -> (String, u64) {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = stem.trim_end_matches(|c: char| c.is_ascii_digit());
    (name.to_owned(), stem[name.len()..].parse().unwrap_or(0))
}
