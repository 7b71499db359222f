//! Recorded data sets for the comparison: undistorted rays from the paper's five views, with either camera turned, or
//! both.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use stereo_selfcal::Extrinsics;
use stereo_selfcal::batch::{RayPair, row_offset};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::geometry::metrics::Deviation;

use crate::rivals::{Front, Setting, Tuning};
use rigs::data::{Dataset, Rays, TurnedCamera, TurnedView};

/// Angle of a turned view, degrees.
pub const TURN_DEG: f64 = 5.0;

/// Noise of a coordinate that methods are given for recorded data, px.
const NOISE_PX: f64 = 0.3;

/// Largest row offset under the reference of a match that is not an outlier, px.
pub const GATE_PX: f64 = 2.0;

/// Least distance of the start from the truth that gives evidence, rad.
const NO_EVIDENCE: f64 = 1e-6;

/// Start of every method.
pub const START: Extrinsics<f64> = Extrinsics::SIDE_BY_SIDE;

/// A data set, from all views.
pub struct RecordedSet {
    /// Name of its folder.
    pub name: String,
    /// Its source.
    pub source: String,
    /// Standard error of its reference, rad, if known.
    pub reference: Option<Deviation<f64>>,
    /// Share of matches that disagree with the reference, 0 to 1.
    pub outliers: f64,
    /// Middle; then top, bottom, left, right of the left camera, of the right one, and of both.
    pub views: Vec<SetView>,
}

/// A data set from one view.
pub struct SetView {
    /// Name of the camera that is turned; `-` if none.
    pub camera: &'static str,
    /// Name of the view.
    pub view: &'static str,
    /// Rays of each pair; pixels without a ray are left out.
    pub pairs: Vec<Vec<Rays>>,
    /// True extrinsics of each pair.
    truths: Vec<Extrinsics<f64>>,
    /// True extrinsics of the last pair.
    pub truth: Extrinsics<f64>,
    /// Knowledge that methods may use.
    pub setting: Setting,
    /// RANSAC in front of methods, once requested.
    front: OnceLock<Front>,
}

