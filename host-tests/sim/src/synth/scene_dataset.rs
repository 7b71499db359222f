//! A generated scene as a data set.

use anyhow::Result;

use super::scene::Scene;
use rigs::data::{Dataset, Meta, rows};

impl Scene {
    /// A data set of the first `pairs` pairs.
    pub fn dataset(&self, pairs: usize, seed: u64) -> Result<Dataset> {
        self.check()?;
        let pairs = self.pairs(seed).take(pairs).map(|pair| pair.matches).collect();
        let name = format!("synth seed {seed}");
        Ok(Dataset { name, meta: self.meta(), pairs, rigs: Vec::new() })
    }

    /// The true extrinsics and the nominal cameras in the form of a data set.
    pub fn meta(&self) -> Meta {
        let [cx, cy] = self.centre();
        let k = [[self.focal, 0.0, cx], [0.0, self.focal, cy], [0.0, 0.0, 1.0]];
        let r = rows(self.rig.rotation().matrix());
        let t = self.rig.translation().into_inner().into();
        Meta { r, t, ..Meta::side_by_side([k; 2], [self.size; 2], "generated".into()) }
    }
}
