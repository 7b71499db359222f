//! `match` and `check`: the matcher and the verdict of `selfcal`; `encode_frame`: matches in the format of a matcher.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use host_tests::data::Match;
use host_tests::run::Step;
use host_tests::wire::Sender;
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use selfcal_commands::conventions::Unknowns;
use selfcal_images::matcher::{Matched, Matcher, MatcherConfig};
use selfcal_images::picture::Picture;
use selfcal_images::pipeline::{Selection, first};
use selfcal_images::rig::{Cut, RigRequest};
use selfcal_images::session::{self, Listener, Request};
use selfcal_images::source::{RigOf, Source, Wanted};
use selfcal_images::verdict::Report;
use stereo_selfcal::{Cameras, Correspondence};

use crate::arguments::{POINTS, Points, Vector, matches, same_length};
use crate::errors::{of_file, value, wrong_type};
use crate::pool::{install, install_until};
use crate::rig::Rig;

/// Largest track of a frame: 12 bits.
const MAX_TRACK: u16 = 4095;

/// Largest difference of the time stamps of a pair, s, as in `selfcal check`.
const TOLERANCE_S: f64 = 0.005;

/// Matches of two images.
#[pyfunction]
#[pyo3(name = "match", signature = (left, right, rig, *, prior_deg=6.0, keypoints=3000))]
pub(crate) fn match_images<'py>(
    py: Python<'py>,
    left: &Bound<'py, PyAny>,
    right: &Bound<'py, PyAny>,
    rig: &Rig,
    prior_deg: f64,
    keypoints: usize,
) -> PyResult<Bound<'py, PyAny>> {
    if !(0.1..=20.0).contains(&prior_deg) {
        return Err(value(format!("prior_deg: {prior_deg} is not within 0.1 to 20 degrees")));
    }
    let left = picture("left", left, rig.left.0.intrinsics().size)?;
    let right = picture("right", right, rig.right.0.intrinsics().size)?;
    let cameras = Cameras { left: rig.left.0, right: rig.right.0 };
    let config = MatcherConfig { prior_deg, keypoints, ..MatcherConfig::default() };
    let matcher = Matcher::new(cameras, &rig.start()?, config);
    let matched = install(py, || matcher.matches(&left, &right))?.map_err(of_file)?;
    if matched.is_exchanged() {
        let [positive, negative] = matched.signs;
        return Err(value(format!(
            "left, right: exchanged: {negative} of {} disparities are negative",
            positive + negative
        )));
    }
    let Matched { matches, .. } = &matched;
    let left = Points(matches.iter().map(|m| [m.ul, m.vl]).collect());
    let right = Points(matches.iter().map(|m| [m.ur, m.vr]).collect());
    let score = Vector(matches.iter().map(|m| m.score).collect());
    let class = py.import("stereo_selfcal._results")?.getattr("Matches")?;
    class.call1((left, right, score))
}

/// A grey image of numpy, or of a file.
fn picture(name: &str, given: &Bound<'_, PyAny>, size: [u16; 2]) -> PyResult<Picture> {
    let picture = if let Ok(path) = given.extract::<PathBuf>() {
        Picture::read(&path).map_err(of_file)?
    } else {
        of_array(name, given)?
    };
    let [width, height] = picture.size();
    if picture.size() != size {
        return Err(value(format!(
            "{name}: an image of {width} x {height} px, the rig's have {} x {}",
            size[0], size[1]
        )));
    }
    if picture.is_blank() {
        return Err(value(format!("{name}: the image is empty: all one grey value")));
    }
    Ok(picture)
}

