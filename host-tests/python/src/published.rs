//! The published method over pairs.

use pyo3::prelude::*;
use rigs::data::in_f64;
use stereo_selfcal::Correspondence;
use stereo_selfcal::paper::{Central, FusedEstimate, PaperCalibrator, Settings};

use crate::arguments::{Given, pose};
use crate::calibrator::read_pairs;
use crate::errors::unknown;
use crate::outcome::Published;
use crate::pool::install;
use crate::rig::Rig;

/// The capacity in matches of a pair.
const CAPACITY: usize = 2048;

/// Fuses pairs by the published method, from the factory extrinsics.
#[pyfunction]
#[pyo3(signature = (rig, pairs, *, angle="mean"))]
pub(crate) fn fuse_published(
    py: Python<'_>,
    rig: Rig,
    pairs: &Given<'_>,
    angle: &str,
) -> PyResult<Vec<Option<Published>>> {
    let angle = match angle {
        "mean" => Central::Mean,
        "median" => Central::Median,
        other => return Err(unknown("angle", "'mean' or 'median'", other)),
    };
    let made = rig.made()?;
    let settings = Settings::DEFAULT.with_angle(angle);
    let mut calibrator =
        Box::new(PaperCalibrator::<f32, CAPACITY>::new(settings, made.cameras, made.extrinsics));
    let pairs: Vec<Vec<Correspondence<f32>>> = read_pairs(pairs)?;
    let estimates: Vec<Option<FusedEstimate<f32>>> = install(py, || {
        let take = |pair| {
            // A refused pair leaves the estimate as it is.
            let _ = calibrator.take_pair(pair);
            calibrator.estimate()
        };
        pairs.into_iter().map(take).collect()
    })?;
    let published = |of: Option<FusedEstimate<f32>>| {
        of.map(|of| Published::new(&of, pose(&in_f64(&of.extrinsics)))).transpose()
    };
    estimates.into_iter().map(published).collect()
}
