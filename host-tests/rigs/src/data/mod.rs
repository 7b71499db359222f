//! Recorded data: data sets with known extrinsics, and files of single pairs.

mod csv_file;
mod dataset;
pub mod depths;
mod frame_numbers;
mod frame_rows;
mod geometry;
mod matches;
mod meta;
mod pairs_folder;
mod quarter_turns;
pub mod ranges;
mod rigs;
mod sign;
pub mod tracked;
mod turned_view;

pub use dataset::Dataset;
pub use frame_rows::{FrameRows, LONGEST_LINE};
pub use geometry::{Rays, Rows, in_f64, matrix, rows};
pub use matches::Match;
pub use meta::{LensModel, Meta, check_camera_matrix};
pub use pairs_folder::PairsFolder;
pub use quarter_turns::QuarterTurns;
pub use rigs::Rig;
pub use sign::WrongSign;
pub use turned_view::{Turn, TurnedCamera, TurnedView};
