//! Pictures, and the solver that the timings compare with.

mod general_solver;
mod pictures;
