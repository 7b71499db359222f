//! Fuzz harness: the public API under arbitrary input, in any order of calls. Checked properties: no panic, bounded
//! passes, finite and orthonormal output, state unchanged by refused calls.
//!
//! Shared by the fuzz targets and by property tests that run on any toolchain.

mod check;
mod host;
mod link;
mod paper;
mod record;
mod store;

pub use host::{run_bags, run_images, run_rigs, run_tables};
pub use link::{run_decoder, run_frames};
pub use record::run_record;
pub use store::run_store;

use arbitrary::{Arbitrary, Unstructured};
use nalgebra::{Matrix3, Vector3};
use stereo_selfcal::batch::Pushed;
use stereo_selfcal::geometry::{Fisheye, LensCorrection, RadialTangential, Rational};
use stereo_selfcal::outcome::StandardDeviations;
use stereo_selfcal::{
    Calibration, Calibrator, Camera, Cameras, Config, Correspondence, Extrinsics,
    FactoryCalibration, Fused, Intrinsics, Lens, LensTracking, Rejection, State,
};

use check::{check_begun_again, check_estimate, check_in_use, check_report, check_verdict};

type Target = Calibrator<f32, 32>;

/// One call of the public API.
#[derive(Debug, Clone, Arbitrary)]
pub enum Call {
    /// Any bits as a correspondence.
    Push([f32; 6]),
    /// A correspondence that roughly fits a rig: `u`, `v`, disparity, row offset.
    PushPlausible([u8; 4]),
    /// Twenty such correspondences at once, so that pairs are solved. Only the result of the last one counts.
    PushMany([u8; 24]),
    /// A whole `solve_pair`.
    Solve,
    /// One step of the pair.
    Advance,
    /// Applies the estimate.
    Apply,
    /// Undoes the last apply.
    Undo,
    /// Freezes the calibrator, or releases it.
    Freeze(bool),
    /// Reads verdict and details.
    Judge,
    /// Abandons the pair and empties the batch.
    Clear,
    /// Resets the calibrator.
    Reset,
    /// Any bits as intrinsics and lens, with the kind of the lens and the image size.
    SetCameras([f32; 9], u8, [u16; 2]),
    /// Usable intrinsics, with lens coefficients in hundredths; whether the lens is a fisheye or rational one.
    SetUsualCameras([i8; 5], bool),
    /// Any bits as extrinsics.
    SetFactory([f32; 12]),
    /// A usual rig: rotation vector and baseline in hundredths of a radian.
    SetUsualFactory([i8; 5]),
    /// Power off and on again.
    Restart,
    /// Rectified camera for the extrinsics in use, for any `alpha`.
    Rectify(f32),
}

/// Runs the calls that `bytes` encode.
///
/// # Panics
/// If the calibrator violates a property.
pub fn run_calibrator(bytes: &[u8]) {
    let mut input = Unstructured::new(bytes);
    let Configured { config, published, other: calibrated } = configured(&mut input);
    if published {
        return paper::run(&mut input);
    }
    let guess = FactoryCalibration::guess(usual_cameras([0; 5], false).expect("usual cameras"));
    let measured = FactoryCalibration::new(guess.cameras, guess.extrinsics);
    let mut made = Made { config, factory: if calibrated { measured } else { guess } };
    let mut calibrator = made.calibrator();
    while let Ok(call) = Call::arbitrary(&mut input) {
        let before = state(&calibrator);
        let unconfirmed = calibrator.state() == State::Acquiring;
        let batch = calibrator.batch().matches().to_vec();
        let refused = perform(&mut calibrator, &call, &mut made);
        let changed = before.generation != calibrator.in_use().generation;
        // The generation changes exactly if the calibration in use does. Calls that make a new calibrator are exempt,
        // because its generation starts anew.
        let counted = changed == (before.in_use != state(&calibrator).in_use);
        assert!(counted || call.makes_a_new_calibrator(), "{call:?}");
        assert!(!changed || call.may_change_what_is_in_use(), "{call:?}");
        let after = state(&calibrator);
        // An unconfirmed estimate is dropped when pairs disagree with it.
        let given_up = unconfirmed && after == Kept { proposed: None, ..before };
        let unchanged = match call {
            Call::Solve | Call::Advance => before.is_kept_or_wider_in(&after),
            _ => before == after,
        };
        assert!(!refused || given_up || unchanged, "a refused {call:?} changed the state");
        let begins = matches!(
            call,
            Call::PushMany(_)
                | Call::Push(_)
                | Call::PushPlausible(_)
                | Call::Solve
                | Call::Advance
        );
        let kept = begins || batch == calibrator.batch().matches();
        assert!(!refused || kept, "a refused {call:?} changed the batch");
        check_in_use(&calibrator, &made.factory);
        if let Some(estimate) = calibrator.proposal() {
            check_estimate(&estimate);
        }
        if input.is_empty() {
            break;
        }
    }
}

