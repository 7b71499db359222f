//! `cargo ablation`: measures what each mechanism of the estimator buys.

use anyhow::Result;
use clap::Parser;

fn main() -> Result<()> {
    selfcal_evidence::Ablation::parse().run()
}
