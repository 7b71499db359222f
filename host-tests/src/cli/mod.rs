//! The subcommands of `selfcal`: arguments in, text or JSON out.

mod campaign;
mod evaluate;
mod faults;
mod link;
mod record;
mod replay;
mod run;
mod synth;

pub(crate) use campaign::{CampaignArgs, campaign};
pub(crate) use evaluate::{EvaluateArgs, evaluate_all};
pub(crate) use link::{LinkArgs, link};
pub(crate) use record::{RecordArgs, record};
pub(crate) use replay::{ReplayArgs, replay};
pub(crate) use synth::{SynthArgs, synth};
