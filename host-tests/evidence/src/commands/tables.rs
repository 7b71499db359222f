//! `evidence tables`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use clap::Args;

use crate::campaigns::{Compared, Table, named};

/// Measure the tables of the campaigns again: write them, or compare them with the committed ones.
///
/// A table is NAME.csv, and NAME.md, whose words above the table stay. All tables take about ten minutes on two idle
/// cores; each is written as soon as it is measured. With --check nothing is written, and a figure that differs by
/// more than chance fails: by more than 4 standard errors, which are sqrt(1/2n) of an RMS over n runs, 1.2/sqrt(n) of a
/// median, binomial of a share, Poisson of a count, and none of recorded data.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  evidence tables
  evidence tables fused locks
  evidence tables --check
  evidence tables --check --quick")]
pub struct TablesArgs {
    /// Names of campaigns; default all.
    names: Vec<String>,

    /// Compare with the committed tables, and fail where a figure differs by more than chance.
    #[arg(long)]
    check: bool,

    /// Only the cases that take seconds.
    #[arg(long, requires = "check")]
    quick: bool,

    /// Folder of the tables [default: host-tests/evidence/tables].
    #[arg(long, value_name = "DIR")]
    dir: Option<PathBuf>,
}

/// The folder of the committed tables.
pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tables")
}

/// Runs `evidence tables`.
pub(crate) fn tables(args: &TablesArgs) -> Result<()> {
    let mut out = io::stdout();
    let dir = args.dir.clone().unwrap_or_else(folder);
    let mut differences = Vec::new();
    for campaign in named(&args.names)? {
        let Some(request) = campaign.request(args.quick) else { continue };
        let rows = campaign.rows(&request)?;
        if !args.check {
            Table::of(&rows, Some(&campaign.columns())).write(campaign.name, &dir)?;
            if let Some(chart) = campaign.chart {
                page::write(&dir.join(format!("{}.svg", campaign.name)), &chart(&rows))?;
            }
            writeln!(out, "{}: written", campaign.name)?;
            continue;
        }
        let committed = Table::read(&dir.join(format!("{}.csv", campaign.name)))?;
        let Compared { equal, near, differences: found } =
            committed.compare(&campaign, &rows, !args.quick);
        writeln!(
            out,
            "{}: {equal} equal, {near} within chance, {} beyond",
            campaign.name,
            found.len()
        )?;
        differences.extend(found);
    }
    ensure!(
        differences.is_empty(),
        "figures differ by more than chance:\n{}",
        differences.join("\n")
    );
    Ok(())
}
