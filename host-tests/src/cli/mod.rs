//! The subcommands of `selfcal`: arguments in, text or JSON out.

mod bench;
mod campaign;
mod faults;
mod link;
mod record;
mod replay;
mod run;
mod synth;

pub(crate) use bench::{BenchArgs, bench};
pub(crate) use campaign::{CampaignArgs, campaign};
pub(crate) use link::{LinkArgs, link};
pub(crate) use record::{RecordArgs, record};
pub(crate) use replay::{ReplayArgs, replay};
pub(crate) use synth::{SynthArgs, synth};
