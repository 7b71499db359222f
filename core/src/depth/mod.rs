//! Yaw of the mount, apart from the apparent yaw of the lens (`ESTIMATOR.md`, section 20). Depth needs it, and rows
//! cannot tell it.
//!
//! Rows measure the sum of both. The mount is as the factory calibration says until the rig changes; the lens stays as
//! it is. A *witness* measures the mount alone.
//!
//! - `yaw`: the two numbers and their covariance. `mount`: the knowledge of them beside the sums of the pairs.
//! - `range`: the witness of a known distance. `motion`: the witness of tracked matches of a moving rig.
//! - `tracks`: the tracked matches of two frames, joined.

pub(crate) mod motion;
pub(crate) mod mount;
pub(crate) mod range;
pub(crate) mod tracks;
pub(crate) mod yaw;

pub use crate::error::{MotionError, RangeError};
pub use mount::Witnessed;
pub use range::{Range, RangeReading};
pub use tracks::Tracks;