impl Call {
    fn makes_a_new_calibrator(&self) -> bool {
        matches!(
            self,
            Self::Restart
                | Self::SetCameras(..)
                | Self::SetUsualCameras(..)
                | Self::SetFactory(_)
                | Self::SetUsualFactory(_)
        )
    }

    fn may_change_what_is_in_use(&self) -> bool {
        matches!(self, Self::Apply | Self::Undo | Self::Reset) || self.makes_a_new_calibrator()
    }
}

/// Choices of a run: parameters, the published method instead of the calibrator, and another one.
struct Configured {
    config: Config,
    published: bool,
    other: bool,
}

/// The choices of two bytes.
fn configured(input: &mut Unstructured<'_>) -> Configured {
    let [first, other] = <[u8; 2]>::arbitrary(input).unwrap_or_default();
    let tracking = if first & 2 != 0 { LensTracking::Compensate } else { LensTracking::Report };
    let config = Config::robust().with_lens_tracking(tracking);
    Configured { config, published: first & 1 == 0, other: other & 1 != 0 }
}

type Proposed = (Extrinsics<f32>, LensCorrection<f32>, StandardDeviations<f32>, u32);

/// State that a refused call must not change. A refused pair may make the estimate suspect, but `State` is not part of
/// this.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kept {
    proposed: Option<Proposed>,
    in_use: (Cameras<f32>, Extrinsics<f32>),
    generation: u32,
}

impl Kept {
    /// Whether `after` equals this state, except that its deviations may be larger: a pair that disagrees may show
    /// vibration.
    fn is_kept_or_wider_in(&self, after: &Self) -> bool {
        let (Some((_, _, sd, _)), Some((_, _, wider, _))) = (&self.proposed, &after.proposed)
        else {
            return self == after;
        };
        let mut narrowed = *after;
        if let Some((_, _, deviations, _)) = &mut narrowed.proposed {
            *deviations = *sd;
        }
        *self == narrowed && wider.rotation >= sd.rotation && wider.translation >= sd.translation
    }
}

fn state(calibrator: &Target) -> Kept {
    let Calibration { cameras, extrinsics, generation } = calibrator.in_use();
    Kept {
        proposed: calibrator.proposal().map(|p| (p.extrinsics, p.correction, p.sd, p.pairs)),
        in_use: (cameras, extrinsics),
        generation,
    }
}

