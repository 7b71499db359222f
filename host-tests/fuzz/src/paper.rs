//! The published method under the same calls as the calibrator, as far as it has them.

use arbitrary::{Arbitrary, Unstructured};
use stereo_selfcal::paper::{PaperCalibrator, Settings};
use stereo_selfcal::{Cameras, Extrinsics};

use super::check::{check_extrinsics, check_report};
use super::{Call, any_camera, many, of_bits, plausible, usual_cameras};

type Target = PaperCalibrator<f32, 32>;

/// Runs the calls that follow.
///
/// # Panics
/// If the method violates a property.
pub(super) fn run(input: &mut Unstructured<'_>) {
    let mut target = with(usual_cameras([0; 5], false).expect("usual cameras"));
    while let Ok(call) = Call::arbitrary(input) {
        let before = target.estimate();
        let outcome = match call {
            Call::Push(bits) => {
                let _ = target.push(&of_bits(&bits));
                None
            }
            Call::PushPlausible(bytes) => {
                let _ = target.push(&plausible(bytes));
                None
            }
            Call::PushMany(bytes) => {
                many(&bytes).for_each(|c| {
                    let _ = target.push(&c);
                });
                None
            }
            Call::Solve => Some(target.solve_pair()),
            Call::Advance => target.advance_pair(),
            Call::Clear => {
                target.discard_pair();
                None
            }
            Call::Reset => {
                target.reset();
                assert_eq!(target.estimate(), None);
                continue;
            }
            Call::SetCameras(bits, lens, size) => {
                let camera = any_camera(&bits, lens, size);
                target = camera.map_or(target, |c| with(Cameras { left: c, right: c }));
                continue;
            }
            Call::SetUsualCameras(k, fisheye) => {
                target = usual_cameras(k, fisheye).map_or(target, with);
                continue;
            }
            _ => continue,
        };
        let after = target.estimate();
        let fused = outcome.is_some_and(|outcome| outcome.fused.is_ok());
        assert!(fused || before == after, "a refused pair was fused");
        if let Some(report) = outcome.and_then(|outcome| outcome.pair) {
            check_report(&report, 100);
        }
        if let Some(estimate) = after {
            check_extrinsics(&estimate.extrinsics);
            assert!(estimate.sd.rotation.is_finite() && estimate.sd.translation.is_finite());
        }
        if input.is_empty() {
            break;
        }
    }
}

fn with(cameras: Cameras<f32>) -> Target {
    Target::new(Settings::DEFAULT, cameras, Extrinsics::SIDE_BY_SIDE)
}
