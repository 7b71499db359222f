//! Python package `stereo_selfcal`: the calibrator of the vehicle for numpy.
//!
//! The core is called in `engine`, `calibrator`, `published`, `history`, `camera`, `rig` and `calibration`. `outcome` has
//! the results of a pair as plain data; `errors` converts errors into the exceptions of
//! `python/stereo_selfcal/_errors.py`. `_native.pyi` has documentation and types of the public API.
#![allow(
    clippy::cast_possible_truncation,
    reason = "numbers of Python to those of a vehicle, which checks their range"
)]
#![allow(clippy::needless_pass_by_value, reason = "Python hands over its arguments by value")]

mod arguments;
mod calibration;
mod calibrator;
mod camera;
mod engine;
mod errors;
mod frames;
mod history;
#[cfg(feature = "images")]
mod images;
mod outcome;
mod pool;
mod published;
mod rig;

#[pyo3::pymodule]
mod _native {
    #[cfg(feature = "images")]
    #[pymodule_export]
    use crate::images::{check, match_images};
    #[pymodule_export]
    use crate::{
        calibration::Calibration,
        calibrator::{Calibrator, solve_pairs},
        camera::Camera,
        frames::encode_frame,
        history::{Event, History},
        outcome::{Details, Pair, Published, Result, Verdict},
        published::fuse_published,
        rig::{Rig, read_rig},
    };
}