impl RecordedSet {
    /// The set from all views.
    ///
    /// # Errors
    /// If its cameras or its extrinsics are not valid.
    pub fn new(set: &Dataset) -> Result<Self> {
        let views = [
            ("top", TurnedView::Top),
            ("bottom", TurnedView::Bottom),
            ("left", TurnedView::Left),
            ("right", TurnedView::Right),
        ];
        let cameras = [
            ("left", TurnedCamera::Left),
            ("right", TurnedCamera::Right),
            ("both", TurnedCamera::Both),
        ];
        let turned = cameras.iter().flat_map(|camera| views.iter().map(move |view| (camera, view)));
        let seen = |((camera, turned), (name, view)): (
            &(&'static str, TurnedCamera),
            &(&'static str, TurnedView),
        )| {
            SetView::new([*camera, *name], &view.turn_camera(set, TURN_DEG, *turned)?)
        };
        let middle = [SetView::new(["-", "middle"], set)];
        let views: Result<Vec<SetView>> = middle.into_iter().chain(turned.map(seen)).collect();
        let views = views.with_context(|| set.name.clone())?;
        let reference = set
            .meta
            .sigma_t_deg
            .zip(set.meta.sigma_r_deg)
            .map(|(t, r)| Deviation { translation: t.to_radians(), rotation: r.to_radians() });
        Ok(Self {
            name: set.name.clone(),
            source: set.meta.source.clone(),
            reference,
            outliers: views.first().map_or(0.0, SetView::outliers),
            views,
        })
    }

    /// Correspondences of all pairs.
    #[must_use]
    pub fn matches(&self) -> usize {
        self.views.first().map_or(0, |seen| seen.pairs.iter().map(Vec::len).sum())
    }
}

impl SetView {
    /// The turned camera, and its direction.
    #[must_use]
    pub fn words(&self) -> String {
        match self.camera {
            "-" => self.view.into(),
            camera => format!("{camera} {}", self.view),
        }
    }

    fn new([camera, view]: [&'static str; 2], set: &Dataset) -> Result<Self> {
        let cameras = set.cameras::<f64>()?;
        let rays = |m: &rigs::data::Match| {
            let pair: RayPair<f64> = cameras.rays(&m.correspondence()).ok()?;
            Some([pair.left(), pair.right()].map(|[x, y]| Vector3::new(x, y, 1.0)))
        };
        let pairs: Vec<Vec<Rays>> =
            set.pairs.iter().map(|pair| pair.iter().filter_map(rays).collect()).collect();
        let truth = set.truth()?;
        let moving = set.truths()?;
        let truths = if moving.is_empty() { vec![truth; pairs.len()] } else { moving };
        let setting = Setting {
            start: START,
            focal: cameras.mean_focal(),
            noise_px: NOISE_PX,
            tuning: Tuning::default(),
        };
        Ok(Self { camera, view, pairs, truths, truth, setting, front: OnceLock::new() })
    }

    /// Whether a match lies within [`GATE_PX`] of its row under the reference.
    pub fn agrees(&self) -> impl Fn(&Rays) -> bool {
        let rotations = RectifyingRotations::from(&self.truth);
        let gate = GATE_PX / self.setting.focal;
        move |[p_l, p_r]| {
            let pair = RayPair::try_new([p_l.x, p_l.y], [p_r.x, p_r.y]);
            let offset = pair.and_then(|pair| row_offset(&rotations, &pair));
            offset.is_some_and(|offset| offset.abs() <= gate)
        }
    }

    fn outliers(&self) -> f64 {
        let count = |n: usize| u32::try_from(n).map_or(f64::INFINITY, f64::from);
        let agrees = self.agrees();
        let all = self.pairs.iter().map(Vec::len).sum::<usize>();
        let agreeing = self.pairs.iter().flatten().filter(|rays| agrees(rays)).count();
        1.0 - count(agreeing) / count(all.max(1))
    }

    /// RANSAC in front of methods.
    pub fn front(&self) -> &Front {
        self.front.get_or_init(|| Front::new(&self.pairs, &self.setting))
    }

    /// Error of the start, which is the result of doing nothing.
    #[must_use]
    pub fn still(&self) -> Deviation<f64> {
        self.error(&START)
    }

    /// Whether `t`, and `R`, are evidence: the truth differs from the start by more than the reference's standard
    /// error.
    #[must_use]
    pub fn is_evidence(&self, reference: Option<Deviation<f64>>) -> [bool; 2] {
        let off = self.still();
        let known = reference.unwrap_or_default();
        [
            off.translation > known.translation.max(NO_EVIDENCE),
            off.rotation > known.rotation.max(NO_EVIDENCE),
        ]
    }

    /// Error of an estimate from all pairs.
    #[must_use]
    pub fn error(&self, estimate: &Extrinsics<f64>) -> Deviation<f64> {
        Deviation::between(estimate, &self.truth)
    }

    /// Error of an estimate from one pair.
    #[must_use]
    pub fn error_of_pair(&self, pair: usize, estimate: &Extrinsics<f64>) -> Deviation<f64> {
        Deviation::between(estimate, self.truths.get(pair).unwrap_or(&self.truth))
    }
}

/// The shipped sets, then those of the folders, each only once.
///
/// * `folders`: data sets, or folders of data sets.
///
/// # Errors
/// Names the folder without a data set, or the set that cannot be read.
pub fn all(folders: &[PathBuf]) -> Result<Vec<RecordedSet>> {
    let mut places: Vec<PathBuf> =
        Dataset::SHIPPED.iter().map(|name| Dataset::shipped().join(name)).collect();
    for folder in folders {
        places.extend(sets_in(folder)?);
    }
    let mut all: Vec<Dataset> = Vec::new();
    for place in places {
        let set = Dataset::load(&place)?;
        if !all.iter().any(|other| (&other.meta, &other.pairs) == (&set.meta, &set.pairs)) {
            all.push(set);
        }
    }
    all.iter().map(RecordedSet::new).collect()
}

fn sets_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_set = |dir: &Path| dir.join("meta.json").is_file();
    if is_set(folder) {
        return Ok(vec![folder.to_owned()]);
    }
    let entries =
        fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    let mut sets: Vec<PathBuf> =
        entries.map(|entry| entry.map(|e| e.path())).collect::<std::io::Result<_>>()?;
    sets.retain(|path| is_set(path));
    sets.sort();
    ensure!(
        !sets.is_empty(),
        "no data set in {}: a data set is a folder with meta.json and pairs/*.csv",
        folder.display()
    );
    Ok(sets)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectified_sets_are_evidence_on_what_a_turn_moves_and_others_on_all() {
        let recordings = all(&[]).unwrap();
        for recording in &recordings {
            assert_eq!(recording.views.len(), 13);
            let rectified =
                ["motorcycle_sift", "aloe_sift", "oak_sift"].contains(&recording.name.as_str());
            for SetView { camera, view, .. } in &recording.views {
                let moves_t = match *camera {
                    "right" => ["left", "right"].contains(view),
                    "both" => ["top", "bottom"].contains(view),
                    _ => false,
                };
                let expected = [!rectified || moves_t, !rectified || *view != "middle"];
                let seen = recording.views.iter().find(|s| (s.camera, s.view) == (camera, view));
                let found = seen.unwrap().is_evidence(recording.reference);
                assert_eq!(found, expected, "{} {camera} {view}", recording.name);
            }
        }
    }

    #[test]
    fn folders_add_sets_and_what_is_there_already_is_not_compared_twice() {
        let shipped = all(&[]).unwrap().len();
        assert_eq!(all(&[Dataset::shipped()]).unwrap().len(), shipped);
        let dir = tempfile::tempdir().unwrap();
        let error = all(&[dir.path().to_owned()]).err().unwrap().to_string();
        assert!(error.contains("meta.json"), "{error}");
        let set = sim::synth::Scene::default().dataset(2, 1).unwrap();
        set.save(&dir.path().join("mine")).unwrap();
        let more = all(&[dir.path().to_owned(), dir.path().join("mine")]).unwrap();
        assert_eq!((more.len(), more[shipped].name.as_str()), (shipped + 1, "mine"));
    }
}
