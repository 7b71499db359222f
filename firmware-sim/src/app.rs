//! The application loop: passes the matcher's frames to the calibrator. Each call does a bounded amount of
//! work.

use core::mem;

use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use stereo_selfcal::depth::{MotionError, RangeError, RangeReading, Tracks, Witnessed};
use stereo_selfcal::link::{Counters, FpgaMatcher, ReadStatus, ReceiveError, Received, Tracking};
use stereo_selfcal::{
    ApplyError, Calibration, Calibrator, Fused, Outcome, PairReport, Rejection, State, Verdict,
};

/// Result of one [`App::poll`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
#[allow(clippy::large_enum_variant, reason = "there is no heap to box it on")]
pub enum Event {
    /// No frame waits.
    Idle,
    /// A part of a frame was read, or bytes outside of a frame.
    Reading,
    /// A whole frame is in the batch.
    Frame {
        /// Sequence number of the frame.
        sequence: u32,
        /// Number of correspondences in the frame.
        offered: usize,
        /// Number of correspondences in the batch. The batch refused the others, or did not select them.
        taken: usize,
    },
    /// The solver took one pass over the batch, or over the tracks.
    Pass,
    /// The pair has ended.
    Pair(PairOutcome),
    /// The pair has changed the state of the estimate.
    StateChanged {
        /// State before the pair.
        before: State,
        /// State after the pair.
        after: State,
    },
}

/// Effect of the tracks of a pair.
type Motion = Result<Witnessed, MotionError>;

/// Result of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairOutcome {
    /// The solved pair and the result of its fusion, or why it could not be solved.
    pub outcome: Result<(PairReport<f32>, Result<Fused, Rejection>), Rejection>,
    /// Verdict on the calibration in use, before the estimate was applied.
    pub verdict: Verdict<f32>,
    /// Effect of the tracks that this pair shares with an earlier one; `None` if it shares none.
    pub motion: Option<Motion>,
}

#[derive(Debug, Clone, Copy)]
enum Stage {
    Waiting,
    Received,
    Solving,
    /// The pair has ended. Its tracks, if it has any, are being measured.
    Solved(Outcome<f32>),
    Finished,
}

/// Matcher and calibrator. The firmware calls [`App::poll`] in its main loop.
///
/// The application estimates and reports. Only [`App::apply`] changes the extrinsics in use, unless
/// [`App::applying`] lets it apply each locked estimate.
///
/// * `N`: capacity of the batch, which selects `N` correspondences of a longer frame.
#[derive(Debug)]
pub struct App<'a, SPI, RDY, const N: usize> {
    matcher: FpgaMatcher<SPI, RDY>,
    calibrator: &'a mut Calibrator<f32, N>,
    tracks: Option<&'a mut Tracks<f32, N>>,
    stage: Stage,
    applies: bool,
    /// The last reported state.
    state: State,
}

impl<'a, SPI: SpiDevice, RDY: InputPin, const N: usize> App<'a, SPI, RDY, N> {
    /// An application that waits for its first frame.
    ///
    /// * `calibrator`: borrowed, so that it can be a static. Its batch is emptied.
    pub fn new(matcher: FpgaMatcher<SPI, RDY>, calibrator: &'a mut Calibrator<f32, N>) -> Self {
        calibrator.discard_pair();
        let state = calibrator.state();
        Self { matcher, calibrator, tracks: None, stage: Stage::Waiting, applies: false, state }
    }

    /// Joins matches of two frames that have the same track, and passes them to [`Calibrator::advance_tracks`] after each
    /// pair. They measure the yaw while the rig moves.
    #[must_use]
    pub fn tracking(self, tracks: &'a mut Tracks<f32, N>) -> Self {
        Self { tracks: Some(tracks), ..self }
    }

    /// Applies the estimate after each pair if it is locked.
    #[must_use]
    pub fn applying(self) -> Self {
        Self { applies: true, ..self }
    }

