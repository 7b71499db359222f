//! When the policy asks for a save, and when it does not.

use core::time::Duration;

use crate::api::disturbed::garbage;
use crate::api::presets::robust;
use crate::api::scene::{correspondences, correspondences_within, rig, take};
use crate::store::Kept;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::store::{SavePolicy, SaveReason};
use stereo_selfcal::{Calibrator, State};
use test_support::flash::Flash;

const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
const KNOCKED: [f64; 3] = [1.5, -0.5, 0.8];

type Rig = Calibrator<f32, 256>;

fn feed(calibrator: &mut Rig, rotation: [f64; 3], seeds: core::ops::Range<u64>) {
    let truth = rig(rotation, [0.5, -0.4]);
    for seed in seeds {
        let _ = take(calibrator, &correspondences(&truth, 250, 0.5, seed));
    }
}

fn locked() -> Rig {
    let mut calibrator = robust();
    feed(&mut calibrator, ROTATION, 0..6);
    assert_eq!(calibrator.state(), State::Locked);
    calibrator
}

fn seconds(s: u64) -> Duration {
    Duration::from_secs(s)
}

/// A policy of at most one save in 100 s.
fn policy() -> SavePolicy<f32> {
    SavePolicy::new(seconds(100))
}

/// Reason to save at second `to`, with a pair in every second from `from` on. Checks that no save is due before `to`.
fn due_after(
    policy: &mut SavePolicy<f32>,
    calibrator: &Rig,
    from: u64,
    to: u64,
) -> Option<SaveReason> {
    assert!((from..to).all(|s| policy.due(calibrator, seconds(s)).is_none()));
    policy.due(calibrator, seconds(to))
}

#[test]
fn the_first_lock_is_saved_at_once_and_nothing_before() {
    let mut policy = policy();
    let mut calibrator = robust();
    assert_eq!(policy.due(&calibrator, seconds(5000)), None);
    feed(&mut calibrator, ROTATION, 0..1);
    assert_eq!(policy.due(&calibrator, seconds(6000)), None);
    assert_eq!(policy.due(&locked(), seconds(6001)), Some(SaveReason::Locked));
}

#[test]
fn a_save_that_failed_is_due_again_after_the_interval() {
    let mut policy = policy();
    let calibrator = locked();
    assert_eq!(policy.due(&calibrator, seconds(7)), Some(SaveReason::Locked));
    assert_eq!(due_after(&mut policy, &calibrator, 8, 107), Some(SaveReason::Locked));
    policy.saved(&calibrator, seconds(108));
    assert_eq!(due_after(&mut policy, &calibrator, 109, 9000), None, "nothing is new");
}

#[test]
fn other_extrinsics_in_use_are_saved() {
    let mut policy = policy();
    let mut calibrator = locked();
    policy.saved(&calibrator, seconds(0));
    calibrator.apply().unwrap();
    assert_eq!(due_after(&mut policy, &calibrator, 1, 100), Some(SaveReason::InUse));
    policy.saved(&calibrator, seconds(100));
    calibrator.reset();
    assert_eq!(due_after(&mut policy, &calibrator, 101, 200), Some(SaveReason::InUse));
}

#[test]
fn an_estimate_that_moved_is_saved_once_it_is_locked_again() {
    let mut policy = policy();
    let mut calibrator = locked();
    policy.saved(&calibrator, seconds(0));
    feed(&mut calibrator, KNOCKED, 10..11);
    assert_eq!(calibrator.state(), State::Suspect);
    assert_eq!(due_after(&mut policy, &calibrator, 1, 5000), None);
    feed(&mut calibrator, KNOCKED, 11..16);
    assert_eq!(calibrator.state(), State::Locked);
    assert_eq!(policy.due(&calibrator, seconds(5000)), Some(SaveReason::Moved));
    policy.saved(&calibrator, seconds(5000));
    assert_eq!(due_after(&mut policy, &calibrator, 5001, 9000), None);
}

#[test]
fn a_far_scene_that_moves_the_baseline_by_chance_is_not_saved_again() {
    let truth = rig(ROTATION, [0.5, -0.4]);
    let mut calibrator = robust::<f32>();
    let mut far = |seeds: core::ops::Range<u64>| {
        for seed in seeds {
            take(&mut calibrator, &correspondences_within(&truth, [300.0, 3000.0], 250, 0.5, seed))
                .unwrap();
        }
        calibrator.clone()
    };
    let mut policy = policy();
    policy.saved(&far(0..8), seconds(0));
    let before = far(8..8).proposal().unwrap().extrinsics;
    let after = far(8..20);
    let moved = Deviation::between(&after.proposal().unwrap().extrinsics, &before).translation;
    assert!(moved > 2e-3, "{moved}");
    assert_eq!(due_after(&mut policy, &after, 1, 300), None);
}

#[test]
fn a_state_saved_unlocked_is_saved_again_once_locked() {
    let mut policy = policy();
    let mut calibrator = robust();
    policy.saved(&calibrator, seconds(0));
    feed(&mut calibrator, ROTATION, 0..6);
    assert_eq!(due_after(&mut policy, &calibrator, 1, 100), Some(SaveReason::Locked));
}

