//! The paper's figures of rectified pairs and dense disparities, by all methods.

mod comparison;
mod disparity;
mod knocked;
mod scene;

pub use comparison::{Attempt, Scores, WRONG_PX, comparison};
pub use disparity::disparity_figures;
pub use knocked::{KNOCKED, Knocked, knocked};
pub use scene::PicturedScene;
