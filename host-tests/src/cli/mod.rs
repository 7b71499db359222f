//! The subcommands of `selfcal`: arguments in, text or JSON out.

use std::str::FromStr;

mod bench;
mod campaign;
mod evaluate;
mod export;
mod faults;
mod import;
mod link;
mod record;
mod replay;
mod run;
mod setup;
mod source;
mod synth;

pub(crate) use bench::{BenchArgs, bench};
pub(crate) use campaign::{CampaignArgs, campaign};
pub(crate) use evaluate::{EvaluateArgs, evaluate_all};
pub(crate) use export::{ExportArgs, export};
pub(crate) use import::{ImportArgs, import};
pub(crate) use link::{LinkArgs, link};
pub(crate) use record::{RecordArgs, record};
pub(crate) use replay::{ReplayArgs, replay};
pub(crate) use synth::{SynthArgs, synth};

/// `N` numbers with commas between.
fn numbers<T: FromStr, const N: usize>(text: &str) -> Result<[T; N], String> {
    let numbers: Vec<T> = text
        .split(',')
        .map(|number| number.trim().parse().map_err(|_| format!("`{number}` is not a number here")))
        .collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|_| format!("{N} numbers with commas between are needed"))
}
