//! The matcher's side of the link: data sets as frames, and a wire that does to them what wires do.

mod bus;
mod campaign;
mod faults;
mod recording;

pub use bus::{DataReady, SimMatcher, SimReady, SimSpi};
pub use campaign::{Campaign, Tally};
pub use faults::{Faults, FaultyWire, Sent};
pub use recording::{Recording, Sender, counted, quantised};