/// Performs a call; returns whether it was refused.
fn perform(calibrator: &mut Target, call: &Call, made: &mut Made) -> bool {
    match call {
        Call::Push(bits) => {
            let c = of_bits(bits);
            let held = calibrator.batch().matches().len();
            let pushed = calibrator.push(&c);
            let added = usize::from(pushed == Ok(Pushed::Kept));
            // The first push after a pair starts a new batch.
            let now = calibrator.batch().matches().len();
            assert!(now == held + added || now == added, "{pushed:?}");
            pushed.is_err()
        }
        Call::PushPlausible(bytes) => calibrator.push(&plausible(*bytes)).is_err(),
        Call::PushMany(bytes) => many(bytes).fold(false, |_, c| calibrator.push(&c).is_err()),
        Call::Solve => solve(calibrator).is_err(),
        Call::Advance => calibrator.advance_pair().is_some_and(|outcome| outcome.fused.is_err()),
        Call::Apply => {
            let proposal = calibrator.proposal();
            let applied = calibrator.apply();
            let of_proposal = proposal.and_then(|p| {
                let cameras = made.factory.cameras.corrected(&p.applicable_correction).ok()?;
                Some((cameras, p.applicable))
            });
            let found = applied.ok().map(|c| (c.cameras, c.extrinsics));
            assert!(applied.is_err() || found == of_proposal, "{applied:?} {of_proposal:?}");
            applied.is_err()
        }
        Call::Undo => calibrator.undo().is_err(),
        Call::Freeze(frozen) => {
            calibrator.set_frozen(*frozen);
            false
        }
        Call::Judge => {
            if let Some(details) = calibrator.details() {
                assert!(details.in_use_px.is_finite() && details.proposed_px.is_finite());
                assert!(details.yaw.is_finite());
            }
            check_verdict(calibrator.verdict());
            false
        }
        Call::Clear => {
            calibrator.discard_pair();
            false
        }
        Call::Reset => {
            calibrator.reset();
            false
        }
        Call::SetCameras(bits, lens, size) => {
            let camera = any_camera(bits, *lens, *size);
            camera.map(|c| made.with_cameras(Cameras { left: c, right: c }, calibrator)).is_none()
        }
        Call::SetUsualCameras(k, fisheye) => {
            usual_cameras(*k, *fisheye).map(|c| made.with_cameras(c, calibrator)).is_none()
        }
        Call::SetFactory(bits) => {
            let r = Matrix3::from_row_iterator(bits.iter().copied());
            let [.., x, y, z] = *bits;
            let factory = Extrinsics::try_new(&r, &Vector3::new(x, y, z));
            factory.map(|e| made.with_extrinsics(e, calibrator)).is_err()
        }
        Call::SetUsualFactory(bytes) => {
            let [x, y, z, ty, tz] = bytes.map(|b| f32::from(b) / 100.0);
            let r = stereo_selfcal::geometry::so3::exp(&Vector3::new(x, y, z)).expect("finite");
            let factory = Extrinsics::try_new(r.matrix(), &Vector3::new(-1.0, ty, tz));
            factory.map(|e| made.with_extrinsics(e, calibrator)).is_err()
        }
        Call::Restart => {
            *calibrator = link::restarted(calibrator, made.calibrator());
            false
        }
        Call::Rectify(alpha) => rectify(calibrator, *alpha),
    }
}

/// Inputs that a new calibrator is made from.
struct Made {
    config: Config,
    factory: FactoryCalibration<f32>,
}

impl Made {
    fn calibrator(&self) -> Target {
        Target::new(self.config, &self.factory)
    }

    fn with_cameras(&mut self, cameras: Cameras<f32>, calibrator: &mut Target) {
        self.factory.cameras = cameras;
        *calibrator = self.calibrator();
    }

    fn with_extrinsics(&mut self, extrinsics: Extrinsics<f32>, calibrator: &mut Target) {
        self.factory.extrinsics = extrinsics;
        *calibrator = self.calibrator();
    }
}

