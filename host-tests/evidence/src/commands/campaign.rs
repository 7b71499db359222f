//! `evidence campaign`.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use sim::run::LensTracking;
use strum::VariantArray;

use crate::campaigns::{ALARMS, Request, Table, all, named};

/// Measure a campaign with any number of runs, and print its figures.
///
/// A case is a scene; each of its runs has a seed of its own. Angles are in radians. The page of the campaign in
/// host-tests/evidence/tables describes the measurement; without options it repeats the figures of its table.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  evidence campaign single --only '256 matches' noise
  evidence campaign fused --trials 1000 --pairs 20
  evidence campaign lenses --only lens/f_r --lens compensate --csv lenses.csv
  evidence campaign rest --set my_recording     false alarms an hour of a recording of your own")]
pub struct CampaignArgs {
    #[arg(value_parser = names())]
    name: String,

    /// Runs of each case and seed, instead of those of the table.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    trials: Option<u32>,

    /// Pairs of each run, instead of those of the case.
    #[arg(long)]
    pairs: Option<usize>,

    /// Seed of the first run, instead of those of the table.
    #[arg(long)]
    seed: Option<u64>,

    /// Trust in the lens models. With compensate the errors of R and t refer to the corrected cameras.
    #[arg(long, value_parser = lens_tracking())]
    lens: Option<LensTracking>,

    /// Cases whose name starts with this; default all.
    #[arg(long, value_name = "PREFIX", num_args = 1..)]
    only: Vec<String>,

    /// Recordings for knocks and rest, instead of the shipped ones: folders of data sets with reference extrinsics.
    #[arg(long = "set", value_name = "FOLDER", num_args = 1..)]
    sets: Vec<PathBuf>,

    /// Write all figures into this file, one row for each case.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(all().into_iter().map(|campaign| campaign.name))
}

fn lens_tracking() -> impl TypedValueParser<Value = LensTracking> {
    let names = LensTracking::VARIANTS.iter().map(ToString::to_string);
    PossibleValuesParser::new(names).try_map(|name| name.parse())
}

/// Runs `evidence campaign`.
pub(crate) fn campaign(args: &CampaignArgs) -> Result<()> {
    ensure!(
        args.sets.is_empty() || ALARMS.contains(&args.name.as_str()),
        "--set is for {}: {} makes its scenes, or has its recordings",
        ALARMS.join(" and "),
        args.name
    );
    let mut all = named(std::slice::from_ref(&args.name))?;
    let campaign = all.pop().context("a name has a campaign")?;
    let request = campaign.request(false).context("all cases are requested")?;
    let request = Request {
        trials: args.trials.unwrap_or(request.trials),
        seeds: args.seed.map_or(request.seeds, |seed| vec![seed]),
        pairs: args.pairs,
        lens: args.lens.unwrap_or(request.lens),
        only: args.only.clone(),
        recordings: args.sets.clone(),
    };
    let rows = campaign.rows(&request)?;
    if let Some(file) = &args.csv {
        Table::of(&rows, None).write_csv(file)?;
    }
    write!(io::stdout(), "{}", Table::of(&rows, Some(&campaign.columns())).aligned())?;
    Ok(())
}
