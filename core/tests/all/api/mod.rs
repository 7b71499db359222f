//! The public API on generated rigs.

mod applying;
pub(crate) mod bad_input;
mod bias;
mod compensation;
mod counted_once;
pub(crate) mod depth;
pub(crate) mod disturbed;
mod documentation;
mod earned;
mod far;
mod history;
mod homography;
mod judgement;
mod lens;
mod lens_change;
mod mistakes;
mod moments;
mod one_scene;
pub(crate) mod presets;
mod robust;
mod row_grid;
pub(crate) mod scene;
mod selection;
#[cfg(feature = "serde")]
mod serialization;
mod supervision;
mod texts;
// The traces hold for glibc: `powf`, which generates the depths, has other last bits on other platforms.
#[cfg(target_env = "gnu")]
mod traces;
mod verdict;
pub(crate) mod vibration;
pub(crate) mod witness;
