//! The matcher's side of the link: data sets as frames, and a wire that does to them what wires do.

mod campaign;
mod faults;
mod recording;

pub use campaign::{Campaign, Tally};
pub use faults::{Faults, FaultyWire, Sent};
pub use recording::{Recording, Sender, counted};
