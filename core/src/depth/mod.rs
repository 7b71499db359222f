//! What depth needs and rows cannot tell: the yaw of the mount, apart from the apparent yaw of the lens
//! (`ESTIMATOR.md`, section 20).
//!
//! Rows measure the sum of both. The mount is where the factory calibration says until the rig changes; the lens stays
//! as it is. A *witness* measures the mount alone.
//!
//! - `yaw`: the two numbers and their covariance. `mount`: what is known of them beside the sums of the pairs.
//! - `range`: the witness of a known distance. `motion`: that of tracked matches of a rig that moves.

pub(crate) mod motion;
pub(crate) mod mount;
pub(crate) mod range;
pub(crate) mod yaw;

pub use crate::error::{MotionError, RangeError};
pub use mount::Witnessed;
pub use range::{Range, RangeReading};
