//! The subcommands of `selfcal`: arguments in, text or JSON out.

mod campaign;
mod replay;
mod run;
mod synth;

pub(crate) use campaign::{CampaignArgs, campaign};
pub(crate) use replay::{ReplayArgs, replay};
pub(crate) use synth::{SynthArgs, synth};
