//! The argument `--rig FILE ...`, which may be repeated: the files after each `--rig` belong to one rig.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches, value_parser};

/// Largest number of files of one rig.
const MOST: usize = 3;

/// The files of each given rig.
#[derive(Debug, Clone, Default)]
pub(crate) struct RigFiles(pub(crate) Vec<Vec<PathBuf>>);

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
