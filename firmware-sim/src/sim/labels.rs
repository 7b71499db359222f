//! Printed labels of the core's enumerations.

use stereo_selfcal::outcome::Direction;
use stereo_selfcal::{Arming, Band, Doubt};

pub(super) fn band(band: Band) -> &'static str {
    match band {
        Band::Good => "good",
        Band::Improvable => "improvable",
        Band::Recalibrate => "recalibrate",
        Band::Unknown => "unknown",
    }
}

pub(super) fn arming(arming: Arming) -> &'static str {
    match arming {
        Arming::Yes => "yes",
        Arming::NotLocked => "no: not locked",
        Arming::Doubtful => "no: doubtful",
        Arming::Misaligned => "no: misaligned",
        Arming::Unfit => "no: matches do not support it",
    }
}

pub(super) fn direction(direction: Direction) -> &'static str {
    match direction {
        Direction::Pitch => "pitch",
        Direction::Yaw => "yaw",
        Direction::Roll => "roll",
        Direction::BaselineForward => "t_z",
        Direction::BaselineDown => "t_y",
    }
}

pub(super) fn doubt(doubt: Doubt) -> &'static str {
    match doubt {
        Doubt::Baseline => "image halves disagree: t held",
        Doubt::Everything => "image halves disagree: not applied",
        Doubt::SecondMode => "second crowd of matches: not applied",
        Doubt::Axis => "axis uncertain",
        _ => "doubtful",
    }
}
