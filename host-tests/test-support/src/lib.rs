//! Shared by the tests and simulations of several packages: simulated flash and wire, calls of a program, code of a
//! document, length of a campaign.

pub mod document;
pub mod flash;
mod program;
pub mod wire;

pub use program::{Ended, Program};

/// Whether tests run at full length, for minutes: if the environment variable `CAMPAIGN` is set.
#[must_use]
pub fn is_campaign() -> bool {
    std::env::var_os("CAMPAIGN").is_some()
}

/// Number of runs of a test: `few`, or `many` in a campaign.
#[must_use]
pub fn runs<N>(few: N, many: N) -> N {
    if is_campaign() { many } else { few }
}
