//! Pictures, and the solver of the timing comparison.

mod general_solver;
mod pictures;
