//! Grey images before and after a calibration: rectified pairs, dense disparities, encoded for a page.

mod encode;
mod grey;
mod rectification;
mod sgm;
mod warp;

pub use encode::{before_and_after, disparity_picture, pair_picture};
pub use grey::Grey;
pub use rectification::{Rectification, StereoImages};
pub use sgm::{Disparities, share};
pub use warp::{projected, ray_of, rectified, turned, warp};
