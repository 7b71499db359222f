//! The recording of `replay` and `export`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use clap::Args;
use rigs::data::{Dataset, Meta, Turn, TurnedCamera, TurnedView};
use rigs::read_rig;

use super::parse::choice;
use super::rig::{RigArgs, tell_doubts};
use crate::stream::Streamed;

/// A recorded data set, or a recorded stream of frames.
#[derive(Debug, Args)]
pub(crate) struct RecordingArgs {
    /// Folder of a data set, or the name of one that comes with the project: opencv_chess_corners,
    /// opencv_chess_sift, motorcycle_sift, aloe_sift, oak_sift. Or a file of matches by frame, or of a
    /// stream; `-` is standard input.
    #[arg(value_name = "DIR|FILE|-")]
    set: PathBuf,

    /// Rig of a file or of standard input: a meta.json, a data set with one, or files of any format that `selfcal
    /// import` reads [default: the meta.json beside the file].
    #[arg(long, value_name = "FILE|DIR", num_args = 1..=3)]
    rig: Vec<PathBuf>,

    #[command(flatten)]
    lacks: RigArgs,

    /// Turn a view, as if its camera looked up (top), down, left or right. For the left view R becomes R Rot^T; for the
    /// right one R becomes Rot R and t Rot t. Points that leave the image are dropped. A rectified set is evidence only
    /// if turned.
    #[arg(long, value_parser = choice::<TurnedView>())]
    view: Option<TurnedView>,

    /// Which camera is turned. Both: the left one by the view, the right one by the next of top, right, bottom, left.
    #[arg(long, value_parser = choice::<TurnedCamera>(), default_value_t, requires = "view")]
    turned: TurnedCamera,

    /// Angle of the turn, degrees.
    #[arg(long, default_value_t = 5.0, requires = "view", value_name = "D")]
    degrees: f64,
}

impl RecordingArgs {
    /// The place that was given.
    pub(crate) fn place(&self) -> &Path {
        &self.set
    }

    /// Whether a view is turned, which drops matches: then rows of a pair differ from those of its file.
    pub(crate) fn is_turned(&self) -> bool {
        self.view.is_some()
    }

    /// The recording, its view turned if asked.
    pub(crate) fn open(&self) -> Result<Recording> {
        ensure!(self.degrees.abs() <= 45.0, "a view can be turned by at most 45 degrees");
        let recording = self.recording()?;
        let Some(view) = self.view else { return Ok(recording) };
        let (name, meta) = match &recording {
            Recording::Held(set) => (&set.name, &set.meta),
            Recording::Streamed(stream) => (&stream.name, &stream.meta),
        };
        ensure!(meta.has_reference(), "--view turns R and t, which {name} lacks");
        let turn = Turn::new(meta, view, self.degrees, self.turned)?;
        Ok(match recording {
            Recording::Held(set) => Recording::Held(turn.set(&set)),
            Recording::Streamed(stream) => Recording::Streamed(stream.turned(turn)),
        })
    }

    /// As [`Self::open`], with all pairs in memory.
    pub(crate) fn read(&self) -> Result<Dataset> {
        match self.open()? {
            Recording::Held(set) => Ok(set),
            Recording::Streamed(stream) => stream.collect(),
        }
    }

    fn recording(&self) -> Result<Recording> {
        let piped = self.set == Path::new("-");
        if !piped && (self.set.is_dir() || !self.set.exists()) {
            let set = Dataset::find(&self.set)?;
            ensure!(
                self.rig.is_empty(),
                "--rig is for a file or a pipe: a data set has a rig of its own"
            );
            return Ok(Recording::Held(set));
        }
        let meta = match self.rig.as_slice() {
            [] if piped => bail!("standard input has no cameras: give them with --rig"),
            [] => rig_beside(&self.set)?,
            places => {
                let meta = read_rig(places, self.lacks.unknowns())?;
                tell_doubts(&meta);
                meta
            }
        };
        Ok(Recording::Streamed(Streamed::open(&self.set, meta)?))
    }
}

/// Kinds of recordings.
pub(crate) enum Recording {
    /// A data set.
    Held(Dataset),
    /// Pairs that arrive one by one.
    Streamed(Streamed),
}

/// The rig of `meta.json` in the folder of a file. An error if the rig moves (`rigs.csv` is there).
fn rig_beside(file: &Path) -> Result<Meta> {
    let name = file.display();
    let meta = file.with_file_name("meta.json");
    ensure!(meta.is_file(), "{name} has no meta.json beside it: give the cameras with --rig");
    ensure!(
        !file.with_file_name("rigs.csv").exists(),
        "the rig of {name} moves: replay its folder, whose rigs.csv has the rig of each pair, or give --rig"
    );
    Dataset::find_meta(&meta)
}
