//! The subcommands of `selfcal`: arguments in, text or JSON out.

mod replay;
mod run;
mod synth;

pub(crate) use replay::{ReplayArgs, replay};
pub(crate) use synth::{SynthArgs, synth};
