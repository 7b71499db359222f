//! Factory calibration of a run, and whether its extrinsics count as calibrated or as a guess.

use anyhow::Result;
use stereo_selfcal::{Extrinsics, FactoryCalibration, Scalar};

use rigs::data::Meta;

/// The factory calibration of a run: the cameras of the rig, the extrinsics of the start, and, from the rig's file, the
/// length of the baseline and the standard deviation of the yaw.
///
/// If the file has the key of the deviation, but a value that is null or out of range, the yaw counts as a guess.
/// Without the key, `R = I`, `t = (-1, 0, 0)` counts as a calibration if the images were recorded and then rectified,
/// and as a guess otherwise. Any other start counts as a calibration.
///
/// # Errors
/// If the cameras are not valid.
pub(super) fn of<T: Scalar>(rig: &Meta, start: Extrinsics<T>) -> Result<FactoryCalibration<T>> {
    let made = FactoryCalibration::new(rig.cameras()?, start);
    // A length out of range counts as unknown.
    let length = rig.baseline_m.map(f32::lit).and_then(|m| made.with_baseline_m(m).ok());
    let made = length.unwrap_or(made);
    Ok(match rig.other.get(Meta::FACTORY_YAW_SD) {
        Some(sd) => {
            let rad = sd.as_f64().map(|deg| f32::lit(deg.to_radians()));
            let with = rad.and_then(|rad| made.with_yaw_sd_rad(rad).ok());
            with.unwrap_or(made.without_yaw())
        }
        None if start == Extrinsics::SIDE_BY_SIDE && !is_rectified(rig) => made.without_yaw(),
        None => made,
    })
}

/// Whether the images were recorded and then rectified: they have no distortion, and are not generated.
fn is_rectified(rig: &Meta) -> bool {
    let undistorted = rig.dist_l.iter().chain(&rig.dist_r).all(|k| *k == 0.0);
    undistorted && rig.source != "generated"
}

#[cfg(test)]
mod tests {
    use super::*;
    use rigs::data::Dataset;

    #[test]
    fn the_identity_is_a_calibration_of_rectified_images_and_a_guess_of_others() {
        let set = |name: &str| Dataset::load(&Dataset::shipped().join(name)).unwrap();
        let of = |rig: &Meta, start| of::<f64>(rig, start).unwrap().yaw_sd_rad().is_some();
        let identity = Extrinsics::SIDE_BY_SIDE;
        let strip = |meta: &Meta| Meta { baseline_m: None, ..meta.clone() };
        let (raw, rectified) = (set("opencv_chess_sift"), set("oak_sift"));
        let [raw_meta, rectified_meta] = [strip(&raw.meta), strip(&rectified.meta)];
        assert!(!of(&raw_meta, identity));
        assert!(of(&raw_meta, raw.truth().unwrap()));
        assert!(of(&rectified_meta, identity));
        let mut told = rectified_meta;
        told.other.insert(Meta::FACTORY_YAW_SD.into(), serde_json::Value::Null);
        assert!(!of(&told, identity));
    }
}