    /// Does the next step: one read from the bus, one pass, or the evaluation and fusion of a pair.
    ///
    /// A pair that cannot be solved is an [`Event::Pair`], and a damaged frame is counted
    /// ([`App::counters`]): neither is an error. If the pair has changed the state, the next call returns
    /// [`Event::StateChanged`] before it reads the next frame.
    ///
    /// # Errors
    /// [`ReceiveError`]. The estimate is unchanged, and the next call continues to read.
    pub fn poll(&mut self) -> Result<Event, ReceiveError<SPI::Error, RDY::Error>> {
        match self.stage {
            Stage::Finished => match self.note_state() {
                Some(change) => Ok(change),
                None => self.receive(),
            },
            Stage::Waiting => self.receive(),
            Stage::Received | Stage::Solving => Ok(self.advance()),
            Stage::Solved(outcome) => Ok(self.measure(outcome)),
        }
    }

    fn note_state(&mut self) -> Option<Event> {
        self.stage = Stage::Waiting;
        let after = self.calibrator.state();
        let before = mem::replace(&mut self.state, after);
        (before != after).then_some(Event::StateChanged { before, after })
    }

    fn receive(&mut self) -> Result<Event, ReceiveError<SPI::Error, RDY::Error>> {
        let tracks = self.tracks.as_deref_mut();
        let mut sink = Tracking { calibrator: &mut *self.calibrator, tracks };
        Ok(match self.matcher.poll(&mut sink)? {
            ReadStatus::Idle => Event::Idle,
            ReadStatus::Partial => Event::Reading,
            ReadStatus::Frame(Received { header, taken }) => {
                self.stage = Stage::Received;
                Event::Frame { sequence: header.sequence, offered: header.count.into(), taken }
            }
        })
    }

    /// Takes the next step of the pair.
    fn advance(&mut self) -> Event {
        self.stage = Stage::Solving;
        let Some(outcome) = self.calibrator.advance_pair() else {
            return Event::Pass;
        };
        if self.tracks.as_deref().is_some_and(|tracks| !tracks.quads().is_empty()) {
            self.stage = Stage::Solved(outcome);
            return Event::Pass;
        }
        self.finish(outcome, None)
    }

    /// Takes the next step of the tracks of the pair.
    fn measure(&mut self, outcome: Outcome<f32>) -> Event {
        let tracks = self.tracks.as_deref_mut();
        match tracks.map(|tracks| self.calibrator.advance_tracks(tracks)) {
            Some(None) => Event::Pass,
            Some(motion) => self.finish(outcome, motion),
            None => self.finish(outcome, None),
        }
    }

    /// Reports the pair.
    fn finish(&mut self, Outcome { pair, fused }: Outcome<f32>, motion: Option<Motion>) -> Event {
        self.stage = Stage::Finished;
        let verdict = *self.calibrator.verdict();
        if self.applies {
            // Refused if the estimate is not locked or is in doubt; the verdict has the reason.
            let _ = self.calibrator.apply();
        }
        let outcome = pair.map(|report| (report, fused)).ok_or(fused.err());
        let outcome = outcome.map_err(|why| why.unwrap_or(Rejection::NotBegun));
        Event::Pair(PairOutcome { outcome, verdict, motion })
    }

    /// The calibrator, with the estimate and the extrinsics in use.
    pub fn calibrator(&self) -> &Calibrator<f32, N> {
        self.calibrator
    }

    /// Counters of the link to the matcher.
    pub fn counters(&self) -> &Counters {
        self.matcher.counters()
    }

    /// Passes on a reading of a rangefinder, after [`Event::Pair`] and before the next frame.
    ///
    /// # Errors
    /// [`RangeError`]. The estimate is unchanged.
    pub fn push_range(&mut self, reading: &RangeReading<f32>) -> Result<Witnessed, RangeError> {
        self.calibrator.push_range(reading)
    }

