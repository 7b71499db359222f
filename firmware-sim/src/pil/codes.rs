//! Small numbers for the core's enumerations. A variant that is not known here, of which the core may
//! get more, is `OTHER`.

use stereo_selfcal::{
    ApplyError, Arming, Band, CameraError, Direction, Doubt, Fused, PairError, Refusal, Rejection,
    Side, State, Stop,
};

use super::request::RequestError;

/// Nothing: no doubt, no rejection.
pub(super) const NONE: u8 = 0;

const OTHER: u8 = 0xff;

pub(super) fn state(state: State) -> u8 {
    match state {
        State::Acquiring => 1,
        State::Locked => 2,
        State::Suspect => 3,
        State::Lost => 4,
        _ => OTHER,
    }
}

pub(super) fn stop(stop: Stop) -> u8 {
    match stop {
        Stop::Converged => 1,
        Stop::NoDescent => 2,
        Stop::PassLimit => 3,
        _ => OTHER,
    }
}

/// Below 0x10 taken in, from 0x10 refused, from 0x20 not solved.
pub(super) fn fused(fused: Fused) -> u8 {
    match fused {
        Fused::Added => 1,
        Fused::Repeated => 2,
        Fused::KeptApart => 3,
        Fused::Renewed => 4,
        Fused::TookOver => 5,
        _ => OTHER,
    }
}

pub(super) fn refusal(refusal: Refusal) -> u8 {
    match refusal {
        Refusal::TooUncertain => 0x10,
        Refusal::CorrectionLimit => 0x11,
        Refusal::NoRig => 0x12,
        Refusal::Disagrees => 0x13,
        Refusal::Stale => 0x14,
        Refusal::Frozen => 0x15,
        Refusal::NotFinite => 0x16,
        _ => OTHER,
    }
}

pub(super) fn pair_error(error: PairError) -> u8 {
    match error {
        PairError::NoCameras => 0x20,
        PairError::NotBegun => 0x21,
        PairError::TooFew { .. } => 0x22,
        PairError::NoConsensus => 0x23,
        PairError::Unobservable => 0x24,
        _ => OTHER,
    }
}

pub(super) fn rejection(rejection: Rejection) -> u8 {
    match rejection {
        Rejection::Unsolved(why) => pair_error(why),
        Rejection::Refused(why) => refusal(why),
        _ => OTHER,
    }
}

pub(super) fn doubt(doubt: Doubt) -> u8 {
    match doubt {
        Doubt::Baseline => 1,
        Doubt::Everything => 2,
        Doubt::Axis => 3,
        _ => OTHER,
    }
}

pub(super) fn band(band: Band) -> u8 {
    match band {
        Band::Good => 1,
        Band::Improvable => 2,
        Band::Recalibrate => 3,
    }
}

pub(super) fn arming(arming: Arming) -> u8 {
    match arming {
        Arming::Yes => 1,
        Arming::NotLocked => 2,
        Arming::Doubtful => 3,
        Arming::Misaligned => 4,
    }
}

pub(super) fn direction(direction: Direction) -> u8 {
    match direction {
        Direction::Pitch => 1,
        Direction::Yaw => 2,
        Direction::Roll => 3,
        Direction::BaselineForward => 4,
        Direction::BaselineDown => 5,
    }
}

/// 0: applied.
pub(super) fn applied(refused: Option<ApplyError>) -> u8 {
    match refused {
        None => NONE,
        Some(ApplyError::NoProposal) => 1,
        Some(ApplyError::Inconsistent) => 2,
        Some(ApplyError::NotLocked(_)) => 3,
        Some(ApplyError::Doubtful) => 4,
        Some(ApplyError::Frozen) => 5,
        Some(_) => OTHER,
    }
}

/// 0: taken. From 0x10 the left camera, from 0x20 the right one.
pub(super) fn opening(refused: Option<RequestError>) -> u8 {
    match refused {
        None => NONE,
        Some(RequestError::BadMagic(_)) => 1,
        Some(RequestError::Version(_)) => 2,
        Some(RequestError::Lens(_)) => 3,
        Some(RequestError::Camera(side, why)) => {
            let of_side = match side {
                Side::Left => 0x10,
                Side::Right => 0x20,
            };
            let quantity = match why {
                CameraError::FocalLength => 1,
                CameraError::PrincipalPoint => 2,
                CameraError::ImageSize => 3,
                CameraError::Distortion => 4,
                _ => 0xf,
            };
            of_side | quantity
        }
    }
}
