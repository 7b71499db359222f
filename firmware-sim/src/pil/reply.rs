//! Replies of the controller: records of fixed layout, floats as their bits.
//!
//! A host builds the same records from its own run and compares them.

use stereo_selfcal::{
    ApplyError, Calibrator, Extrinsics, Fused, Health, PairReport, Proposal, Rejection,
};
use zerocopy::little_endian::{F32, U16, U32};
use zerocopy::{FromBytes, FromZeros, Immutable, IntoBytes, Unaligned};

use super::request::RequestError;
use crate::app::PairOutcome;

const VERSION: u8 = 4;

/// Reply to a request, 9 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
pub struct SessionReply {
    magic: [u8; 4],
    version: u8,
    refused: U16,
    capacity: U16,
}

impl SessionReply {
    const MAGIC: [u8; 4] = *b"SCPG";

    /// A reply to a request.
    ///
    /// * `refused`: the error of the request, if it is refused.
    /// * `capacity`: correspondences per pair that fit the batch of the controller.
    #[must_use]
    pub fn new(refused: Option<RequestError>, capacity: u16) -> Self {
        let refused = refused.map_or(0, |why| why.code()).into();
        Self { magic: Self::MAGIC, version: VERSION, refused, capacity: capacity.into() }
    }

    /// Whether magic and version are right.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.magic == Self::MAGIC && self.version == VERSION
    }

    /// Code of the error of the request. `None` if the request is accepted.
    #[must_use]
    pub fn refused(&self) -> Option<u16> {
        (self.refused != 0).then_some(self.refused.get())
    }

    /// Correspondences per pair that fit the batch of the controller.
    #[must_use]
    pub fn capacity(&self) -> u16 {
        self.capacity.get()
    }
}

/// Result of a pair, 236 bytes. Fields without a value are zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
pub struct PairReply {
    magic: [u8; 4],
    sequence: U32,
    taken: U16,
    /// Code of `Fused`; code of `Rejection` if the pair is refused or not solved.
    outcome: U16,
    state: U16,
    pair: Solved,
    estimate: Estimate,
    health: HealthFields,
}

/// `R` row-major, then `t`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct Rig {
    r: [F32; 9],
    t: [F32; 3],
}

/// Result of the pair alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct Solved {
    rig: Rig,
    passes: U16,
    stop: U16,
    /// Also set if too few correspondences are usable.
    usable: U32,
    screened: U32,
    rms_px: [F32; 2],
    noise_px: F32,
}

/// The estimate after the pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct Estimate {
    rig: Rig,
    applicable: Rig,
    pairs: U32,
    /// Deviations of `R` and of `t`, rad.
    sd: [F32; 2],
    weakest_sd: F32,
    /// 1 if there is an estimate, its least certain direction, and the reasons against it.
    verdicts: [U16; 3],
}

/// Health over the matches of the pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct HealthFields {
    rms_px: [F32; 2],
    fit: [U32; 2],
    coverage: F32,
    yaw: F32,
    /// 1 if there is health; its band, reasons and rejection.
    verdicts: [U16; 4],
}

/// A field of a reply, for comparison and display.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field<'a> {
    /// Name of the field.
    pub name: &'static str,
    /// Bytes on the wire.
    pub bytes: &'a [u8],
    /// Whether the bytes are `f32`.
    pub floats: bool,
}

fn numbers<'a>(name: &'static str, bytes: &'a (impl IntoBytes + Immutable + ?Sized)) -> Field<'a> {
    Field { name, bytes: bytes.as_bytes(), floats: false }
}

fn floats<'a>(name: &'static str, bytes: &'a (impl IntoBytes + Immutable + ?Sized)) -> Field<'a> {
    Field { name, bytes: bytes.as_bytes(), floats: true }
}

impl PairReply {
    const MAGIC: [u8; 4] = *b"SCPA";

    /// Result of a pair, and the estimate after it.
    ///
    /// * `taken`: correspondences in the batch.
    #[must_use]
    pub fn new<const N: usize>(
        sequence: u32,
        taken: usize,
        pair: &PairOutcome,
        calibrator: &Calibrator<f32, N>,
    ) -> Self {
        Self {
            magic: Self::MAGIC,
            sequence: sequence.into(),
            // A batch holds at most 16384 correspondences.
            taken: u16::try_from(taken).unwrap_or(u16::MAX).into(),
            outcome: outcome(&pair.outcome).into(),
            state: calibrator.state().code().into(),
            pair: Solved::of(&pair.outcome),
            estimate: Estimate::of(calibrator.proposal().as_ref()),
            health: HealthFields::of(pair.health.as_ref()),
        }
    }