    /// Puts the estimate into use and returns it, with the cameras that it belongs to: `p_r = R p_l + t`.
    ///
    /// # Errors
    /// [`ApplyError`]. The calibration in use is unchanged.
    pub fn apply(&mut self) -> Result<Calibration<f32>, ApplyError> {
        self.calibrator.apply()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_frames::{correspondence, frame};
    use embedded_hal::{digital, spi};
    use std::vec::Vec;
    use stereo_selfcal::link::FrameRefusal;
    use stereo_selfcal::{Camera, Cameras, Config, FactoryCalibration, Intrinsics, Lens};
    use test_support::wire::Wire;

    type TestApp<'a> = App<'a, Wire, Wire, CAPACITY>;

    const CAPACITY: usize = 64;

    const LOCKED: Event = Event::StateChanged { before: State::Acquiring, after: State::Locked };

    fn calibrator() -> Calibrator<f32, CAPACITY> {
        let intrinsics =
            Intrinsics { focal: [1400.0; 2], principal: [960.0, 600.0], size: [1920, 1200] };
        let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        let cameras = Cameras { left: camera, right: camera };
        Calibrator::new(Config::robust(), &FactoryCalibration::guess(cameras))
    }

    fn wire(bytes: Vec<u8>) -> Wire {
        let wire = Wire::exact();
        wire.send(bytes);
        wire
    }

    fn app(bytes: Vec<u8>, calibrator: &mut Calibrator<f32, CAPACITY>) -> TestApp<'_> {
        let wire = wire(bytes);
        App::new(FpgaMatcher::new(wire.clone(), wire), calibrator)
    }

    /// Polls until an event other than `Reading`.
    fn read(
        app: &mut TestApp<'_>,
    ) -> Result<Event, ReceiveError<spi::ErrorKind, digital::ErrorKind>> {
        loop {
            match app.poll() {
                Ok(Event::Reading) => (),
                other => return other,
            }
        }
    }

    /// A frame of 60 points, new ones in each.
    fn pair(sequence: u16) -> Vec<u8> {
        frame(sequence.into(), sequence * 60..sequence * 60 + 60)
    }

    /// Polls until the end of the pair. Returns the number of passes and the outcome.
    fn finish_pair(app: &mut TestApp<'_>) -> (usize, PairOutcome) {
        for passes in 0..200 {
            match app.poll().unwrap() {
                Event::Pass => (),
                Event::Pair(pair) => return (passes, pair),
                other => panic!("{other:?} while a pair is solved"),
            }
        }
        panic!("the pair does not end");
    }

    #[test]
    fn a_frame_is_read_then_solved_by_one_pass_per_poll_then_fused_and_not_applied() {
        let mut calibrator = calibrator();
        let mut app = app((0..4).flat_map(pair).collect(), &mut calibrator);
        for sequence in 0..4 {
            assert_eq!(read(&mut app), Ok(Event::Frame { sequence, offered: 60, taken: 60 }));
            let (passes, pair) = finish_pair(&mut app);
            let (report, fused) = pair.outcome.unwrap();
            assert_eq!((passes, fused), (usize::from(report.passes) + 1, Ok(Fused::Added)));
            assert!(pair.verdict.rows_px > 1.0, "{}", pair.verdict);
            assert_eq!(pair.verdict.should_apply, sequence == 3, "{}", pair.verdict);
            assert_eq!(app.calibrator().in_use().generation, 0);
        }
        assert_eq!(app.poll(), Ok(LOCKED));
        let estimate = app.calibrator().proposal().unwrap().applicable;
        let applied = app.apply().unwrap();
        assert_eq!(applied.extrinsics, estimate);
        assert_eq!(app.calibrator().in_use(), applied);
        assert_eq!(
            (app.calibrator().in_use().generation, &app.calibrator().in_use().extrinsics),
            (1, &estimate)
        );
    }

    #[test]
    fn the_batch_selects_from_a_frame_beyond_capacity_and_is_empty_for_the_next_one() {
        let mut direct = calibrator();
        let mut calibrator = direct.clone();
        let frames = [frame(1, 0..128), frame(2, 0..50)];
        let mut app = app(frames.concat(), &mut calibrator);
        assert_eq!(read(&mut app), Ok(Event::Frame { sequence: 1, offered: 128, taken: CAPACITY }));
        for i in 0..128 {
            direct.push(&correspondence(i)).unwrap();
        }
        let batch = app.calibrator().batch();
        assert_eq!(batch.matches(), direct.batch().matches());
        assert_eq!([batch.offered(), batch.left_out()], [128, 64]);
        finish_pair(&mut app);
        assert_eq!(read(&mut app), Ok(Event::Frame { sequence: 2, offered: 50, taken: 50 }));
    }

