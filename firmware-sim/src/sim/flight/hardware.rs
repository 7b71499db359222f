//! The simulated hardware around the controller: matcher, wire, flash and power supply, with their faults.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use anyhow::{Result, anyhow};
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rigs::data::Match;
use sim::wire::{Faults, FaultyWire, Sender};
use stereo_selfcal::link::FpgaMatcher;
use stereo_selfcal::store::{SavePolicy, Store};
use test_support::flash::{Fault, Flash, TEARS};
use test_support::wire::{DataReady, Wire};

use super::super::polling::driver;

/// Page size and word size of the NOR flash, bytes. It has two pages for the factory calibration and two for the state.
const PAGE: usize = 8192;
const WORD: usize = 8;

/// Largest number of writes of words and erasures before the power is lost: about as many as a save takes.
const LAST_WORDS: u32 = 60;

/// Time between two pairs.
const PERIOD: Duration = Duration::from_millis(50);

/// Longest time that data-ready is stuck, pairs.
const STUCK_FOR: u32 = 5;

/// Frames that the matcher buffers while nobody reads.
const BUFFERED_FRAMES: usize = 2;

/// Rates of the faults, shares of all pairs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Profile {
    wire: Faults,
    /// Data-ready is stuck high or low for a few pairs.
    stuck: f64,
    /// Power is lost. In half of the cases the controller detects it and saves.
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

/// State of the controller's power supply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Power {
    On,
    /// The supply fails, and the controller detects it.
    Failing,
    /// The supply is cut without warning.
    Lost,
}

/// All simulated hardware.
pub(super) struct Hardware {
    profile: Profile,
    sender: Sender,
    faults: FaultyWire,
    wire: Wire,
    flash: SharedFlash,
    rng: ChaCha8Rng,
    /// Number of pairs until data-ready works again.
    stuck_for: u32,
}

impl Hardware {
    /// Hardware with an erased flash.
    ///
    /// * `seed`: seed of the faults.
    pub(super) fn new(profile: Profile, sender: Sender, seed: u64) -> Self {
        let flash = Flash::of(vec![0xff; 4 * PAGE], seed);
        Self {
            profile,
            sender,
            faults: FaultyWire::new(profile.wire, seed),
            wire: Wire::default(),
            flash: SharedFlash(Rc::new(RefCell::new(flash))),
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0xfa17),
            stuck_for: 0,
        }
    }

    /// A new driver of the matcher, without the state of an earlier one.
    pub(super) fn driver(&self) -> FpgaMatcher<Wire, Wire> {
        driver(&self.wire)
    }

    /// The controller's store, in the simulated flash.
    ///
    /// # Errors
    /// If the store cannot be opened, which its dimensions exclude.
    pub(super) fn store(&self) -> Result<Store<SharedFlash, f32>> {
        let [middle, end] = [2 * PAGE, 4 * PAGE].map(u32::try_from);
        let (middle, end) = (middle?, end?);
        // A shorter interval than in the field, since flights are short.
        let policy = SavePolicy::new(Duration::from_secs(1));
        let store = Store::open(self.flash.clone(), 0..middle, middle..end, policy);
        store.map_err(|error| anyhow!("flash: {error}"))
    }

    /// Erasures of the flash.
    pub(super) fn erasures(&self) -> u32 {
        self.flash.0.borrow().erased.iter().sum()
    }

    /// Time since take-off.
    pub(super) fn now(sequence: u32) -> Duration {
        PERIOD * sequence
    }

    /// Sends the frame of a pair, with the faults of wire and data-ready. The frame is lost if the buffer of the
    /// matcher is full.
    ///
    /// * `pair`: matches, each with its track, or 0.
    pub(super) fn send(&mut self, sequence: u32, pair: &[(Match, u16)]) {
        self.stuck_for = self.stuck_for.saturating_sub(1);
        if self.stuck_for == 0 && self.rng.random_bool(self.profile.stuck) {
            self.stuck_for = self.rng.random_range(1..=STUCK_FOR);
            let stuck = if self.rng.random() { DataReady::StuckHigh } else { DataReady::StuckLow };
            self.wire.set_ready(stuck);
        } else if self.stuck_for == 0 {
            self.wire.set_ready(DataReady::Works);
        }
        let (frame, _) = self.sender.tracked_frame(sequence, pair);
        if self.wire.waiting() >= BUFFERED_FRAMES * frame.len() {
            return;
        }
        let mut bytes = Vec::new();
        self.faults.send(&frame, &mut bytes);
        self.wire.send(bytes);
    }

    /// Draws whether the power is lost. If so, the flash accepts only a limited number of further writes and erasures.
    pub(super) fn power(&mut self) -> Power {
        if !self.rng.random_bool(self.profile.power) {
            return Power::On;
        }
        let mut flash = self.flash.0.borrow_mut();
        flash.tear = TEARS[self.rng.random_range(0..TEARS.len())];
        flash.power_for = Some(self.rng.random_range(1..=LAST_WORDS));
        if self.rng.random() { Power::Failing } else { Power::Lost }
    }

    /// Restores the power.
    pub(super) fn power_on(&mut self) {
        self.flash.0.borrow_mut().power_on();
    }
}

/// The flash, shared between successive starts of the controller.
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
