//! Whether the extrinsics that a run starts from are those of a calibration.

use stereo_selfcal::{Config, Extrinsics, Scalar};

use crate::data::Meta;

/// The configuration with what the rig's file says of its factory calibration: length of the baseline, and deviation of
/// the yaw. Where it says nothing of that, the identity is a calibration of recorded images without distortion, which
/// have been rectified, and a guess of all others.
#[must_use]
pub(super) fn informed<T: Scalar>(config: Config, rig: &Meta, start: &Extrinsics<T>) -> Config {
    // A length out of range is none.
    let length = rig.baseline_m.map(f32::lit).and_then(|m| config.with_baseline_m(m).ok());
    let config = length.unwrap_or(config);
    match rig.other.get(Meta::FACTORY_YAW_SD) {
        Some(sd) => {
            let rad = sd.as_f64().map(|deg| f32::lit(deg.to_radians()));
            let with = rad.and_then(|rad| config.with_factory_yaw_sd_rad(rad).ok());
            with.unwrap_or(config.without_factory_yaw())
        }
        None if *start == Extrinsics::SIDE_BY_SIDE && !is_rectified(rig) => {
            config.without_factory_yaw()
        }
        None => config,
    }
}

/// Whether images were recorded, and rectified since.
fn is_rectified(rig: &Meta) -> bool {
    let undistorted = rig.dist_l.iter().chain(&rig.dist_r).all(|k| *k == 0.0);
    undistorted && rig.source != "generated"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Dataset;

    #[test]
    fn the_identity_is_a_calibration_of_rectified_images_and_a_guess_of_others() {
        let set = |name: &str| Dataset::load(&Dataset::shipped().join(name)).unwrap();
        let config = Config::robust();
        let of = |rig: &Meta, start| informed::<f64>(Config::robust(), rig, &start);
        let identity = Extrinsics::SIDE_BY_SIDE;
        let guess = config.without_factory_yaw();
        let strip = |meta: &Meta| Meta { baseline_m: None, ..meta.clone() };
        let (raw, rectified) = (set("opencv_chess_sift"), set("oak_sift"));
        let [raw_meta, rectified_meta] = [strip(&raw.meta), strip(&rectified.meta)];
        assert_eq!(of(&raw_meta, identity), guess);
        assert_eq!(of(&raw_meta, raw.truth().unwrap()), config);
        assert_eq!(of(&rectified_meta, identity), config);
        let mut told = rectified_meta;
        told.other.insert(Meta::FACTORY_YAW_SD.into(), serde_json::Value::Null);
        assert_eq!(of(&told, identity), guess);
    }
}