    #[test]
    fn a_pair_without_a_solution_is_an_event_and_the_next_one_is_fused() {
        let mut calibrator = calibrator();
        let frames = [frame(1, 0..5), frame(2, 0..60)];
        let mut app = app(frames.concat(), &mut calibrator);
        read(&mut app).unwrap();
        let (_, pair) = finish_pair(&mut app);
        assert_eq!(pair.outcome, Err(Rejection::TooFew { usable: 5, needed: 12 }));
        assert_eq!((pair.verdict.may_arm, app.apply()), (false, Err(ApplyError::NoProposal)));
        read(&mut app).unwrap();
        assert!(matches!(finish_pair(&mut app).1.outcome, Ok((_, Ok(Fused::Added)))));
    }

    #[test]
    fn a_change_of_state_is_reported_once_right_after_its_pair() {
        let mut calibrator = calibrator();
        // Too few points in the last pair.
        let frames: Vec<u8> = (0..6).flat_map(pair).chain(frame(6, 0..5)).collect();
        let mut app = app(frames, &mut calibrator);
        let (mut pairs, mut changes) = (0, Vec::new());
        loop {
            match app.poll().unwrap() {
                Event::Pair(_) => pairs += 1,
                Event::StateChanged { before, after } => changes.push((pairs, before, after)),
                Event::Idle => break,
                _ => (),
            }
        }
        assert_eq!(pairs, 7);
        assert_eq!(changes, [(4, State::Acquiring, State::Locked)]);
    }

    #[test]
    fn a_bus_error_drops_a_frame_and_the_next_one_and_the_third_is_received() {
        let mut calibrator = calibrator();
        let frames = [1, 2, 3].map(|sequence| frame(sequence, 0..60));
        // The third of five reads fails.
        let wire = wire(frames.concat());
        wire.fail_after(2);
        let mut app = App::new(FpgaMatcher::new(wire.clone(), wire), &mut calibrator);
        assert_eq!(read(&mut app), Err(ReceiveError::Bus(spi::ErrorKind::Overrun)));
        assert_eq!(read(&mut app), Ok(Event::Frame { sequence: 3, offered: 60, taken: 60 }));
        assert_eq!((app.counters().good, app.counters().bad_crc), (1, 1));
    }

    #[test]
    fn a_damaged_frame_is_counted_and_never_solved() {
        let mut calibrator = calibrator();
        let [mut damaged, whole] = [1, 2].map(|sequence| frame(sequence, 0..60));
        damaged[100] ^= 1;
        let mut app = app([damaged, whole].concat(), &mut calibrator);
        assert_eq!(read(&mut app), Ok(Event::Frame { sequence: 2, offered: 60, taken: 60 }));
        assert_eq!((app.counters().good, app.counters().bad_crc), (1, 1));
    }

    #[test]
    fn a_frame_of_another_image_size_is_an_error_and_the_next_one_is_received() {
        let mut cameras = calibrator().in_use().cameras;
        let intrinsics = Intrinsics { size: [1920, 1199], ..*cameras.left.intrinsics() };
        cameras.left = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        let mut calibrator = Calibrator::new(Config::robust(), &FactoryCalibration::guess(cameras));
        let mut app = app(frame(1, 0..60), &mut calibrator);
        let refused = ReceiveError::Refused(FrameRefusal::ImageSize([1920, 1200]));
        assert_eq!(read(&mut app), Err(refused));
        assert_eq!(read(&mut app), Ok(Event::Idle));
        assert_eq!(app.counters().refused, 1);
    }

    #[test]
    fn without_a_frame_a_poll_is_idle() {
        let mut calibrator = calibrator();
        let mut app = app(Vec::new(), &mut calibrator);
        assert_eq!(app.poll(), Ok(Event::Idle));
    }
}