    /// Whether the magic is right.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.magic == Self::MAGIC
    }

    /// The matcher's number of the frame.
    #[must_use]
    pub fn sequence(&self) -> u32 {
        self.sequence.get()
    }

    /// All fields but the magic.
    #[must_use]
    pub fn fields(&self) -> [Field<'_>; 22] {
        let Self { pair, estimate, health, .. } = self;
        [
            numbers("sequence", &self.sequence),
            numbers("matches taken", &self.taken),
            numbers("outcome", &self.outcome),
            numbers("state", &self.state),
            floats("R, t of the pair", &pair.rig),
            numbers("passes", &pair.passes),
            numbers("stop", &pair.stop),
            numbers("usable", &pair.usable),
            numbers("screened", &pair.screened),
            floats("row offsets of the pair", &pair.rms_px),
            floats("noise", &pair.noise_px),
            floats("R, t of the estimate", &estimate.rig),
            floats("R, t to be applied", &estimate.applicable),
            numbers("pairs behind the estimate", &estimate.pairs),
            floats("standard deviations", &estimate.sd),
            floats("deviation of the weakest direction", &estimate.weakest_sd),
            numbers("weakest direction, reasons", &estimate.verdicts),
            floats("health: row offsets", &health.rms_px),
            numbers("health: matches that fit", &health.fit),
            floats("health: coverage", &health.coverage),
            floats("health: yaw", &health.yaw),
            numbers("health: verdicts", &health.verdicts),
        ]
    }
}

fn outcome(outcome: &Result<(PairReport<f32>, Result<Fused, Rejection>), Rejection>) -> u16 {
    match outcome {
        Ok((_, Ok(fused))) => fused.code(),
        Ok((_, Err(why))) | Err(why) => why.code(),
    }
}

impl Rig {
    fn of(extrinsics: &Extrinsics<f32>) -> Self {
        let t = extrinsics.translation();
        Self { r: extrinsics.rotation_row_major().map(F32::new), t: [t.x, t.y, t.z].map(F32::new) }
    }
}

impl Solved {
    fn of(outcome: &Result<(PairReport<f32>, Result<Fused, Rejection>), Rejection>) -> Self {
        let nothing = Self::new_zeroed();
        match outcome {
            Ok((report, _)) => Self {
                rig: Rig::of(&report.extrinsics),
                passes: report.passes.into(),
                stop: report.stop.code().into(),
                usable: report.usable.into(),
                screened: report.screened.into(),
                rms_px: [report.rms_px_before, report.rms_px_after].map(F32::new),
                noise_px: F32::new(report.noise_px),
            },
            Err(Rejection::TooFew { usable, .. }) => Self { usable: (*usable).into(), ..nothing },
            Err(_) => nothing,
        }
    }
}

impl Estimate {
    fn of(proposal: Option<&Proposal<f32>>) -> Self {
        let Some(proposal) = proposal else { return Self::new_zeroed() };
        let weakest = proposal.weakest();
        Self {
            rig: Rig::of(&proposal.extrinsics),
            applicable: Rig::of(&proposal.applicable),
            pairs: proposal.pairs.into(),
            sd: [proposal.sd.rotation, proposal.sd.translation].map(F32::new),
            weakest_sd: F32::new(weakest.map_or(0.0, |(_, sd)| sd)),
            verdicts: [
                1,
                weakest.map_or(0, |(direction, _)| direction.code()),
                proposal.reasons().bits(),
            ]
            .map(U16::new),
        }
    }
}

impl HealthFields {
    fn of(health: Option<&Health<f32>>) -> Self {
        let Some(health) = health else { return Self::new_zeroed() };
        Self {
            rms_px: [health.in_use_px, health.proposed_px].map(F32::new),
            fit: [health.fit_in_use, health.fit_proposed].map(U32::new),
            coverage: F32::new(health.coverage),
            yaw: F32::new(health.yaw),
            verdicts: [
                1,
                health.band.code(),
                health.reasons.bits(),
                health.rejection.map_or(0, |why| why.code()),
            ]
            .map(U16::new),
        }
    }
}

