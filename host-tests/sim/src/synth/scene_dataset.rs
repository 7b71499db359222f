//! A generated scene as a data set.

use anyhow::Result;

use super::scene::Scene;
use rigs::data::{Dataset, LensModel, Meta, rows};

impl Scene {
    /// A data set of the first `pairs` pairs.
    ///
    /// # Errors
    /// As [`Scene::check`].
    pub fn dataset(&self, pairs: usize, seed: u64) -> Result<Dataset> {
        self.check()?;
        let pairs = self.pairs(seed).take(pairs).map(|pair| pair.matches).collect();
        Ok(Dataset {
            name: format!("synth seed {seed}"),
            meta: self.meta(),
            pairs,
            rigs: Vec::new(),
        })
    }

    /// The true extrinsics and the nominal cameras in the form of a data set.
    #[must_use]
    pub fn meta(&self) -> Meta {
        let [cx, cy] = self.centre();
        let k = [[self.focal, 0.0, cx], [0.0, self.focal, cy], [0.0, 0.0, 1.0]];
        let t = self.rig.translation();
        Meta {
            k_l: k,
            k_r: k,
            dist_l: vec![0.0; 5],
            dist_r: vec![0.0; 5],
            lens: LensModel::RadialTangential,
            lens_r: None,
            width: self.size[0],
            height: self.size[1],
            size_r: None,
            r: rows(self.rig.rotation().matrix()),
            t: [t.x, t.y, t.z],
            baseline_m: None,
            source: "generated".into(),
            license: String::new(),
            sigma_r_deg: None,
            sigma_t_deg: None,
            other: serde_json::Map::new(),
        }
    }
}
