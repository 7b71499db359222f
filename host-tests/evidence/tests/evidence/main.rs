//! Pictures, and the solver that the timings compare with.

mod minpack;
mod pictures;
