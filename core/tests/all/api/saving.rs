//! When the policy says to save, and when not.

use core::time::Duration;

use crate::api::disturbed::garbage;
use crate::api::presets::robust;
use crate::api::scene::{correspondences, rig, take};
use stereo_selfcal::store::{PolicyError, SavePolicy, SaveReason};
use stereo_selfcal::{Calibrator, State};

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

/// From 100 s to 1000 s.
fn policy() -> SavePolicy<f32> {
    let policy = SavePolicy::new().with_shortest_interval(seconds(100)).unwrap();
    policy.with_longest_interval(seconds(1000)).unwrap()
}

/// Reason to save at a time, after a pair in every second from another time on; none before.
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
fn a_save_that_failed_is_due_again_after_the_shortest_interval() {
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
fn what_was_saved_unlocked_is_saved_again_with_the_lock() {
    let mut policy = policy();
    let mut calibrator = robust();
    policy.saved(&calibrator, seconds(0));
    feed(&mut calibrator, ROTATION, 0..6);
    assert_eq!(due_after(&mut policy, &calibrator, 1, 100), Some(SaveReason::Locked));
}

#[test]
fn little_news_wait_for_the_longest_interval() {
    let mut policy = policy();
    let mut calibrator = locked();
    feed(&mut calibrator, ROTATION, 20..60);
    policy.saved(&calibrator, seconds(50));
    feed(&mut calibrator, ROTATION, 60..61);
    assert_eq!(due_after(&mut policy, &calibrator, 51, 1050), Some(SaveReason::Overdue));
}

#[test]
fn after_a_restore_the_first_save_waits() {
    let mut policy = policy();
    let mut calibrator = locked();
    policy.restored(&calibrator);
    assert_eq!(policy.due(&calibrator, seconds(1)), None);
    calibrator.apply().unwrap();
    assert_eq!(due_after(&mut policy, &calibrator, 2, 101), Some(SaveReason::InUse));
    assert_eq!(policy.due(&calibrator, seconds(102)), None);
}

#[test]
fn however_often_it_is_asked_and_whatever_changes_it_is_due_once_an_interval() {
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
    // Back, and from there on as ever.
    assert_eq!(due_after(&mut policy, &calibrator, 10, 110), Some(SaveReason::InUse));
    // As far ahead as there is: one pair.
    assert_eq!(policy.due(&calibrator, Duration::MAX), None);
    assert!((0..1000).all(|_| policy.due(&calibrator, Duration::MAX).is_none()));
}

#[test]
fn noise_alone_is_never_saved() {
    let mut policy = policy();
    let mut calibrator = robust::<f32>();
    for seed in 0..20 {
        let _ = take(&mut calibrator, &garbage(250, seed));
        assert_eq!(policy.due(&calibrator, seconds(seed * 10_000)), None);
    }
}

#[test]
fn intervals_that_contradict_each_other_are_refused() {
    let new = SavePolicy::<f32>::new;
    let refused = |policy: Result<SavePolicy<f32>, PolicyError>| policy.map(|_| ()).unwrap_err();
    let too_short = new().with_shortest_interval(Duration::ZERO);
    assert_eq!(refused(too_short), PolicyError::ShortestInterval);
    let too_long = new().with_shortest_interval(seconds(6 * 3600 + 1));
    assert_eq!(refused(too_long), PolicyError::ShortestInterval);
    let below_the_shortest = new().with_longest_interval(seconds(599));
    assert_eq!(refused(below_the_shortest), PolicyError::LongestInterval);
    assert!(new().with_longest_interval(seconds(600)).is_ok());
}
