//! Readings of witnesses that contradict the yaw are counted and named.

use crate::api::depth::{NONE, Tested, reading, run, tracked, warped, with_baseline};
use crate::api::scene::take;
use stereo_selfcal::depth::{MotionError, RangeError, RangeReading, Witnessed};

fn counts(calibrator: &Tested) -> [u16; 2] {
    let health = calibrator.health().unwrap();
    let counts = [health.contradicting_ranges, health.contradicting_motions];
    let [ranges, motions] = counts;
    let named = format!("contradicted by {ranges} ranges and {motions} motions");
    assert_eq!(health.to_string().contains(&named), counts != [0; 2], "{health}");
    counts
}

#[test]
fn ranges_and_motions_that_contradict_are_counted_until_a_reset() {
    let mut calibrator = with_baseline();
    run(&mut calibrator, NONE, 0.002, 0..8);
    let pair = warped(NONE, 0.002, 8);
    take(&mut calibrator, &pair).unwrap();
    let near = pair.iter().find(|c| c.left[0] - c.right[0] > 60.0).unwrap();
    let right = reading(NONE, near, 1.0);
    // Readings that say nothing of the yaw do not count.
    let bad = RangeReading { sd_m: f32::NAN, ..right };
    assert_eq!(calibrator.push_range(&bad), Err(RangeError::Reading));
    assert_eq!(calibrator.push_range(&right), Ok(Witnessed::Taken));
    assert_eq!(counts(&calibrator), [0, 0]);
    for (factor, count) in [(0.1, 1), (0.5, 2), (10.0, 3)] {
        let wrong = reading(NONE, near, factor);
        assert_eq!(calibrator.push_range(&wrong), Err(RangeError::Contradicts), "{factor}");
        assert_eq!(counts(&calibrator), [count, 0]);
    }
    // A reading that waits counts too.
    let slightly = [0.97, 0.95, 0.93, 0.9].map(|factor| reading(NONE, near, factor));
    let mut waits = slightly.iter().map(|of| calibrator.push_range(of));
    assert!(waits.any(|of| of == Ok(Witnessed::Waiting)));
    assert_eq!(counts(&calibrator), [4, 0]);
    // Tracks of a rig that is turned by two degrees.
    let other = tracked([0.0, 2.0, 0.0], 0.0, [0.5, 0.1, -4.0], 0.0);
    assert_eq!(calibrator.push_motion(&other), Err(MotionError::Contradicts));
    assert_eq!(counts(&calibrator), [4, 1]);
    calibrator.reset();
    run(&mut calibrator, NONE, 0.002, 0..8);
    assert_eq!(counts(&calibrator), [0, 0]);
}
