//! The start of a run: the factory calibration of its calibrator.

use anyhow::Result;
use stereo_selfcal::{Extrinsics, FactoryCalibration, Scalar};

use rigs::data::Meta;

/// Extrinsics that a run starts from. Nothing but the caller's word makes them a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start<T: Scalar> {
    /// `R = I`, `t = (-1, 0, 0)`, a guess: the rows show the yaw.
    Guess,
    /// Extrinsics that a calibration has measured: the estimate keeps their yaw until the mount turns.
    Calibration(Extrinsics<T>),
}

impl<T: Scalar> Start<T> {
    /// The usual start of a run: `R` and `t` of the rig if a calibration has measured them, otherwise a guess.
    ///
    /// # Errors
    /// If they are not valid.
    pub fn usual(rig: &Meta) -> Result<Self> {
        if rig.is_calibrated() { Ok(Self::Calibration(rig.extrinsics()?)) } else { Ok(Self::Guess) }
    }

    /// The extrinsics.
    pub fn extrinsics(&self) -> Extrinsics<T> {
        match self {
            Self::Guess => Extrinsics::SIDE_BY_SIDE,
            Self::Calibration(extrinsics) => *extrinsics,
        }
    }
}

/// The factory calibration of a run: the cameras of the rig, the extrinsics of the start, and, from the rig's file, the
/// length of the baseline and the standard deviation of the yaw.
///
/// If the file has the key of the deviation, it decides: the yaw of the start has this deviation, or is a guess if the
/// value is null or out of range.
///
/// # Errors
/// If the cameras are not valid.
pub(super) fn of<T: Scalar>(rig: &Meta, start: Start<T>) -> Result<FactoryCalibration<T>> {
    let made = FactoryCalibration::new(rig.cameras()?, start.extrinsics());
    // A length out of range counts as unknown.
    let length = rig.baseline_m.map(f32::lit).and_then(|m| made.with_baseline_m(m).ok());
    let made = length.unwrap_or(made);
    Ok(match (rig.other.get(Meta::FACTORY_YAW_SD), start) {
        (Some(sd), _) => {
            let rad = sd.as_f64().map(|deg| f32::lit(deg.to_radians()));
            let with = rad.and_then(|rad| made.with_yaw_sd_rad(rad).ok());
            with.unwrap_or(made.without_yaw())
        }
        (None, Start::Guess) => made.without_yaw(),
        (None, Start::Calibration(_)) => made,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rigs::data::Dataset;

    #[test]
    fn only_a_start_that_is_called_a_calibration_keeps_its_yaw_unless_the_rig_says_otherwise() {
        let meta = Dataset::load(&Dataset::shipped().join("opencv_chess_sift")).unwrap().meta;
        let keeps = |meta: &Meta, start| of::<f64>(meta, start).unwrap().yaw_sd_rad().is_some();
        let calibration = Start::Calibration(Extrinsics::SIDE_BY_SIDE);
        assert_eq!([Start::Guess, calibration].map(|start| keeps(&meta, start)), [false, true]);
        let mut told = meta;
        told.other.insert(Meta::FACTORY_YAW_SD.into(), serde_json::Value::Null);
        assert!(!keeps(&told, calibration));
    }
}
