//! Records that outlast a loss of power: the factory calibration, and the state of a calibrator.

mod calibrator;
pub(crate) mod factory;
