//! The matcher's side of the link: data sets as frames, and a wire with faults.

mod faulty_wire;
mod sender;
mod soak;
mod stream;

pub use faulty_wire::{Faults, FaultyWire, Sent};
pub use sender::{Sender, quantised};
pub use soak::{Soak, SoakCounts};
pub use stream::{Frame, FrameReader, counted};
