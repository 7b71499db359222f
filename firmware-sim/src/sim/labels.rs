//! Printed labels of the core's enumerations.

use stereo_selfcal::outcome::Direction;
use stereo_selfcal::{Reason, Reasons, Verdict};

pub(super) fn arming(verdict: &Verdict<f32>) -> &'static str {
    if verdict.may_arm {
        return "yes";
    }
    match verdict.reasons.iter().next() {
        Some(Reason::NotLocked) => "no: not locked",
        Some(Reason::SecondMode | Reason::Biased) => "no: doubtful",
        Some(Reason::Unfit) => "no: matches do not support it",
        Some(Reason::Evidence) if !verdict.rows_ok => "no: rows",
        Some(Reason::Evidence) => "no: not confirmed",
        Some(Reason::Depth) => "no: depth",
        _ => "no",
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

/// The strongest doubt of the matches.
pub(super) fn doubt(reasons: Reasons) -> Option<&'static str> {
    Some(match sim::run::doubt(reasons)? {
        Reason::SecondMode => "second crowd of matches: not applied",
        Reason::Biased => "image halves disagree: not applied",
        Reason::ImageHalves => "image halves disagree",
        _ => "axis uncertain",
    })
}
