//! The application loop: frame by frame from the matcher through the calibrator, a bounded piece of
//! work at a time.

use core::mem;

use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use stereo_selfcal::{
    ApplyError, Calibrator, Extrinsics, Fused, Health, PairError, PairReport, Refusal, State,
};

use crate::matcher::{Matcher, MatcherError};

/// What one [`App::poll`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// Nothing: no frame waits.
    Idle,
    /// A frame was read into the batch.
    Frame {
        /// The matcher's number of the frame.
        sequence: u32,
        /// Correspondences in the frame.
        offered: usize,
        /// Correspondences in the batch: the others have no ray, or the full batch left them out.
        taken: usize,
    },
    /// The solver took one pass over the batch.
    Pass,
    /// The pair is done with, and the batch is empty again.
    Pair(PairOutcome),
    /// The pair has changed how far the estimate can be relied on.
    StateChanged {
        /// Before the pair.
        before: State,
        /// After it.
        after: State,
    },
}

/// What became of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairOutcome {
    /// The solved pair and what became of it, or why it could not be solved.
    pub outcome: Result<(PairReport<f32>, Result<Fused, Refusal>), PairError>,
    /// Row offsets of this pair's matches under what is in use and under the estimate with this pair
    /// in it. `None` before there is an estimate.
    pub health: Option<Health<f32>>,
}

#[derive(Debug, Clone, Copy)]
enum Stage {
    Waiting,
    Received,
    Solving,
    Judged,
}

/// Matcher and calibrator, run by calling [`App::poll`] over and over.
///
/// It estimates and reports; what is in use changes by [`App::apply`] alone, unless the configuration
/// lets the calibrator apply by itself.
///
/// * `N`: correspondences a pair; the batch selects as many of a longer frame.
#[derive(Debug)]
pub struct App<'a, SPI, RDY, const N: usize> {
    matcher: Matcher<SPI, RDY>,
    calibrator: &'a mut Calibrator<f32, N>,
    stage: Stage,
    /// As last reported.
    state: State,
}

impl<'a, SPI: SpiDevice, RDY: InputPin, const N: usize> App<'a, SPI, RDY, N> {
    /// An application that waits for its first frame.
    ///
    /// * `calibrator`: with its cameras set; borrowed, so that the batch can stay in a static.
    pub fn new(matcher: Matcher<SPI, RDY>, calibrator: &'a mut Calibrator<f32, N>) -> Self {
        calibrator.clear_pair();
        let state = calibrator.state();
        Self { matcher, calibrator, stage: Stage::Waiting, state }
    }

    /// Does the next piece of work: reads one frame, or takes one pass, or judges one pair.
    ///
    /// A pair that cannot be solved is an [`Event::Pair`], not an error. Where the pair has changed the
    /// state, the next call tells so before the next frame is read.
    ///
    /// # Errors
    /// [`MatcherError`]: what came of the frame is dropped, the estimate is as it was, and the next
    /// call expects the start of a frame on the bus.
    pub fn poll(&mut self) -> Result<Event, MatcherError<SPI::Error, RDY::Error>> {
        match self.stage {
            Stage::Judged => match self.note_state() {
                Some(change) => Ok(change),
                None => self.receive(),
            },
            Stage::Waiting => self.receive(),
            Stage::Received => Ok(self.begin()),
            Stage::Solving => Ok(self.advance()),
        }
    }

    fn note_state(&mut self) -> Option<Event> {
        self.stage = Stage::Waiting;
        let after = self.calibrator.state();
        let before = mem::replace(&mut self.state, after);
        (before != after).then_some(Event::StateChanged { before, after })
    }

    fn receive(&mut self) -> Result<Event, MatcherError<SPI::Error, RDY::Error>> {
        let polled = self.matcher.poll(|c| {
            // What is not kept shows as the difference of `offered` and `taken`.
            let _ = self.calibrator.push(c);
        });
        let frame = match polled {
            Ok(Some(frame)) => frame,
            Ok(None) => return Ok(Event::Idle),
            Err(error) => {
                self.calibrator.clear_pair();
                return Err(error);
            }
        };
        self.stage = Stage::Received;
        Ok(Event::Frame {
            sequence: frame.sequence,
            offered: frame.count.into(),
            taken: self.calibrator.batch().pairs().len(),
        })
    }