/// Solves and fuses the pair of the batch, and checks the result. `Err` if the pair is not fused.
fn solve(calibrator: &mut Target) -> Result<(), Rejection> {
    let before = state(calibrator);
    let unconfirmed = calibrator.state() == State::Acquiring;
    let outcome = calibrator.solve_pair();
    if let Some(report) = &outcome.pair {
        check_report(report, 24);
    }
    let after = state(calibrator);
    let given_up = unconfirmed && after == Kept { proposed: None, ..before };
    let unchanged = match outcome.fused {
        Err(Rejection::Disagrees) => before.is_kept_or_wider_in(&after),
        _ => before == after,
    };
    assert!(outcome.fused.is_ok() || given_up || unchanged, "a refused pair was fused");
    assert_eq!(before.in_use, after.in_use);
    assert_eq!(before.generation, after.generation);
    if outcome.fused == Ok(Fused::LensCorrected) {
        check_begun_again(calibrator);
    }
    // The pair has ended. A second call begins with an empty batch, so a pair counts once.
    let again = calibrator.clone().solve_pair();
    assert_eq!(again.fused, Err(Rejection::TooFew { usable: 0, needed: 12 }));
    outcome.fused.map(|_| ())
}

fn rectify(calibrator: &Target, alpha: f32) -> bool {
    let Ok((camera, [left, right])) = calibrator.in_use().homographies(alpha) else { return true };
    assert!(camera.focal.is_finite() && camera.focal > 0.0, "{camera:?}");
    assert!(left.iter().chain(right.iter()).all(|h| h.is_finite()), "{left} {right}");
    false
}

/// Any bits as a correspondence.
fn of_bits([a, b, c, d, score, grid_step]: &[f32; 6]) -> Correspondence<f32> {
    Correspondence { left: [*a, *b], right: [*c, *d], score: *score, grid_step: *grid_step }
}

/// Twenty correspondences that roughly fit a rig.
fn many(bytes: &[u8; 24]) -> impl Iterator<Item = Correspondence<f32>> + use<> {
    let [a, b, c, d, rest @ ..] = *bytes;
    let shift = move |i: usize| rest[i % rest.len()];
    (0..20).map(move |i| {
        plausible([
            a.wrapping_add(shift(i)),
            b.wrapping_mul(shift(i + 7)),
            c.wrapping_add(shift(i + 3) / 4),
            d / 16,
        ])
    })
}

fn plausible([u, v, disparity, row]: [u8; 4]) -> Correspondence<f32> {
    let [u, v, disparity] = [u, v, disparity].map(f32::from);
    let row = f32::from(row) / 64.0;
    Correspondence {
        left: [100.0 + 2.0 * u, 2.0 * v],
        right: [100.0 + 2.0 * u - disparity / 3.0, 2.0 * v + row],
        score: 1.0,
        grid_step: 0.0,
    }
}

fn lens(k: [f32; 5], fisheye: bool) -> Option<Lens<f32>> {
    let [k1, k2, k3, k4, k5] = k;
    if fisheye && k5 < 0.0 {
        // A rational lens whose quotient has either sign, from a few numbers.
        Rational::try_new([k1, k2, k3, k4, k5, -k1, k2, k3]).ok().map(Lens::Rational)
    } else if fisheye {
        Fisheye::try_new([k1, k2, k3, k4]).ok().map(Lens::Fisheye)
    } else {
        RadialTangential::try_new(k).ok().map(Lens::RadialTangential)
    }
}

fn usual_cameras(k: [i8; 5], fisheye: bool) -> Option<Cameras<f32>> {
    let intrinsics = Intrinsics { focal: [530.0; 2], principal: [342.0, 234.0], size: [640, 480] };
    let lens = lens(k.map(|k| f32::from(k) / 100.0), fisheye)?;
    let camera = Camera::try_new(intrinsics, lens).ok()?;
    Some(Cameras { left: camera, right: camera })
}

fn any_camera(bits: &[f32; 9], kind: u8, size: [u16; 2]) -> Option<Camera<f32>> {
    let [fx, fy, cx, cy, k @ ..] = *bits;
    let lens = if kind == 0 { Lens::Pinhole } else { lens(k, kind.is_multiple_of(2))? };
    Camera::try_new(Intrinsics { focal: [fx, fy], principal: [cx, cy], size }, lens).ok()
}
