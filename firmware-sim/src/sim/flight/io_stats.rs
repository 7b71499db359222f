//! Counts of the link, the flash and the power supply in a flight.

use std::fmt;

use sim::wire::counted;
use stereo_selfcal::link::Counters;
use stereo_selfcal::store::{SaveReason, StoreError};
use stereo_selfcal::{RestoreError, State};

/// Counts over all starts of the controller.
#[derive(Debug, Default)]
pub(super) struct IoStats {
    pub(super) starts: u32,
    /// Starts that restored an estimate.
    pub(super) resumed: u32,
    /// Saves cut by a loss of power.
    pub(super) torn: u32,
    pub(super) saves: u32,
    erasures: u32,
    links: Vec<Counters>,
    /// Number of pairs since the last start that restored an estimate, until locked.
    until_locked: Option<u32>,
    /// Largest number of pairs from such a start until locked.
    slowest: u32,
}

impl IoStats {
    /// Counts a start. Returns whether it follows a loss of power.
    pub(super) fn start(&mut self, resumed: Result<bool, RestoreError>, state: State) -> bool {
        self.starts += 1;
        let restored = matches!(resumed, Ok(true));
        self.resumed += u32::from(restored);
        self.until_locked = (restored && state == State::Suspect).then_some(0);
        self.starts > 1
    }

    /// Counts the save after a pair, and the pairs since a restored start until locked.
    pub(super) fn note<E: fmt::Debug>(
        &mut self,
        kept: &Result<Option<SaveReason>, StoreError<E>>,
        state: State,
    ) {
        self.saves += u32::from(matches!(kept, Ok(Some(_))));
        self.torn += u32::from(kept.is_err());
        if let Some(pairs) = &mut self.until_locked {
            *pairs += 1;
            self.slowest = self.slowest.max(*pairs);
            if state == State::Locked {
                self.until_locked = None;
            }
        }
    }

    /// Adds the counts of link and flash at a loss of power, or at the end.
    pub(super) fn end(&mut self, link: &Counters, erasures: u32) {
        self.links.push(*link);
        self.erasures = erasures;
    }

    /// Sum of the counts of all starts.
    fn link(&self) -> Counters {
        self.links.iter().fold(Counters::default(), |sum, one| sum.plus(one))
    }
}

impl fmt::Display for IoStats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "link               {}", counted(&self.link()))?;
        write!(f, "flash              {} saves, {} erasures", self.saves, self.erasures)?;
        if self.starts > 1 {
            let Self { starts, torn, resumed, slowest, .. } = self;
            let lost = starts - 1;
            write!(f, "\npower              lost {lost} times, {torn} of them during a save; ")?;
            write!(f, "{resumed} times restored from flash, then locked by pair {slowest}")?;
        }
        Ok(())
    }
}
