//! The common arguments of `images` and `check`: images, rig and matcher.

use std::path::PathBuf;

use clap::{
    Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches, ValueEnum, value_parser,
};
use images::matcher::MatcherConfig;
use images::rig::{Cut, RigRequest};
use images::source::Source;
use rigs::formats::Unknowns;

use crate::args::rig::RigArgs;

/// Images and their rig.
#[derive(Debug, Args)]
pub(crate) struct SourceArgs {
    /// A folder, a bag (*.mcap, *.db3, ROS 1's *.bag, or the folder of `ros2 bag record`), or the left and the right
    /// folder, file or quoted pattern. Or images of the project: chess, motorcycle, aloe. Or a folder or pattern of pictures with both cameras side by
    /// side.
    #[arg(required = true, num_args = 1..=2, value_name = "SOURCE")]
    pub(super) source: Vec<PathBuf>,

    #[command(flatten)]
    pub(super) rigs: RigFiles,

    #[command(flatten)]
    pub(super) lacks: RigArgs,

    /// Guess the calibration from this focal length, px. Without it the focal length of the EXIF data is used.
    #[arg(long, value_name = "PX", conflicts_with = "rig")]
    pub(super) focal: Option<f64>,

    /// Topic of the left images of a bag, if several are possible.
    #[arg(long, value_name = "TOPIC")]
    pub(super) left_topic: Option<String>,

    /// Topic of the right images.
    #[arg(long, value_name = "TOPIC")]
    pub(super) right_topic: Option<String>,

    /// Each picture has both cameras side by side, the left one in the left half. By default this holds for pictures as
    /// wide as two.
    #[arg(long)]
    pub(super) side_by_side: bool,

    /// Origin of images whose size differs from the rig's: scaled, cropped from the middle (centre), or cropped at X,Y
    /// [default: scaled if they have the same shape, unless many more matches fit a crop from the middle].
    #[arg(long, value_parser = cut, value_name = "scaled|centre|X,Y")]
    pub(super) cut: Option<Cut>,

    /// Whether image files are turned by their EXIF orientation [default: upright, unless the rig belongs to the images
    /// as stored].
    #[arg(long, value_enum)]
    pub(super) exif: Option<Exif>,

    /// Largest difference of the time stamps of a pair, s.
    #[arg(long, default_value_t = 0.005, value_name = "S")]
    pub(super) tolerance: f64,

    /// Take the pairs of a bag from this time on, s after its first image.
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub(super) start: Option<f64>,

    /// Take the pairs of a bag up to this time, s after its first image.
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub(super) end: Option<f64>,

    /// Take every so many pairs.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = at_least_one)]
    pub(super) every: usize,

    /// Take at most so many pairs.
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub(super) pairs: Option<usize>,

    /// Largest turn of the cameras since the rig was calibrated, degrees: half the band that is searched around the
    /// expected rows.
    #[arg(long, default_value_t = MatcherConfig::default().prior_deg, value_name = "D")]
    pub(super) prior: f64,

    /// Start from a wrong calibration: the right camera of the rig is turned up by this angle, degrees, at most by the
    /// prior. If several rigs are given, the first is turned. Shows on images of a good rig how a knock is found.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub(super) knock: Option<f64>,

    /// Corners sought in each image.
    #[arg(long, default_value_t = MatcherConfig::default().keypoints, value_name = "N", value_parser = at_least_one)]
    pub(super) keypoints: usize,
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| format!("`{text}` is not a number from 1"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s: &f64| *s >= 0.0 && s.is_finite());
    seconds.ok_or_else(|| format!("`{text}` is not a time from 0 s"))
}

fn cut(text: &str) -> Result<Cut, String> {
    let place = || {
        let (x, y) = text.split_once(',')?;
        Some(Cut::At([x.trim().parse().ok()?, y.trim().parse().ok()?]))
    };
    match text {
        "scaled" => Ok(Cut::Scaled),
        "centre" | "center" => Ok(Cut::Centre),
        _ => place().ok_or_else(|| "scaled, centre or X,Y is needed".into()),
    }
}

/// Treatment of the EXIF orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Exif {
    /// Turned by the EXIF orientation, as most programs show them and OpenCV reads them.
    Upright,
    /// As stored.
    Stored,
}

impl SourceArgs {
    /// The files of each given rig.
    pub(crate) fn rigs(&self) -> &[Vec<PathBuf>] {
        &self.rigs.0
    }

    /// The request for a rig from these files, with the user's options.
    pub(super) fn request(&self, source: &Source, files: Vec<PathBuf>) -> RigRequest {
        let given = self.lacks.unknowns();
        RigRequest {
            files,
            unknowns: Unknowns { cameras: given.cameras.or(source.cameras), ..given },
            focal_px: self.focal,
            cut: self.cut.unwrap_or_default(),
        }
    }
}

/// Largest number of files of one rig.
const MOST: usize = 3;

/// The files of each given rig.
#[derive(Debug, Clone, Default)]
pub(super) struct RigFiles(pub(super) Vec<Vec<PathBuf>>);

impl FromArgMatches for RigFiles {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let each = matches.get_occurrences::<PathBuf>("rig").into_iter().flatten();
        Ok(Self(each.map(|files| files.cloned().collect()).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for RigFiles {
    fn augment_args(command: Command) -> Command {
        command.arg(
            Arg::new("rig")
                .long("rig")
                .value_name("FILE")
                .num_args(1..=MOST)
                .action(ArgAction::Append)
                .value_parser(value_parser!(PathBuf))
                .help(
                    "The calibration of the rig: its files, a meta.json, or a data set; `selfcal import --help` lists the formats. \
                     It wins over what comes with the images, which is then not read [default: the one beside the images]. \
                     `check` takes it as often as there are candidates",
                ),
        )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}
