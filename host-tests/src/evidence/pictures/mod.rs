//! Pictures of what a calibration does: rectified pairs, dense disparities before and after, and the
//! estimates on their spheres.

mod comparison;
mod disparity;
mod encode;
mod grey;
mod scene;
mod sgm;
mod sphere;
mod warp;

pub use comparison::{Attempt, Rectification, Scores, WRONG_PX, comparison};
pub use disparity::disparity_figures;
pub use encode::{disparity_picture, missing_picture, pair_picture};
pub use grey::Grey;
pub use scene::PicturedScene;
pub use sgm::Disparities;
pub use sphere::{Estimates, Reach, sphere_figure};
pub use warp::{rectified, turned, warp};
