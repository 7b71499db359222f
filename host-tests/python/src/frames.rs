//! `encode_frame`: matches in the format of a matcher.

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rigs::data::Match;
use sim::wire::Sender;
use stereo_selfcal::Correspondence;

use crate::arguments::{Given, POINTS, matches, same_length};
use crate::errors::{of_file, value};

/// Largest track of a frame: 12 bits.
const MAX_TRACK: u16 = 4095;

/// Encodes matches as the bytes of a matcher.
#[pyfunction]
#[pyo3(signature = (sequence, uv_left, uv_right, score=None, *, size, tracks=None))]
pub(crate) fn encode_frame<'py>(
    py: Python<'py>,
    sequence: u32,
    uv_left: &Given<'py>,
    uv_right: &Given<'py>,
    score: Option<&Given<'py>>,
    size: (u16, u16),
    tracks: Option<Vec<i64>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let pair = matches(POINTS, [uv_left, uv_right], score, 0.0)?;
    let tracks = tracks.unwrap_or_else(|| vec![0; pair.len()]);
    same_length("tracks", tracks.len(), pair.len())?;
    let one = |(i, (c, track)): (usize, (&Correspondence<f32>, i64))| {
        let ([ul, vl], [ur, vr]) = (c.left.map(f64::from), c.right.map(f64::from));
        let sent = u16::try_from(track).ok().filter(|track| *track <= MAX_TRACK);
        let wrong = || value(format!("tracks[{i}] = {track} is not within 0 to {MAX_TRACK}"));
        let m = Match { ul, vl, ur, vr, score: c.score.into(), step: 0.0 };
        sent.map(|sent| (m, sent)).ok_or_else(wrong)
    };
    let pair = pair.iter().zip(tracks).enumerate().map(one).collect::<PyResult<Vec<_>>>()?;
    let sender = Sender::new(size.into(), [0.0]).map_err(of_file)?;
    let (bytes, left_out) = sender.tracked_frame(sequence, &pair);
    if left_out > 0 {
        let out = format!("{left_out} of {} matches are out of a frame's range", pair.len());
        return Err(value(format!("uv_left, uv_right: {out}")));
    }
    Ok(PyBytes::new(py, &bytes))
}
