//! Yaw of the mount, separated from the apparent yaw of the lens (`ESTIMATOR.md`, section 20). Depth needs the yaw of
//! the mount, and row offsets alone cannot determine it.
//!
//! Row offsets measure the sum of the two yaws. The estimate assumes that the yaw of the mount starts at the factory yaw
//! and walks, and that the yaw of the lens does not change. A *witness* measures the mount alone.
//!
//! - `pose`: poses of the mount and of the rows. `yaw`: the two yaws and their covariance. `bank`: filters for a mount
//!   that rests, drifts or is knocked. `scatter`: how much the yaw of the rows scatters from pair to pair. `mount`: what
//!   factory calibration, pairs and witnesses tell.
//! - `range`: the witness of a known distance. `motion`: the witness of tracked matches of a moving rig.
//! - `tracks`: joins the tracked matches of two frames.

mod bank;
pub(crate) mod motion;
pub(crate) mod mount;
pub(crate) mod pose;
pub(crate) mod range;
mod scatter;
pub(crate) mod tracks;
pub(crate) mod yaw;

pub use crate::error::{MotionError, RangeError};
pub use mount::Witnessed;
pub use range::{Range, RangeReading};
pub use tracks::Tracks;
