//! Rates of the faults on the wire, as arguments.

use clap::Args;
use sim::wire::Faults;

/// Shares of all frames, 0 to 1.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct FaultArgs {
    /// Share of the frames that are damaged: flipped bits, lost, inserted or repeated bytes, an overwritten run, a
    /// missing end.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    damaged: Option<f64>,

    /// Share of the frames that never arrive.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    dropped: Option<f64>,

    /// Share of the frames that arrive twice.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    repeated: Option<f64>,

    /// Share of the frames that are followed by idle bytes or noise.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    noise_after: Option<f64>,

    /// Seed of the faults.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
}

impl FaultArgs {
    /// The faults; an option that is not given takes the value of `default`.
    pub(crate) fn faults(&self, default: Faults) -> Faults {
        Faults {
            damaged: self.damaged.unwrap_or(default.damaged),
            dropped: self.dropped.unwrap_or(default.dropped),
            repeated: self.repeated.unwrap_or(default.repeated),
            noise_after: self.noise_after.unwrap_or(default.noise_after),
        }
    }
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|x| (0.0..=1.0).contains(x));
    share.ok_or_else(|| "a share from 0 to 1 is needed".into())
}
