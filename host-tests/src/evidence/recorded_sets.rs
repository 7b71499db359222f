//! Recorded data sets as they are compared on: undistorted rays, seen from the paper's five views.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{Extrinsics, RayPair, RectifyingRotations, row_offset};

use super::cache::digest;
use crate::baselines::Setting;
use crate::data::{Dataset, Rays, TurnedView};

/// By how much the left view is turned, degrees.
pub const TURN_DEG: f64 = 5.0;

/// Noise of a coordinate that methods are told to expect of recorded data, px.
const NOISE_PX: f64 = 0.3;

/// A match further from its row, as the reference has it, is an outlier, px.
pub const GATE_PX: f64 = 2.0;

/// A start closer to the truth than this gives no evidence, rad.
const NO_EVIDENCE: f64 = 1e-6;

/// Where every method starts.
pub const START: Extrinsics<f64> = Extrinsics::SIDE_BY_SIDE;

/// A data set, from all views.
pub struct RecordedSet {
    /// Name of its folder.
    pub name: String,
    /// Digest of all it contains.
    pub digest: String,
    /// Where it comes from.
    pub source: String,
    /// Standard error of its reference, rad, where it is known.
    pub reference: Option<Deviation<f64>>,
    /// Share of matches that do not agree with the reference, 0 to 1.
    pub outliers: f64,
    /// Middle, top, bottom, left, right.
    pub views: Vec<SetView>,
}

/// A data set from one view.
pub struct SetView {
    /// Name of the view.
    pub view: &'static str,
    /// Rays of each pair; pixels without a ray are left out.
    pub pairs: Vec<Vec<Rays>>,
    /// True extrinsics of each pair.
    truths: Vec<Extrinsics<f64>>,
    /// True extrinsics of the last pair.
    pub truth: Extrinsics<f64>,
    /// What methods may know.
    pub setting: Setting,
}

impl RecordedSet {
    /// From all five views.
    ///
    /// # Errors
    /// If its cameras or its extrinsics are not valid.
    pub fn new(set: &Dataset) -> Result<Self> {
        let views = [
            ("middle", None),
            ("top", Some(TurnedView::Top)),
            ("bottom", Some(TurnedView::Bottom)),
            ("left", Some(TurnedView::Left)),
            ("right", Some(TurnedView::Right)),
        ];
        let seen = |(name, view): (&'static str, Option<TurnedView>)| match view {
            None => SetView::new(name, set),
            Some(view) => SetView::new(name, &view.turn(set, TURN_DEG)?),
        };
        let views: Result<Vec<SetView>> = views.into_iter().map(seen).collect();
        let views = views.with_context(|| set.name.clone())?;
        let reference = set
            .meta
            .sigma_t_deg
            .zip(set.meta.sigma_r_deg)
            .map(|(t, r)| Deviation { translation: t.to_radians(), rotation: r.to_radians() });
        let rigs: Vec<_> = set.rigs.iter().map(|rig| (rig.r, rig.t)).collect();
        let content = serde_json::to_vec(&(&set.meta, &set.pairs, rigs))?;
        Ok(Self {
            name: set.name.clone(),
            digest: digest(&content),
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
    fn new(view: &'static str, set: &Dataset) -> Result<Self> {
        let cameras = set.cameras::<f64>()?;
        let rays = |m: &crate::data::Match| {
            let pair: RayPair<f64> = cameras.rays(&m.correspondence()).ok()?;
            Some([pair.left(), pair.right()].map(|[x, y]| Vector3::new(x, y, 1.0)))
        };
        let pairs: Vec<Vec<Rays>> =
            set.pairs.iter().map(|pair| pair.iter().filter_map(rays).collect()).collect();
        let truth = set.truth()?;
        let moving = set.truths()?;
        let truths = if moving.is_empty() { vec![truth; pairs.len()] } else { moving };
        let setting = Setting { start: START, focal: cameras.mean_focal(), noise_px: NOISE_PX };
        Ok(Self { view, pairs, truths, truth, setting })
    }

    /// Whether a match lies within [`GATE_PX`] of its row, as the reference has it.
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

    /// Whether an estimate is evidence: not where the start is the truth, as in rectified data.
    #[must_use]
    pub fn is_evidence(&self) -> bool {
        let off = Deviation::between(&START, &self.truth);
        off.translation.max(off.rotation) > NO_EVIDENCE
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

/// The sets that come with the project, then those of the folders, each only once.
///
/// * `folders`: data sets, or folders of data sets.
///
/// # Errors
/// Names the folder that has none, or the set that cannot be read.
pub fn all(folders: &[PathBuf]) -> Result<Vec<RecordedSet>> {
    let mut places: Vec<PathBuf> =
        Dataset::SHIPPED.iter().map(|name| Dataset::shipped().join(name)).collect();
    for folder in folders {
        places.extend(sets_in(folder)?);
    }
    let mut all: Vec<RecordedSet> = Vec::new();
    for place in places {
        let recording = RecordedSet::new(&Dataset::load(&place)?)?;
        if all.iter().all(|other| other.digest != recording.digest) {
            all.push(recording);
        }
    }
    Ok(all)
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
    fn the_middle_view_of_a_rectified_set_is_no_evidence_and_all_others_are() {
        let recordings = all(&[]).unwrap();
        for recording in &recordings {
            let rectified = ["motorcycle_sift", "aloe_sift"].contains(&recording.name.as_str());
            for seen in &recording.views {
                let expected = !(rectified && seen.view == "middle");
                assert_eq!(seen.is_evidence(), expected, "{} {}", recording.name, seen.view);
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
        let set = crate::synth::Scene::default().dataset(2, 1).unwrap();
        set.save(&dir.path().join("mine")).unwrap();
        let more = all(&[dir.path().to_owned(), dir.path().join("mine")]).unwrap();
        assert_eq!((more.len(), more[shipped].name.as_str()), (shipped + 1, "mine"));
    }
}
