//! A method with its settings, as a comparison runs it.

use stereo_selfcal::Extrinsics;

use super::by_name;
use super::front::Front;
use super::method::{Method, Setting};
use super::tuning::Tuning;
use anyhow::Result;
use rigs::data::Rays;

/// A method, and settings to run it with.
pub struct Variant {
    /// The method.
    pub method: Box<dyn Method>,
    /// Its settings.
    pub tuning: Tuning,
}

impl Variant {
    /// Name of the method and its changed settings: `hansen: RANSAC, agile`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}: {}", self.method.name(), self.tuning.words())
    }

    /// The estimate after each pair.
    ///
    /// * `front`: the preprocessed pairs.
    #[must_use]
    pub fn running(
        &self,
        pairs: &[Vec<Rays>],
        front: &Front,
        setting: &Setting,
    ) -> Vec<Option<Extrinsics<f64>>> {
        self.method.running(self.input(pairs, front), &self.setting(front, setting))
    }

    /// The estimate from all pairs together.
    ///
    /// * `front`: the preprocessed pairs.
    #[must_use]
    pub fn fused(
        &self,
        pairs: &[Vec<Rays>],
        front: &Front,
        setting: &Setting,
    ) -> Option<Extrinsics<f64>> {
        self.method.fused(self.input(pairs, front), &self.setting(front, setting))
    }

    fn input<'a>(&self, pairs: &'a [Vec<Rays>], front: &'a Front) -> &'a [Vec<Rays>] {
        if self.tuning.prefiltered { &front.inliers } else { pairs }
    }

    fn setting(&self, front: &Front, setting: &Setting) -> Setting {
        let estimated = self.tuning.noise_estimated;
        let noise_px = if estimated { front.noise_px() } else { setting.noise_px };
        Setting { noise_px, tuning: self.tuning, ..*setting }
    }
}

/// Selection of the settings of each method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Range {
    /// All settings that are compared.
    All,
    /// The default settings, and the settings that serve most methods best.
    Few,
}

/// The settings of a method that are compared, the default ones first.
///
/// # Errors
/// If there is no method of that name.
pub fn variants(method: &str, range: Range) -> Result<Vec<Variant>> {
    tunings(method, range)
        .into_iter()
        .map(|tuning| Ok(Variant { method: by_name(method)?, tuning }))
        .collect()
}

/// The settings of all methods, method by method.
///
/// # Errors
/// As [`variants`].
pub fn all_variants(methods: &[Box<dyn Method>], range: Range) -> Result<Vec<Variant>> {
    let of_each = methods.iter().map(|method| variants(method.name(), range));
    Ok(of_each.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}

type Change = fn(Tuning) -> Tuning;

const PLAIN: Tuning = Tuning {
    prefiltered: false,
    noise_estimated: false,
    gated: false,
    annealed: false,
    rejecting: false,
    agile: false,
};

const PREFILTERED: Change = |tuning| Tuning { prefiltered: true, ..tuning };
const ESTIMATED: Change = |tuning| Tuning { noise_estimated: true, ..tuning };
const GATED: Change = |tuning| Tuning { gated: true, ..tuning };
const ANNEALED: Change = |tuning| Tuning { annealed: true, ..tuning };
const REJECTING: Change = |tuning| Tuning { rejecting: true, ..tuning };
const AGILE: Change = |tuning| Tuning { agile: true, ..tuning };

fn with(changes: &[Change]) -> Tuning {
    changes.iter().fold(PLAIN, |tuning, change| change(tuning))
}

/// Every combination of changes.
fn product(changes: &[Change]) -> Vec<Tuning> {
    changes.iter().fold(vec![PLAIN], |all, change| {
        let changed: Vec<Tuning> = all.iter().map(|tuning| change(*tuning)).collect();
        [all, changed].concat()
    })
}

fn tunings(method: &str, range: Range) -> Vec<Tuning> {
    // The changes of which every combination is run, and the few settings.
    let (all, few): (&[Change], &[&[Change]]) = match method {
        "dang" | "mueller-ukf" | "mueller-block" => (
            &[PREFILTERED, ESTIMATED, AGILE],
            &[&[], &[AGILE], &[PREFILTERED], &[PREFILTERED, AGILE]],
        ),
        "teso" => {
            (&[PREFILTERED, ESTIMATED, AGILE], &[&[], &[AGILE], &[ESTIMATED], &[ESTIMATED, AGILE]])
        }
        "hansen" => (
            &[PREFILTERED, |tuning| ESTIMATED(REJECTING(tuning)), AGILE],
            &[&[], &[REJECTING, PREFILTERED], &[PREFILTERED, AGILE]],
        ),
        "ling-shen" => (&[PREFILTERED, ESTIMATED, GATED], &[&[], &[GATED], &[PREFILTERED, GATED]]),
        "cauchy" => (
            &[PREFILTERED, |tuning| GATED(ESTIMATED(tuning)), ANNEALED],
            &[&[], &[ANNEALED], &[PREFILTERED, ANNEALED, GATED]],
        ),
        "ransac" => (&[ESTIMATED, GATED], &[&[], &[GATED]]),
        "bundle" => (&[ESTIMATED], &[&[]]),
        "paper" => (&[PREFILTERED], &[&[], &[PREFILTERED]]),
        _ => (&[], &[&[]]),
    };
    if range == Range::All { product(all) } else { few.iter().map(|few| with(few)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::all;
    use std::collections::BTreeSet;

    #[test]
    fn every_method_has_its_default_settings_first_and_each_set_once() {
        for range in [Range::All, Range::Few] {
            for method in all() {
                let variants = variants(method.name(), range).unwrap();
                assert_eq!(variants[0].tuning, Tuning::default(), "{}", method.name());
                let names: BTreeSet<String> = variants.iter().map(Variant::name).collect();
                assert_eq!(names.len(), variants.len(), "{}", method.name());
            }
        }
    }
}
