//! Which recording a subcommand takes.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use host_tests::data::conventions::{self, Unknowns};
use host_tests::data::{Dataset, Meta, TurnedCamera, TurnedView};
use host_tests::wire::DecodedStream;

/// A recorded data set, or a recorded stream of frames.
#[derive(Debug, Args)]
pub(crate) struct Source {
    /// Folder of a data set, or the name of one that comes with the project: opencv_chess_corners,
    /// opencv_chess_sift, motorcycle_sift, aloe_sift. Or the file of a stream.
    #[arg(value_name = "DIR|FILE")]
    set: PathBuf,

    /// Rig of a stream: a meta.json, a data set that has one, or the files of OpenCV, Kalibr or ROS
    /// that `selfcal import` reads.
    #[arg(long, value_name = "FILE|DIR")]
    rig: Option<PathBuf>,

    /// Turn a view, as if its camera looked up (top), down, left or right: of the left one R becomes R Rot^T,
    /// of the right one Rot R, and t Rot t. Points that leave the image are dropped. A rectified set is
    /// evidence only if turned.
    #[arg(long, value_enum)]
    view: Option<TurnedView>,

    /// Which camera is turned. Both: the left one as the view says, the right one as the next of top, right,
    /// bottom, left.
    #[arg(long, value_enum, default_value_t, requires = "view")]
    turned: TurnedCamera,

    /// By how much the view is turned.
    #[arg(long, default_value_t = 5.0, requires = "view", value_name = "D")]
    degrees: f64,
}

impl Source {
    /// The place that was given.
    pub(super) fn place(&self) -> &Path {
        &self.set
    }

    /// The recording, its view turned if asked.
    pub(super) fn read(&self) -> Result<Dataset> {
        ensure!(self.degrees.abs() <= 45.0, "a view can be turned by at most 45 degrees");
        let set = self.set()?;
        let known = self.view.is_none() || set.meta.has_reference();
        ensure!(known, "--view turns R and t, and {} has none", set.name);
        match self.view {
            Some(view) => view.turn_camera(&set, self.degrees, self.turned),
            None => Ok(set),
        }
    }

    fn set(&self) -> Result<Dataset> {
        if !self.set.is_file() {
            ensure!(self.rig.is_none(), "--rig is for a stream: a data set has a rig of its own");
            return Dataset::find(&self.set);
        }
        let name = self.set.display();
        let rig = self.rig.as_ref();
        let rig =
            rig.with_context(|| format!("{name} is a stream: --rig says of which cameras"))?;
        let bytes = fs::read(&self.set).with_context(|| format!("cannot read {name}"))?;
        let recording = DecodedStream::decode(&bytes);
        eprintln!("{name}: {recording}");
        recording.dataset(&name.to_string(), self::rig(rig)?)
    }
}

fn rig(place: &Path) -> Result<Meta> {
    let yaml = place.extension().is_some_and(|e| e == "yaml" || e == "yml");
    if yaml || (place.is_dir() && !place.join("meta.json").exists()) {
        return conventions::import(&[place], Unknowns::default());
    }
    Dataset::find_meta(place)
}
