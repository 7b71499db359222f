//! A flight: motion of a rig from take-off to landing.

use std::f64::consts::PI;

use anyhow::{Result, ensure};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::Extrinsics;

use super::normal::normal;
use super::rig::turned;
use super::scene::Scene;

/// Share of outliers.
pub(super) const OUTLIERS: f64 = 0.3;

/// Turn of the right camera by the knock in mid flight, degrees.
pub(super) const KNOCK_DEG: f64 = 0.3;

/// Turn of the right camera about each axis, drawn anew for every pair, degrees RMS.
pub(super) const VIBRATION_DEG: f64 = 0.005;

/// Turn of the right camera by heat, from take-off to landing, degrees.
const WARP_DEG: f64 = 0.05;

/// Axis of the turn by heat: the bar between the cameras bends and twists. Unit length.
const WARP_AXIS: [f64; 3] = [0.48, 0.60, 0.64];

/// Ratio of all depths at the highest point to those on the ground.
const CEILING: f64 = 10.0;

/// One pair of a flight.
pub(super) struct Part {
    /// Number of the pair, from 0, and number of pairs of the flight.
    pub(super) at: [usize; 2],
    /// Turn by the knock, degrees; 0 before it.
    pub(super) knock_deg: f64,
    /// Vibration of the right camera about each axis, degrees RMS.
    pub(super) vibration_deg: f64,
}

impl Part {
    /// The scene of the pair.
    ///
    /// * `base`: the scene on the ground, before take-off.
    /// * `axis`: axis of the knock.
    pub(super) fn scene(
        &self,
        base: &Scene,
        axis: &Vector3<f64>,
        rng: &mut ChaCha8Rng,
    ) -> Result<Scene> {
        ensure!(self.vibration_deg.is_finite(), "vibration must be finite");
        let [pair, pairs] = self.at;
        let flown = f64::from(u32::try_from(pair)?) / f64::from(u32::try_from(pairs)?);
        let warped = turned(&base.rig, &WARP_AXIS.into(), flown * WARP_DEG)?;
        let knocked = turned(&warped, axis, self.knock_deg)?;
        // Drawn even if the vibration is 0, so that all other draws are the same without vibration.
        let shake: Vector3<f64> = Vector3::from_fn(|_, _| normal(rng));
        let rig: Extrinsics<f64> = turned(&knocked, &shake, self.vibration_deg)?;
        let height = libm::pow(CEILING, libm::sin(PI * flown));
        Ok(Scene { rig, depth: base.depth.times(height), ..base.clone() })
    }
}
