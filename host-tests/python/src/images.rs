//! `match` and `check`: the matcher and the verdict of `selfcal`.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use images::matcher::{Matcher, MatcherConfig};
use images::picture::Picture;
use images::pipeline::{Selection, first};
use images::rig::{Cut, RigRequest};
use images::session::{self, Listener, Request};
use images::source::{RigOf, Source, Wanted};
use images::verdict::Report;
use numpy::{Element, PyReadonlyArray2};
use pyo3::prelude::*;
use rigs::formats::Unknowns;
use sim::run::Step;
use stereo_selfcal::Cameras;

use crate::arguments::{Given, Points, Vector, described};
use crate::errors::{of_file, value, wrong_type};
use crate::outcome::Matches;
use crate::pool::{install, install_until};
use crate::rig::Rig;

/// Largest difference of the time stamps of a pair, s, as in `selfcal check`.
const TOLERANCE_S: f64 = 0.005;

/// Matches of two images.
#[pyfunction]
#[pyo3(name = "match", signature = (left, right, rig, *, prior_deg=6.0, keypoints=3000))]
pub(crate) fn match_images(
    py: Python<'_>,
    left: &Given<'_>,
    right: &Given<'_>,
    rig: &Rig,
    prior_deg: f64,
    keypoints: usize,
) -> PyResult<Matches> {
    if !(0.1..=20.0).contains(&prior_deg) {
        return Err(value(format!("prior_deg: {prior_deg} is not within 0.1 to 20 degrees")));
    }
    let left = picture("left", left, rig.left.size)?;
    let right = picture("right", right, rig.right.size)?;
    let cameras = Cameras { left: rig.left.core()?, right: rig.right.core()? };
    let config = MatcherConfig { prior_deg, keypoints, ..MatcherConfig::default() };
    let matcher = Matcher::new(cameras, &rig.start()?, config);
    let matched = install(py, || matcher.matches(&left, &right))?.map_err(of_file)?;
    if matched.is_exchanged() {
        let [positive, negative] = matched.signs;
        let of = positive + negative;
        let exchanged = format!("exchanged: {negative} of {of} disparities are negative");
        return Err(value(format!("left, right: {exchanged}")));
    }
    let matches = matched.matches.iter();
    let left = Points(matches.clone().map(|m| [m.ul, m.vl]).collect());
    let right = Points(matches.clone().map(|m| [m.ur, m.vr]).collect());
    Ok(Matches(left, right, Vector(matches.map(|m| m.score).collect())))
}

/// A grey image of numpy, or of a file.
#[derive(FromPyObject)]
enum Image<'py> {
    Path(PathBuf),
    Bytes(PyReadonlyArray2<'py, u8>),
    Words(PyReadonlyArray2<'py, u16>),
}

fn picture(name: &str, given: &Given<'_>, size: (u16, u16)) -> PyResult<Picture> {
    let picture = match given.extract() {
        Ok(Image::Path(path)) => Picture::read(&path),
        Ok(Image::Bytes(array)) => Picture::try_new(size_of(&array), pixels(&array)),
        Ok(Image::Words(array)) => Picture::of_16_bits(size_of(&array), &pixels(&array)),
        Err(_) => {
            return Err(wrong_type(format!(
                "{name}: a path or a grey image, (height, width) of uint8 or uint16, is expected, not {}; for colours: \
                 cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)",
                described(given)
            )));
        }
    };
    let picture = picture.with_context(|| name.to_owned()).map_err(of_file)?;
    let (own, (width, height)) = (picture.size(), size);
    if own != [width, height] {
        let [w, h] = own;
        let not = format!("an image of {w} x {h} px, the rig's have {width} x {height}");
        return Err(value(format!("{name}: {not}")));
    }
    if picture.is_blank() {
        return Err(value(format!("{name}: the image is empty: all one grey value")));
    }
    Ok(picture)
}

fn size_of(array: &PyReadonlyArray2<'_, impl Element>) -> [usize; 2] {
    let (height, width) = array.as_array().dim();
    [width, height]
}

fn pixels<T: Element + Copy>(array: &PyReadonlyArray2<'_, T>) -> Vec<T> {
    array.as_array().iter().copied().collect()
}

/// Verdict on a rig from images.
#[pyfunction]
#[pyo3(signature = (source, rig=None, *, focal_px=None, every=1, pairs=None))]
pub(crate) fn check<'py>(
    py: Python<'py>,
    source: &Given<'py>,
    rig: Option<&Given<'py>>,
    focal_px: Option<f64>,
    every: usize,
    pairs: Option<usize>,
) -> PyResult<Given<'py>> {
    let places = paths("source", source)?;
    if every == 0 || pairs == Some(0) {
        return Err(value("every, pairs: numbers from 1 are expected"));
    }
    let selection = Selection { every, most: pairs.unwrap_or(usize::MAX) };
    let given = rig.and_then(|rig| rig.extract::<Rig>().ok());
    let given = given.map(|rig| rig.meta()).transpose()?;
    let files = rig.filter(|_| given.is_none()).map_or(Ok(Vec::new()), |rig| paths("rig", rig))?;
    let stop = AtomicBool::new(false);
    let checked = install_until(py, &stop, || -> anyhow::Result<String> {
        let mut source = Source::open(&places, &Wanted::default(), TOLERANCE_S)?;
        source.upright = [true; 2];
        let first = first(&source)?;
        if let Some(meta) = given {
            source.rig = RigOf::Read(Box::new(meta));
        }
        let unknowns = Unknowns { cameras: source.cameras, ..Unknowns::default() };
        let request = RigRequest { files, unknowns, focal_px, cut: Cut::default() };
        let rig = request.find(&source.rig, first.sizes_if([true; 2]), &first.frames[0]);
        let rig = rig.context("the rig")?;
        let matcher = MatcherConfig::default();
        let (frames, out) = (None, None);
        let request = Request { source: &source, rig: &rig, matcher, selection, frames, out };
        let session = session::run(&request, &stop, &mut Silent)?;
        Ok(serde_json::to_string(&Report::of(&session, rig.guessed)?)?)
    })?;
    let class = py.import("stereo_selfcal._results")?.getattr("Check")?;
    class.call_method1("_of", (checked.map_err(of_file)?,))
}

/// One path, or a left and a right one.
fn paths(name: &str, given: &Given<'_>) -> PyResult<Vec<PathBuf>> {
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
