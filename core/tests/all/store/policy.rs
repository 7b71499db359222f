//! Wear under clocks that are wrong and controllers that are reset.

use core::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::store::{Persistence, SavePolicy, SaveReason};
use stereo_selfcal::{Calibrator, Config, State};
use test_support::flash::Flash;

use crate::api::scene::{cameras, correspondences, rig, take};
use crate::store::rig::open;

type Nor = Flash<8, 8192>;
type Controller = Calibrator<f32, 256>;

/// Shortest interval of the default policy, s: also the least number of pairs between two saves.
const INTERVAL: u64 = 600;

fn new() -> Box<Controller> {
    let mut calibrator = Box::new(Controller::new(Config::robust()));
    calibrator.set_cameras(cameras());
    calibrator
}

fn feed(calibrator: &mut Controller, pairs: core::ops::Range<u64>) {
    let truth = rig([1.0, -0.5, 0.8], [0.5, -0.4]);
    for pair in pairs {
        let _ = take(calibrator, &correspondences(&truth, 250, 0.5, pair));
    }
}

/// A locked calibrator with news for every save, and whether its estimate is applied.
struct Restless(Box<Controller>, bool);

impl Restless {
    fn new() -> Self {
        let mut calibrator = new();
        feed(&mut calibrator, 0..6);
        assert_eq!(calibrator.state(), State::Locked);
        Self(calibrator, false)
    }

    fn change(&mut self) {
        let changed = if self.1 { self.0.undo() } else { self.0.apply() };
        changed.unwrap();
        self.1 = !self.1;
    }
}

/// Numbers of the pairs that were saved, of `pairs` at 20 Hz with this clock.
fn saved(pairs: u64, mut clock: impl FnMut(u64) -> Duration) -> Vec<u64> {
    let mut policy = SavePolicy::<f32>::new();
    let mut calibrator = Restless::new();
    let mut saved = Vec::new();
    for pair in 0..pairs {
        let now = clock(pair);
        if policy.due(&calibrator.0, now).is_some() {
            policy.saved(&calibrator.0, now);
            saved.push(pair);
            calibrator.change();
        }
    }
    saved
}

fn at_20_hz(pair: u64) -> Duration {
    Duration::from_millis(50 * pair)
}

#[test]
fn a_right_clock_permits_a_save_in_an_interval() {
    let pairs = saved(20 * INTERVAL * 5 + 1, at_20_hz);
    assert_eq!(pairs, (0..=5).map(|n| n * 20 * INTERVAL).collect::<Vec<_>>());
}

#[test]
fn a_clock_that_alternates_between_two_origins_permits_one_save() {
    for apart in [100, 1_000, 10_000, 600_000, 3_600_000, 1_000_000_000] {
        let clock = |pair| at_20_hz(pair) + Duration::from_millis(apart) * (pair as u32 % 2);
        let pairs = saved(100_000, clock);
        // 100,000 pairs take 5000 s.
        assert!(pairs.len() <= 1 + 5_000 / INTERVAL as usize, "{apart} ms: {pairs:?}");
    }
}

#[test]
fn no_clock_permits_two_saves_in_fewer_pairs_than_the_interval_has_seconds() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut clocks: [Box<dyn FnMut(u64) -> Duration>; 6] = [
        Box::new(|_| Duration::from_secs(5)),
        Box::new(|pair| Duration::from_secs(pair * 3600)),
        Box::new(|pair| Duration::from_secs(pair % 100 * 1_000_000)),
        Box::new(|pair| if pair % 3 == 2 { Duration::ZERO } else { Duration::from_secs(pair) }),
        Box::new(|pair| if pair % 2 == 0 { Duration::MAX } else { Duration::ZERO }),
        Box::new(move |_| Duration::new(random.random(), 0)),
    ];
    for (number, clock) in clocks.iter_mut().enumerate() {
        let pairs = saved(20_000, clock);
        assert!(pairs.is_sorted_by(|a, b| b - a >= INTERVAL), "clock {number}: {pairs:?}");
        println!("clock {number}: {} saves in 20,000 pairs", pairs.len());
    }
}

#[test]
fn a_clock_that_is_set_back_delays_the_next_save_by_a_pair() {
    // Wraps every 71.6 minutes, as a 32-bit counter of microseconds.
    let clock = |pair| Duration::from_micros(u64::from((50_000 * pair) as u32));
    let pairs = saved(20 * INTERVAL * 30, clock);
    assert!(pairs.len() >= 29, "{pairs:?}");
}

/// Boots, takes `pairs` pairs at 20 Hz, and is reset; the flash, and the number of saves.
fn boot(flash: Nor, seed: u64, pairs: u64, restore: bool) -> (Nor, usize) {
    let mut buffer = vec![0; Controller::SNAPSHOT_BYTES];
    let mut persistence = Persistence::new(open(flash, 1), SavePolicy::new());
    let mut calibrator = new();
    if restore {
        let _ = persistence.resume(&mut calibrator, &mut buffer).unwrap();
    }
    let mut saves = 0;
    for pair in 0..pairs {
        // Each start learns something else, and applies it.
        let truth = rig([1.0 + 0.4 * seed as f64, -0.5, 0.8], [0.5, -0.4]);
        let _ = take(&mut calibrator, &correspondences(&truth, 250, 0.5, 100 * seed + pair));
        let _ = calibrator.apply();
        saves += usize::from(
            persistence.save_if_due(&calibrator, at_20_hz(pair), &mut buffer).unwrap().is_some(),
        );
    }
    (persistence.release().close(), saves)
}

#[test]
fn a_controller_that_is_reset_again_and_again_saves_once() {
    for restore in [true, false] {
        let mut flash = Nor::new(3, 1);
        let mut saves = Vec::new();
        for start in 0..20 {
            let saved;
            (flash, saved) = boot(flash, start, 16, restore);
            saves.push(saved);
        }
        assert_eq!((saves[0], saves.iter().sum::<usize>()), (1, 1), "{saves:?}");
    }
}

#[test]
fn what_was_restored_and_only_confirmed_waits_for_the_longest_interval() {
    let mut buffer = vec![0; Controller::SNAPSHOT_BYTES];
    let mut first = new();
    feed(&mut first, 0..60);
    let record = first.snapshot(&mut buffer).unwrap();
    let mut calibrator = new();
    calibrator.restore(record).unwrap();
    let mut policy = SavePolicy::<f32>::new();
    policy.restored(&calibrator);
    assert_eq!(calibrator.state(), State::Suspect);
    feed(&mut calibrator, 60..63);
    assert_eq!(calibrator.state(), State::Locked);
    let due = (0..8 * 3600)
        .find_map(|s| policy.due(&calibrator, Duration::from_secs(s)).map(|reason| (s, reason)));
    assert_eq!(due, Some((6 * 3600, SaveReason::Overdue)));
}
