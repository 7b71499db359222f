//! Rigs of generated scenes.

use anyhow::{Context, Result};
use nalgebra::Vector3;
use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::so3;

/// A rig that deviates from `R = I`, `t = (-1, 0, 0)`.
///
/// * `rotation_deg`: rotation vector of `R`, degrees.
/// * `baseline_deg`: turn of `t` about y and z, degrees.
///
/// # Errors
/// If a number is not finite, or the baseline lies along an optical axis.
pub fn rig(rotation_deg: [f64; 3], baseline_deg: [f64; 2]) -> Result<Extrinsics<f64>> {
    let exp = |degrees: Vector3<f64>| {
        so3::exp(&degrees.map(f64::to_radians)).ok_or_else(|| anyhow::anyhow!("not finite"))
    };
    let r = exp(Vector3::from(rotation_deg))?;
    let [y, z] = baseline_deg;
    let t = exp(Vector3::new(0.0, y, z))? * -Vector3::x();
    Ok(Extrinsics::try_new(r.matrix(), &t)?)
}

/// The rig of the project's figures: each component of the rotation vector of `R` is 5 degrees, and `t` is turned by 5
/// degrees.
///
/// # Panics
/// Never: the extrinsics are valid.
pub fn five_degrees_off() -> Extrinsics<f64> {
    let turn = Vector3::repeat(5.0_f64.to_radians());
    let r = so3::exp(&turn).expect("finite");
    let t = so3::exp(&Vector3::new(0.0, 3.5, 3.6).map(f64::to_radians)).expect("finite")
        * -Vector3::x();
    Extrinsics::try_new(r.matrix(), &t).expect("a rig")
}

/// The rig after a turn of its right camera about an axis of its own frame: `Q R`, `Q t`.
pub(super) fn turned(
    rig: &Extrinsics<f64>,
    axis: &Vector3<f64>,
    degrees: f64,
) -> Result<Extrinsics<f64>> {
    let turn = so3::exp(&(axis * degrees.to_radians())).context("turn must be finite")?;
    let r = turn * rig.rotation();
    Ok(Extrinsics::try_new(r.matrix(), &(turn * rig.translation().into_inner()))?)
}
