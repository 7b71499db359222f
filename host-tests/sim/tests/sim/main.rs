//! The calibrator on recorded and generated data.

mod compensate;
mod creeping;
mod deviations;
mod falsified_lens;
mod golden;
mod parked;
mod records;
mod scenarios;
mod synthetic_paper;
mod synthetic_robust;
mod wide_lenses;
mod wire;
