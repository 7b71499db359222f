//! What link, flash and power went through in a flight.

use std::fmt;

use host_tests::wire::counted;
use stereo_selfcal::State;
use stereo_selfcal::link::Counters;
use stereo_selfcal::store::{PersistError, ResumeError, SaveReason, Wear};

/// Counts over all times that power was on.
#[derive(Debug, Default)]
pub(super) struct Service {
    pub(super) starts: u32,
    /// Starts that took up what was learnt.
    pub(super) resumed: u32,
    /// Losses of power during a save.
    pub(super) torn: u32,
    pub(super) saves: u32,
    erasures: u32,
    links: Vec<Counters>,
    /// Pairs since the last start that resumed, until the state is locked.
    since: Option<u32>,
    /// The longest of those.
    slowest: u32,
}

impl Service {
    /// Power is on; whether it had been lost.
    pub(super) fn begin<E: fmt::Debug>(
        &mut self,
        resumed: &Result<bool, ResumeError<E>>,
        state: State,
    ) -> bool {
        self.starts += 1;
        let taken_up = matches!(resumed, Ok(true));
        self.resumed += u32::from(taken_up);
        self.since = (taken_up && state == State::Suspect).then_some(0);
        self.starts > 1
    }

    /// After a pair.
    pub(super) fn note<E: fmt::Debug>(
        &mut self,
        kept: &Result<Option<SaveReason>, PersistError<E>>,
        state: State,
    ) {
        self.saves += u32::from(matches!(kept, Ok(Some(_))));
        self.torn += u32::from(kept.is_err());
        if let Some(pairs) = &mut self.since {
            *pairs += 1;
            self.slowest = self.slowest.max(*pairs);
            if state == State::Locked {
                self.since = None;
            }
        }
    }

    /// Power goes, or the flight is over.
    pub(super) fn end(&mut self, link: &Counters, wear: Wear) {
        self.links.push(*link);
        self.erasures = wear.erasures;
    }

    /// Of all links.
    fn link(&self) -> Counters {
        self.links.iter().fold(Counters::default(), |sum, one| sum.plus(one))
    }
}

impl fmt::Display for Service {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "link               {}", counted(&self.link()))?;
        write!(f, "flash              {} saves, {} erasures", self.saves, self.erasures)?;
        if self.starts > 1 {
            let Self { starts, torn, resumed, slowest, .. } = self;
            let lost = starts - 1;
            write!(f, "\npower              lost {lost} times, {torn} of them during a save; ")?;
            write!(f, "{resumed} times taken up from flash, then locked by pair {slowest}")?;
        }
        Ok(())
    }
}
