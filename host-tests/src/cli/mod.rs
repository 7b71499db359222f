//! The subcommands of `selfcal`: arguments in, text or JSON out.

mod bench;
mod campaign;
mod evaluate;
mod export;
mod faults;
mod images;
mod import;
mod input;
mod link;
mod parse;
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
pub(crate) use images::{ImagesArgs, hand_over};
pub(crate) use import::{ImportArgs, import};
pub(crate) use link::{LinkArgs, link};
pub(crate) use record::{RecordArgs, record};
pub(crate) use replay::{ReplayArgs, replay};
pub(crate) use synth::{SynthArgs, synth};
