//! Generated data: scenes of known rigs, and scenarios over many pairs.
//!
//! Scenes take functions such as `sin` and `exp` from `libm`, so that they have the same bits on every system.

mod depth;
mod disturbance;
mod fence;
mod flight;
mod grid;
mod lens_error;
mod mistake;
mod normal;
mod points;
mod rig;
mod scenario;
mod scenario_kind;
mod scene;
mod scene_dataset;
mod scene_file;
mod witness;

pub use depth::Depth;
pub use disturbance::Disturbance;
pub use fence::Fence;
pub use grid::Grid;
pub use lens_error::{LensError, LensErrors};
pub use mistake::Mistake;
pub use rig::{five_degrees_off, rig};
pub use scenario::{Scenario, ScenarioPair};
pub use scenario_kind::ScenarioKind;
pub use scene::{Scene, SynthPair};
pub use scene_file::SceneFile;
pub use witness::{Motion, Rangefinder, Witnessed, Witnesses};
