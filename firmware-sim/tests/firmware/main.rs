//! The application loop over the simulated bus, and the program as a user calls it.

mod bus;
mod command;
mod readme;