/// The extrinsics in use after the last pair, 58 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
pub struct EndReply {
    magic: [u8; 4],
    generation: U32,
    in_use: Rig,
    applied: U16,
}

impl EndReply {
    const MAGIC: [u8; 4] = *b"SCPE";

    /// The calibration in use of a calibrator.
    ///
    /// * `refused`: the error of applying the estimate, if there is one.
    #[must_use]
    pub fn new<const N: usize>(
        refused: Option<ApplyError>,
        calibrator: &Calibrator<f32, N>,
    ) -> Self {
        Self {
            magic: Self::MAGIC,
            generation: calibrator.in_use().generation.into(),
            in_use: Rig::of(&calibrator.in_use().extrinsics),
            applied: refused.map_or(0, |why| why.code()).into(),
        }
    }

    /// Whether the magic is right.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.magic == Self::MAGIC
    }

    /// All fields but the magic.
    #[must_use]
    pub fn fields(&self) -> [Field<'_>; 3] {
        [
            numbers("generation", &self.generation),
            floats("R, t in use", &self.in_use),
            numbers("applied", &self.applied),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_frames::correspondence;
    use crate::{Controller, start};
    use std::vec::Vec;
    use stereo_selfcal::{Camera, Cameras, Intrinsics, Lens};

    fn controller() -> Controller {
        let intrinsics =
            Intrinsics { focal: [1400.0; 2], principal: [960.0, 600.0], size: [1920, 1200] };
        let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        start(Cameras { left: camera, right: camera })
    }

    fn solved(controller: &mut Controller, matches: u16) -> PairOutcome {
        for c in (0..matches).map(correspondence) {
            controller.push(&c).unwrap();
        }
        let outcome = crate::solve_and_fuse(controller);
        PairOutcome { outcome, health: controller.health().ok(), motion: None }
    }

    #[test]
    fn the_lengths_are_the_documented_ones() {
        assert_eq!([size_of::<SessionReply>(), size_of::<PairReply>()], [9, 236]);
        assert_eq!(size_of::<EndReply>(), 58);
    }

    #[test]
    fn a_reply_is_laid_out_in_the_order_of_its_fields() {
        let mut controller = controller();
        let pair = solved(&mut controller, 60);
        let reply = PairReply::new(7, 60, &pair, &controller);
        let bytes = reply.as_bytes();
        assert_eq!(bytes[..14], [b'S', b'C', b'P', b'A', 7, 0, 0, 0, 60, 0, 0, 0, 0, 0]);
        let (report, _) = pair.outcome.unwrap();
        let r = report.extrinsics.rotation_row_major();
        assert_eq!(bytes[14..18], r[0].to_le_bytes());
        assert_eq!(bytes[58..62], report.extrinsics.translation().z.to_le_bytes());
        assert_eq!(bytes[62..64], report.passes.to_le_bytes());
        assert_eq!(reply.fields().iter().map(|field| field.bytes.len()).sum::<usize>(), 236 - 4);
    }

    #[test]
    fn a_pair_without_a_solution_has_its_error_code_and_zeros() {
        let mut controller = controller();
        let pair = solved(&mut controller, 5);
        let reply = PairReply::new(0, 5, &pair, &controller);
        assert_eq!((reply.outcome.get(), reply.pair.usable.get()), (502, 5));
        assert_eq!((reply.pair.rig.r, reply.estimate.verdicts), ([F32::ZERO; 9], [U16::ZERO; 3]));
        assert!(reply.health.as_bytes().iter().all(|&byte| byte == 0));
    }

    #[test]
    fn one_bit_of_the_estimate_changes_its_field_alone() {
        let mut controller = controller();
        let pair = solved(&mut controller, 60);
        let reply = PairReply::new(0, 60, &pair, &controller);
        let mut other = reply;
        let [x, ..] = &mut other.estimate.rig.t;
        *x = F32::new(f32::from_bits(x.get().to_bits() ^ 1));
        let differ: Vec<&str> = reply
            .fields()
            .iter()
            .zip(other.fields())
            .filter(|(a, b)| *a != b)
            .map(|(a, _)| a.name)
            .collect();
        assert_eq!(differ, ["R, t of the estimate"]);
    }
}
