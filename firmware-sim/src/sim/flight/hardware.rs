//! The hardware around the controller: the matcher at the end of its wire, the flash, the power; and what
//! goes wrong with them.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use anyhow::{Result, anyhow};
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use host_tests::data::Match;
use host_tests::wire::{DataReady, Faults, FaultyWire, Sender, SimMatcher, SimReady, SimSpi};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use simulated_flash::{Fault, Flash, TEARS};
use stereo_selfcal::link::FpgaMatcher;
use stereo_selfcal::store::{Persistence, SavePolicy, Store};

/// Two pages of NOR flash, bytes; it is written in words of 8.
const PAGE: usize = 8192;
const WORD: usize = 8;

/// Words and pages that the flash still takes when power is about to be lost, at most: a save is as long.
const LAST_WORDS: u32 = 400;

/// Between two pairs.
const PERIOD: Duration = Duration::from_millis(50);

/// Pairs that data-ready stays stuck for, at most.
const STUCK_FOR: u32 = 5;

/// Frames that the matcher has room for while nobody reads.
const HELD: usize = 2;

/// How often what goes wrong, shares of all pairs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Profile {
    wire: Faults,
    /// Data-ready stays high or low for a few pairs.
    stuck: f64,
    /// Power is lost: cut, or half of the times while the controller saves what it can.
    power: f64,
}

impl Profile {
    pub(super) const GOOD: Self = Self { wire: Faults::NONE, stuck: 0.0, power: 0.0 };

    pub(super) const BAD: Self = Self {
        wire: Faults { damaged: 0.05, dropped: 0.03, repeated: 0.02, noise_after: 0.02 },
        stuck: 0.01,
        power: 0.02,
    };
}

/// The supply of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Power {
    On,
    /// It goes down, and the controller sees it.
    Failing,
    /// It is cut.
    Lost,
}

/// All of it.
pub(super) struct Hardware {
    profile: Profile,
    matcher: SimMatcher,
    sender: Sender,
    wire: FaultyWire,
    flash: SharedFlash,
    rng: ChaCha8Rng,
    /// Pairs until data-ready works again.
    stuck_for: u32,
}

impl Hardware {
    /// New, its flash erased.
    ///
    /// * `seed`: the same faults for the same seed.
    pub(super) fn new(profile: Profile, sender: Sender, seed: u64) -> Self {
        let flash = Flash::of(vec![0xff; 2 * PAGE], seed);
        Self {
            profile,
            matcher: SimMatcher::new(sender),
            sender,
            wire: FaultyWire::new(profile.wire, seed),
            flash: SharedFlash(Rc::new(RefCell::new(flash))),
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0xfa17),
            stuck_for: 0,
        }
    }

    /// The controller's driver of the matcher, which knows nothing of what it read before.
    pub(super) fn driver(&self) -> FpgaMatcher<SimSpi, SimReady> {
        self.matcher.driver()
    }

    /// The controller's memory.
    ///
    /// # Errors
    /// If there is no store in the flash: never.
    pub(super) fn persistence(&self) -> Result<Persistence<SharedFlash, f32>> {
        let [end, page] = [2 * PAGE, PAGE].map(u32::try_from);
        let store = Store::open(self.flash.clone(), 0..end?, page?);
        let store = store.map_err(|error| anyhow!("flash: {error}"))?;
        // Flights are short: what takes minutes in the field takes a second here.
        let policy = SavePolicy::new().with_shortest_interval(Duration::from_secs(1))?;
        Ok(Persistence::new(store, policy.with_longest_interval(Duration::from_secs(5))?))
    }

    /// Time since take-off.
    pub(super) fn now(sequence: u32) -> Duration {
        PERIOD * sequence
    }

    /// The matcher has found a pair.
    pub(super) fn send(&mut self, sequence: u32, pair: &[Match]) {
        self.stuck_for = self.stuck_for.saturating_sub(1);
        if self.stuck_for == 0 && self.rng.random_bool(self.profile.stuck) {
            self.stuck_for = self.rng.random_range(1..=STUCK_FOR);
            let stuck = if self.rng.random() { DataReady::StuckHigh } else { DataReady::StuckLow };
            self.matcher.set_ready(stuck);
        } else if self.stuck_for == 0 {
            self.matcher.set_ready(DataReady::Works);
        }
        let (frame, _) = self.sender.frame(sequence, pair);
        if self.matcher.waiting() >= HELD * frame.len() {
            return;
        }
        let mut bytes = Vec::new();
        self.wire.send(&frame, &mut bytes);
        self.matcher.put(bytes);
    }

    /// Whether power is about to be lost: the flash then takes some more words.
    pub(super) fn power(&mut self) -> Power {
        if !self.rng.random_bool(self.profile.power) {
            return Power::On;
        }
        let mut flash = self.flash.0.borrow_mut();
        flash.tear = TEARS[self.rng.random_range(0..TEARS.len())];
        flash.power_for = Some(self.rng.random_range(1..=LAST_WORDS));
        if self.rng.random() { Power::Failing } else { Power::Lost }
    }

    /// Power is back.
    pub(super) fn power_on(&mut self) {
        self.flash.0.borrow_mut().power_on();
    }
}

/// The flash, which outlives the controller's driver of it.
#[derive(Debug, Clone)]
pub(super) struct SharedFlash(Rc<RefCell<Flash<WORD, PAGE>>>);

impl ErrorType for SharedFlash {
    type Error = Fault;
}

impl ReadNorFlash for SharedFlash {
    const READ_SIZE: usize = Flash::<WORD, PAGE>::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        self.0.borrow_mut().read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.borrow().capacity()
    }
}

impl NorFlash for SharedFlash {
    const WRITE_SIZE: usize = Flash::<WORD, PAGE>::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::<WORD, PAGE>::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        self.0.borrow_mut().erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        self.0.borrow_mut().write(offset, bytes)
    }
}