    fn begin(&mut self) -> Event {
        match self.calibrator.begin_pair() {
            Ok(()) => {
                self.stage = Stage::Solving;
                Event::Pass
            }
            Err(error) => self.finish(Err(error)),
        }
    }

    fn advance(&mut self) -> Event {
        match self.calibrator.advance_pair() {
            Ok(None) => Event::Pass,
            Ok(Some(report)) => {
                let fused = self.calibrator.fuse(&report);
                self.finish(Ok((report, fused)))
            }
            Err(error) => self.finish(Err(error)),
        }
    }

    fn finish(
        &mut self,
        outcome: Result<(PairReport<f32>, Result<Fused, Refusal>), PairError>,
    ) -> Event {
        // Before the matches it is about are gone.
        let health = self.calibrator.health();
        self.calibrator.clear_pair();
        self.stage = Stage::Judged;
        Event::Pair(PairOutcome { outcome, health })
    }

    /// The calibrator: its estimate, and what is in use.
    pub fn calibrator(&self) -> &Calibrator<f32, N> {
        self.calibrator
    }

    /// Puts the estimate into use and returns it: `p_r = R p_l + t`.
    ///
    /// # Errors
    /// [`ApplyError`]; what is in use stays.
    pub fn apply(&mut self) -> Result<Extrinsics<f32>, ApplyError> {
        self.calibrator.apply()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bus::{AlwaysReady, BusFault, TestBus, frame, record};
    use embedded_hal_mock::eh1::digital::{
        Mock as PinMock, State::High, State::Low, Transaction as PinTransaction,
    };
    use std::vec::Vec;
    use stereo_selfcal::{Camera, Cameras, Config, Intrinsics, Lens};

    const CAPACITY: usize = 64;

    /// What a first pair is to the paper preset, which confirms nothing.
    const LOCKED: Event = Event::StateChanged { before: State::Acquiring, after: State::Locked };

    fn calibrator() -> Calibrator<f32, CAPACITY> {
        with(Config::paper())
    }

    fn with(config: Config) -> Calibrator<f32, CAPACITY> {
        let intrinsics =
            Intrinsics { focal: [1400.0; 2], principal: [960.0, 600.0], size: [1920, 1200] };
        let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        let mut calibrator = Calibrator::new(config);
        calibrator.set_cameras(Cameras { left: camera, right: camera });
        calibrator
    }

    fn app(
        calibrator: &mut Calibrator<f32, CAPACITY>,
        bytes: Vec<u8>,
        reads: usize,
    ) -> App<'_, TestBus, AlwaysReady, CAPACITY> {
        App::new(Matcher::new(TestBus::new(bytes, reads), AlwaysReady), calibrator)
    }

    /// Polls up to the end of the pair.
    fn finish_pair(app: &mut App<'_, TestBus, AlwaysReady, CAPACITY>) -> (usize, PairOutcome) {
        for passes in 0..200 {
            match app.poll().unwrap() {
                Event::Pass => (),
                Event::Pair(pair) => return (passes, pair),
                other => panic!("{other:?} while a pair is being solved"),
            }
        }
        panic!("the pair has no end");
    }

    #[test]
    fn a_frame_is_read_then_solved_a_pass_a_poll_then_fused_and_not_applied() {
        let mut calibrator = calibrator();
        let mut app = app(&mut calibrator, frame(5, (0..60).map(record)), usize::MAX);
        assert_eq!(app.poll(), Ok(Event::Frame { sequence: 5, offered: 60, taken: 60 }));
        let (passes, pair) = finish_pair(&mut app);
        let (report, fused) = pair.outcome.unwrap();
        assert_eq!((passes, fused), (report.passes.into(), Ok(Fused::Added)));
        let health = pair.health.unwrap();
        assert!(health.proposed_px < health.in_use_px && health.in_use_px > 1.0, "{health:?}");
        assert!(app.calibrator().batch().pairs().is_empty());
        assert_eq!(app.calibrator().generation(), 0);
        let estimate = app.calibrator().proposal().unwrap().extrinsics;
        assert_eq!(app.apply(), Ok(estimate));
        assert_eq!((app.calibrator().generation(), app.calibrator().in_use()), (1, &estimate));
    }