fn of_array(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Picture> {
    let is_array = given.cast::<PyUntypedArray>();
    let Ok(array) = is_array else {
        return Err(wrong_type(format!("{name}: an array or a path is expected")));
    };
    let wrong = || {
        wrong_type(format!(
            "{name}: a grey image, (height, width) of uint8 or uint16, is expected, not {} of shape {:?}; for colours: \
             cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)",
            array.dtype(),
            array.shape()
        ))
    };
    let [height, width] = *array.shape() else { return Err(wrong()) };
    let picture = if let Ok(bytes) = array.as_any().cast::<PyArrayDyn<u8>>() {
        let pixels = bytes.try_readonly().map_err(value)?.as_array().iter().copied().collect();
        Picture::try_new([width, height], pixels)
    } else if let Ok(words) = array.as_any().cast::<PyArrayDyn<u16>>() {
        let pixels: Vec<u16> =
            words.try_readonly().map_err(value)?.as_array().iter().copied().collect();
        Picture::of_16_bits([width, height], &pixels)
    } else {
        return Err(wrong());
    };
    picture.map_err(|why| value(format!("{name}: {why:#}")))
}

/// Verdict on a rig from images.
#[pyfunction]
#[pyo3(signature = (source, rig=None, *, focal_px=None, every=1, pairs=None))]
pub(crate) fn check<'py>(
    py: Python<'py>,
    source: &Bound<'py, PyAny>,
    rig: Option<&Bound<'py, PyAny>>,
    focal_px: Option<f64>,
    every: usize,
    pairs: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let places = paths("source", source)?;
    if every == 0 || pairs == Some(0) {
        return Err(value("every, pairs: numbers from 1 are expected"));
    }
    let selection = Selection { every, most: pairs.unwrap_or(usize::MAX) };
    let (given, files) = match rig {
        None => (None, Vec::new()),
        Some(rig) => match rig.extract::<Rig>() {
            Ok(rig) => (Some(rig.meta()?), Vec::new()),
            Err(_) => (None, paths("rig", rig)?),
        },
    };
    let stop = AtomicBool::new(false);
    let checked = install_until(py, &stop, || -> anyhow::Result<String> {
        let mut source = Source::open(&places, &Wanted::default(), TOLERANCE_S)?;
        source.upright = [true; 2];
        let first = first(&source)?;
        let of_source = given.map(|meta| RigOf::Read(Box::new(meta)));
        let unknowns = Unknowns { cameras: source.cameras, ..Unknowns::default() };
        let request = RigRequest { files, unknowns, focal_px, cut: Cut::default() };
        let of_source = of_source.as_ref().unwrap_or(&source.rig);
        let found = request.find(of_source, first.sizes_if([true; 2]), &first.frames[0]);
        let rig = found.context("the rig")?;
        let matcher = MatcherConfig::default();
        let (frames, out) = (None, None);
        let request = Request { source: &source, rig: &rig, matcher, selection, frames, out };
        let session = session::run(&request, &stop, &mut Silent)?;
        Ok(serde_json::to_string(&Report::of(&session, rig.guessed)?)?)
    })?;
    let numbers = py.import("json")?.call_method1("loads", (checked.map_err(of_file)?,))?;
    let reasons =
        PyTuple::new(py, numbers.get_item("reasons")?.try_iter()?.collect::<PyResult<Vec<_>>>()?)?;
    let class = py.import("stereo_selfcal._results")?.getattr("Check")?;
    class.call1((numbers.get_item("verdict")?, reasons, &numbers))
}

/// One path, or a left and a right one.
fn paths(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<PathBuf>> {
    let one = given.extract::<PathBuf>().map(|path| vec![path]);
    one.or_else(|_| given.extract()).map_err(|_| {
        wrong_type(format!("{name}: a path, or two, are expected, not {}", given.get_type()))
    })
}

/// A listener without output.
struct Silent;

impl Listener for Silent {
    fn pair(&mut self, _number: usize, _step: &Step) {}

    fn skipped(&mut self, _why: &str) {}
}

/// Encodes matches as the bytes of a matcher.
#[pyfunction]
#[pyo3(signature = (sequence, uv_left, uv_right, score=None, *, size, tracks=None))]
pub(crate) fn encode_frame<'py>(
    py: Python<'py>,
    sequence: u32,
    uv_left: &Bound<'py, PyAny>,
    uv_right: &Bound<'py, PyAny>,
    score: Option<&Bound<'py, PyAny>>,
    size: (u16, u16),
    tracks: Option<Vec<i64>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let pair = matches(POINTS, uv_left, uv_right, score, 0.0)?;
    let tracks = tracks.unwrap_or_else(|| vec![0; pair.len()]);
    same_length("tracks", tracks.len(), pair.len())?;
    let one = |(i, (c, track)): (usize, (&Correspondence<f32>, i64))| {
        let ([ul, vl], [ur, vr]) = (c.left.map(f64::from), c.right.map(f64::from));
        let is_track = |track: &u16| *track <= MAX_TRACK;
        let sent = u16::try_from(track).ok().filter(is_track);
        let sent =
            sent.ok_or_else(|| value(format!("tracks[{i}] = {track} is not within 0 to 4095")));
        Ok((Match { ul, vl, ur, vr, score: c.score.into(), step: 0.0 }, sent?))
    };
    let pair = pair.iter().zip(tracks).enumerate().map(one).collect::<PyResult<Vec<_>>>()?;
    let sender = Sender::new(size.into(), [0.0]).map_err(of_file)?;
    let (bytes, left_out) = sender.tracked_frame(sequence, &pair);
    if left_out > 0 {
        return Err(value(format!(
            "uv_left, uv_right: {left_out} of {} matches are out of a frame's range",
            pair.len()
        )));
    }
    Ok(PyBytes::new(py, &bytes))
}