#[test]
fn small_changes_wait_for_thirty_six_intervals() {
    let mut policy = policy();
    let mut calibrator = locked();
    feed(&mut calibrator, ROTATION, 20..60);
    policy.saved(&calibrator, seconds(50));
    feed(&mut calibrator, ROTATION, 60..61);
    assert_eq!(due_after(&mut policy, &calibrator, 51, 3650), Some(SaveReason::Overdue));
}

#[test]
fn after_a_restart_the_first_save_waits_and_a_confirmation_triggers_none() {
    let mut policy = policy();
    let mut calibrator = locked();
    feed(&mut calibrator, ROTATION, 20..60);
    calibrator.restore(&calibrator.snapshot()).unwrap();
    policy.restarted(&calibrator);
    feed(&mut calibrator, ROTATION, 60..63);
    assert_eq!(calibrator.state(), State::Locked);
    assert_eq!(due_after(&mut policy, &calibrator, 1, 3000), None);
    calibrator.apply().unwrap();
    assert_eq!(due_after(&mut policy, &calibrator, 3001, 3001), Some(SaveReason::InUse));
    assert_eq!(policy.due(&calibrator, seconds(3002)), None);
}

#[test]
fn no_clock_permits_two_saves_in_fewer_pairs_than_the_interval_has_seconds() {
    let clocks: [fn(u64) -> Duration; 5] = [
        |pair| seconds(pair * 3600),
        |pair| seconds(pair % 100 * 1_000_000),
        |pair| if pair % 3 == 2 { Duration::ZERO } else { seconds(pair) },
        |pair| if pair % 2 == 0 { Duration::MAX } else { Duration::ZERO },
        // The clock wraps, as a 32-bit counter of microseconds does.
        |pair| Duration::from_micros(u64::from((50_000_000 * pair) as u32)),
    ];
    for (number, clock) in clocks.into_iter().enumerate() {
        let (mut policy, mut calibrator, mut due) = (policy(), locked(), Vec::new());
        for pair in 0..2000 {
            if policy.due(&calibrator, clock(pair)).is_some() {
                policy.saved(&calibrator, clock(pair));
                due.push(pair);
                let _ = calibrator.apply().and(if due.len() % 2 == 0 {
                    calibrator.undo()
                } else {
                    calibrator.apply()
                });
            }
        }
        assert!(due.is_sorted_by(|a, b| b - a >= 100), "clock {number}: {due:?}");
    }
}

#[test]
fn a_controller_that_is_reset_again_and_again_saves_once() {
    let mut flash = Flash::<8, 1024>::of(vec![0xff; 4096], 1);
    let mut saves = Vec::new();
    for start in 0..8 {
        let mut store = Kept::open(flash).0;
        let mut calibrator = robust();
        let _ = store.resume(&mut calibrator);
        for pair in 0..8 {
            // After each start the rig is another one, which is learnt and applied.
            feed(&mut calibrator, [1.0 + 0.4 * f64::from(start), -0.5, 0.8], pair..pair + 1);
            let _ = calibrator.apply();
            saves.extend(store.save_if_due(&calibrator, seconds(pair)).unwrap());
        }
        flash = store.close();
    }
    assert_eq!(saves, [SaveReason::Locked]);
}

#[test]
fn a_save_is_due_once_an_interval_for_any_calls_and_changes() {
    let mut policy = policy();
    let mut calibrator = locked();
    let mut due = Vec::new();
    for second in 0..1000 {
        let changed = if second % 2 == 0 { calibrator.apply() } else { calibrator.undo() };
        changed.unwrap();
        if policy.due(&calibrator, seconds(second)).is_some() {
            due.push(second);
            if second % 3 == 0 {
                policy.saved(&calibrator, seconds(second));
            }
        }
    }
    assert!(due.len() > 5 && due.is_sorted_by(|a, b| b - a >= 100), "{due:?}");
}

#[test]
fn a_clock_that_stands_still_or_goes_back_permits_no_more_saves() {
    let mut policy = policy();
    let mut calibrator = locked();
    assert_eq!(policy.due(&calibrator, seconds(5000)), Some(SaveReason::Locked));
    assert!((0..1000).all(|_| policy.due(&calibrator, seconds(5000)).is_none()));
    policy.saved(&calibrator, seconds(5000));
    calibrator.apply().unwrap();
    // The clock steps back, and then runs normally.
    assert_eq!(due_after(&mut policy, &calibrator, 10, 110), Some(SaveReason::InUse));
    // Even the largest step ahead counts as 1 s.
    assert_eq!(policy.due(&calibrator, Duration::MAX), None);
    assert!((0..1000).all(|_| policy.due(&calibrator, Duration::MAX).is_none()));
}

#[test]
fn outliers_alone_are_never_saved() {
    let mut policy = policy();
    let mut calibrator = robust::<f32>();
    for seed in 0..20 {
        let _ = take(&mut calibrator, &garbage(250, seed));
        assert_eq!(policy.due(&calibrator, seconds(seed * 10_000)), None);
    }
}