    #[test]
    fn the_batch_selects_of_a_frame_beyond_capacity_and_the_next_one_starts_afresh() {
        let mut direct = calibrator();
        let mut calibrator = direct.clone();
        let frames = [frame(1, (0..128).map(record)), frame(2, (0..50).map(record))];
        let mut app = app(&mut calibrator, frames.concat(), usize::MAX);
        assert_eq!(app.poll(), Ok(Event::Frame { sequence: 1, offered: 128, taken: CAPACITY }));
        for i in 0..128 {
            direct.push(&record(i).decode()).unwrap();
        }
        let batch = app.calibrator().batch();
        assert_eq!(batch.pairs(), direct.batch().pairs());
        assert_eq!([batch.offered(), batch.left_out()], [128, 64]);
        finish_pair(&mut app);
        assert_eq!(app.poll(), Ok(LOCKED));
        assert_eq!(app.poll(), Ok(Event::Frame { sequence: 2, offered: 50, taken: 50 }));
    }

    #[test]
    fn a_pair_without_a_solution_is_an_event_and_the_next_one_is_fused() {
        let mut calibrator = calibrator();
        let frames = [frame(1, (0..5).map(record)), frame(2, (0..60).map(record))];
        let mut app = app(&mut calibrator, frames.concat(), usize::MAX);
        app.poll().unwrap();
        let (_, pair) = finish_pair(&mut app);
        assert_eq!(pair.outcome, Err(PairError::TooFew { usable: 5, needed: 12 }));
        assert_eq!((pair.health, app.apply()), (None, Err(ApplyError::NoProposal)));
        app.poll().unwrap();
        assert!(matches!(finish_pair(&mut app).1.outcome, Ok((_, Ok(Fused::Added)))));
    }

    #[test]
    fn a_change_of_state_is_told_once_right_after_the_pair_that_made_it() {
        let mut calibrator = with(Config::robust());
        // Points that are new in each pair, and a last pair of too few.
        let pair =
            |sequence: u16| frame(sequence.into(), (0..60).map(|i| record(sequence * 60 + i)));
        let frames: Vec<u8> = (0..6).flat_map(pair).chain(frame(6, (0..5).map(record))).collect();
        let mut app = app(&mut calibrator, frames, 6 * 5 + 2);
        let (mut pairs, mut changes) = (0, Vec::new());
        while let Ok(event) = app.poll() {
            match event {
                Event::Pair(_) => pairs += 1,
                Event::StateChanged { before, after } => changes.push((pairs, before, after)),
                _ => (),
            }
        }
        assert_eq!(pairs, 7);
        assert_eq!(changes, [(4, State::Acquiring, State::Locked)]);
    }

    #[test]
    fn half_a_frame_is_dropped_with_the_error_of_the_bus() {
        let mut calibrator = calibrator();
        // Two of the five reads of a frame succeed.
        let mut app = app(&mut calibrator, frame(1, (0..60).map(record)), 2);
        assert_eq!(app.poll(), Err(MatcherError::Bus(BusFault)));
        assert!(app.calibrator().batch().pairs().is_empty());
        assert_eq!(app.poll(), Err(MatcherError::Bus(BusFault)), "waiting for the next frame");
    }

    #[test]
    fn without_a_frame_nothing_happens() {
        let mut calibrator = calibrator();
        let mut ready = PinMock::new(&[PinTransaction::get(Low), PinTransaction::get(High)]);
        let bus = TestBus::new(frame(9, (0..1).map(record)), 2);
        let mut app = App::new(Matcher::new(bus, ready.clone()), &mut calibrator);
        assert_eq!(app.poll(), Ok(Event::Idle));
        assert_eq!(app.poll(), Ok(Event::Frame { sequence: 9, offered: 1, taken: 1 }));
        ready.done();
    }
}
