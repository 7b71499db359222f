//! Runs of the calibrator over data: one pair, one run, and many runs.

mod alone;
mod checked;
mod depth_error;
mod estimate;
mod event_line;
mod factory;
mod kept_pairs;
mod lens_tracking;
mod log;
pub mod monte_carlo;
pub mod progress;
mod published;
mod recommendation;
mod reference;
pub mod refused;
mod replay;
mod replayed;
mod step;
mod summary;
mod totals;
pub mod trace;

pub use alone::{PairSolver, report_alone};
pub use checked::{Checked, Checks, Judged};
pub use depth_error::{DEPTHS_M, DepthErrors, ExpectedDepth, metres, offsets};
pub use estimate::{Estimate, Lens, doubt};
pub use event_line::EventLine;
pub use factory::Start;
pub use kept_pairs::KeptPairs;
pub use lens_tracking::LensTracking;
pub use log::RunLog;
pub use recommendation::Recommendation;
pub use reference::Reference;
pub use replay::{Capacity, Feed, Method, ReplayScalar, Running, replay, replay_pairs};
pub use replayed::Apply;
pub use step::{Alone, Solved, Step, Verdict};
pub use summary::{InUse, JudgedInWords, SCREEN_PX, Summary, row_offsets_px};
