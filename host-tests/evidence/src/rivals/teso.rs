//! Moravec and Sara, "TESO", CVPR 2026: a tracker that climbs a correlation of the tentative matches.
//!
//! Literal: the estimate climbs `sum exp(-e^2 / 2 s^2)` over the matches of the last frames, with the algebraic residual
//! `e = p_r^T E p_l` and `s` = 1 mrad. Each frame takes one diagonal Newton step, multiplied by a rate that follows from
//! the agreement of the recent gradients. No coordinate moves by more than `s / 4` a frame. The first ten frames are the
//! burn-in.
//!
//! Filled in:
//! - The curvature is taken from Gauss and Newton, and is positive everywhere.
//! - The rate of a coordinate is `|sum g| / sum |g|` over its last ten gradients.
//! - The burn-in takes the maximum over all its matches, from 64 times `s`, halved six times: a start some degrees off is
//!   beyond the reach of the tracker.
//! - The memory has ten frames, or one if the filter is agile. With an estimated noise, `s` is 2.385 of its deviations.

use std::collections::VecDeque;

use nalgebra::Vector5;
use stereo_selfcal::Extrinsics;

use super::cauchy::{CAUCHY_SD, HALVINGS};
use super::epipolar::Scaling;
use super::method::{Method, Setting, usable};
use super::minimise::{Loss, minimise, normal_equations};
use super::pose::Pose;
use rigs::data::Rays;

/// Scale `s` as published, unit depth.
const SCALE: f64 = 1e-3;

/// Frames of the burn-in, of the memory and of the recent gradients.
const FRAMES: usize = 10;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct Teso;

impl Method for Teso {
    fn name(&self) -> &'static str {
        "teso"
    }

    fn source(&self) -> &'static str {
        "Moravec and Sara (TESO), CVPR 2026: one bounded diagonal Newton step a frame on the sum of \
         exp(-e^2 / 2 s^2), e algebraic, s = 1 mrad, over the last frames. Filled in: curvature, rate by \
         agreement of ten gradients, annealed burn-in of ten frames, memory of ten frames or one"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        let mut state = State::new(setting);
        let after = pairs.iter().map(|rays| {
            state.add(usable(rays));
            state.pose?.extrinsics()
        });
        after.collect()
    }
}

/// State of the tracker.
struct State {
    start: Pose,
    /// Scale `s`, unit depth.
    scale: f64,
    /// Number of frames whose matches count.
    memory: usize,
    pose: Option<Pose>,
    frames: VecDeque<Vec<Rays>>,
    gradients: VecDeque<Vector5<f64>>,
    /// Number of frames so far.
    seen: usize,
}

impl State {
    fn new(setting: &Setting) -> Self {
        let estimated = setting.tuning.noise_estimated;
        Self {
            start: Pose::of(&setting.start),
            scale: if estimated { CAUCHY_SD * setting.noise() } else { SCALE },
            memory: if setting.tuning.agile { 1 } else { FRAMES },
            pose: None,
            frames: VecDeque::new(),
            gradients: VecDeque::new(),
            seen: 0,
        }
    }

    fn add(&mut self, rays: Vec<Rays>) {
        self.seen += 1;
        let is_burning_in = self.seen <= FRAMES;
        let memory = if is_burning_in { FRAMES } else { self.memory };
        push(&mut self.frames, rays, memory);
        let rays = self.frames.iter().flatten().copied().collect::<Vec<_>>();
        self.pose = match self.pose {
            Some(pose) if !is_burning_in => Some(self.tracked(&pose, &rays)),
            pose => self.maximum(&rays).or(pose),
        };
    }

    /// The maximum over the matches, from the start.
    fn maximum(&self, rays: &[Rays]) -> Option<Pose> {
        (0..=HALVINGS).rev().try_fold(self.start, |pose, halving| {
            let loss = Loss::Welsch(self.scale * 2.0_f64.powi(halving));
            minimise(&pose, rays, Scaling::Algebraic, loss)
        })
    }

    /// The pose after one step.
    fn tracked(&mut self, pose: &Pose, rays: &[Rays]) -> Pose {
        let loss = Loss::Welsch(self.scale);
        let (curvature, gradient) = normal_equations(pose, rays, Scaling::Algebraic, loss);
        push(&mut self.gradients, gradient, FRAMES);
        let sum: Vector5<f64> = self.gradients.iter().sum();
        let sizes: Vector5<f64> = self.gradients.iter().map(Vector5::abs).sum();
        let most = self.scale / 4.0;
        let step = Vector5::from_fn(|i, _| {
            let newton = -gradient[i] / curvature[(i, i)] * (sum[i].abs() / sizes[i]);
            // A coordinate without any match within reach stays.
            if newton.is_finite() { newton.clamp(-most, most) } else { 0.0 }
        });
        pose.moved(&step)
    }
}

/// Appends an item, and drops the oldest ones beyond `most`.
fn push<T>(queue: &mut VecDeque<T>, item: T, most: usize) {
    queue.push_back(item);
    queue.drain(..queue.len().saturating_sub(most));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::Tuning;
    use crate::rivals::tests::{pairs, scene, setting};
    use sim::synth::Scene;

    #[test]
    fn a_knock_is_followed_by_bounded_steps() {
        let before = scene(0.1, 0.1);
        let turn = 2e-3;
        let turned = Pose::of(&before.rig).moved(&Vector5::ith(0, turn));
        let after = Scene { rig: turned.extrinsics().unwrap(), ..before.clone() };
        let all = [pairs(&before, FRAMES), pairs(&after, 40)].concat();
        let agile = Setting { tuning: Tuning { agile: true, ..Tuning::default() }, ..setting() };
        let found = Teso.running(&all, &agile);
        let pose = |k: usize| Pose::of(&found[k].unwrap());
        let most = SCALE / 4.0 * 1.01;
        for k in FRAMES..found.len() {
            let step = pose(k - 1).step_to(&pose(k));
            assert!(step.amax() <= most, "{k}: {step}");
        }
        let off = |k: usize| pose(k).step_to(&turned)[0].abs();
        assert!(off(FRAMES) > 0.8 * turn, "{}", off(FRAMES));
        assert!(off(found.len() - 1) < 0.1 * turn, "{}", off(found.len() - 1));
    }
}
