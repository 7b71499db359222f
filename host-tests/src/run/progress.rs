//! Progress of long work: a bar on standard error if it is a terminal, and no output otherwise.

use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Width of a full bar, characters.
const WIDTH: u64 = 30;

/// Least time between two drawings.
const PERIOD: Duration = Duration::from_millis(100);

/// Clears a line of a terminal.
const CLEAR: &str = "\r\x1b[2K";

/// Progress of some work, shared by all threads that do it.
#[derive(Debug)]
pub struct Bar {
    /// `None` if the bar is never drawn.
    state: Option<Mutex<State>>,
}

#[derive(Debug)]
struct State {
    done: u64,
    /// Number of all items; `None` if unknown.
    length: Option<u64>,
    words: String,
    started: Instant,
    /// Time of the last drawing; `None` if no bar is on the terminal.
    drawn: Option<Instant>,
}

/// A bar over `count` items.
///
/// * `things`: name of the items, which follows the number.
#[must_use]
pub fn over(count: usize, things: &str) -> Bar {
    Bar::new(Some(count as u64), things)
}

/// A count of items whose total is unknown.
#[must_use]
pub fn counting(things: &str) -> Bar {
    Bar::new(None, things)
}

impl Bar {
    fn new(length: Option<u64>, things: &str) -> Self {
        if !io::stderr().is_terminal() {
            return Self::hidden();
        }
        let words = things.to_owned();
        let state = State { done: 0, length, words, started: Instant::now(), drawn: None };
        Self { state: Some(Mutex::new(state)) }
    }

    /// A bar that is never drawn.
    #[must_use]
    pub fn hidden() -> Self {
        Self { state: None }
    }

    /// Advances by `count` items.
    pub fn inc(&self, count: u64) {
        self.update(|state| state.done += count);
    }

    /// Advances by `count` items if the total is unknown.
    pub fn inc_counted(&self, count: u64) {
        self.update(|state| state.done += if state.length.is_none() { count } else { 0 });
    }

    /// Adds `count` items to a known total.
    pub fn inc_length(&self, count: u64) {
        self.update(|state| state.length = state.length.map(|length| length + count));
    }

    /// Sets the words after the number.
    pub fn set_message(&self, words: impl Into<String>) {
        self.update(|state| state.words = words.into());
    }

    /// Clears the bar, calls `print`, draws the bar again, and returns the result of `print`.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        let Some(mut state) = self.lock() else { return print() };
        state.clear();
        let printed = print();
        state.draw();
        printed
    }

    /// Clears the bar.
    pub fn finish_and_clear(&self) {
        if let Some(mut state) = self.lock() {
            state.clear();
        }
    }

    fn lock(&self) -> Option<MutexGuard<'_, State>> {
        Some(self.state.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn update(&self, change: impl FnOnce(&mut State)) {
        let Some(mut state) = self.lock() else { return };
        change(&mut state);
        if state.drawn.is_none_or(|drawn| drawn.elapsed() >= PERIOD) {
            state.draw();
        }
    }
}

impl State {
    fn draw(&mut self) {
        self.drawn = Some(Instant::now());
        // An error of a closed terminal must not end the work.
        let _ = write!(io::stderr(), "{CLEAR}{}", self.line(self.started.elapsed()));
    }

    fn clear(&mut self) {
        if self.drawn.take().is_some() {
            let _ = write!(io::stderr(), "{CLEAR}");
        }
    }

    fn line(&self, elapsed: Duration) -> String {
        let Self { done, length, words, .. } = self;
        let Some(length) = length else {
            return format!("{done} {words}, {} s", elapsed.as_secs());
        };
        let full = usize::try_from(WIDTH * done.min(length) / (*length).max(1)).unwrap_or(0);
        let empty = usize::try_from(WIDTH).unwrap_or(0) - full;
        let left = match done {
            0 => "?".to_owned(),
            // Whole seconds are precise enough.
            done => format!("{} s", elapsed.as_secs() * length.saturating_sub(*done) / done),
        };
        format!("{}{} {done}/{length} {words}, {left} left", "#".repeat(full), "-".repeat(empty))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(done: u64, length: impl Into<Option<u64>>) -> State {
        let length = length.into();
        State { done, length, words: "pairs".into(), started: Instant::now(), drawn: None }
    }

    #[test]
    fn a_line_says_how_much_is_done_and_how_long_the_rest_takes() {
        let after = Duration::from_secs(10);
        let half = format!("{}{} 2/4 pairs, 10 s left", "#".repeat(15), "-".repeat(15));
        assert_eq!(state(2, 4).line(after), half);
        assert!(state(0, 0).line(after).ends_with("0/0 pairs, ? left"));
        assert!(state(9, 4).line(after).ends_with("9/4 pairs, 0 s left"));
        assert_eq!(state(9, None).line(after), "9 pairs, 10 s");
    }

    #[test]
    fn a_hidden_bar_lets_others_print() {
        let bar = Bar::hidden();
        bar.inc(1);
        assert_eq!(bar.suspend(|| 7), 7);
        bar.finish_and_clear();
    }
}
