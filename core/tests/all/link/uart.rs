//! Driver on a byte stream.

use crate::link::sink::Taken;
use crate::link::stream::Frame;
use stereo_selfcal::link::{FrameRefusal, ReadStatus, ReceiveError, StreamMatcher};
use test_support::wire::Wire;

#[test]
fn frames_are_received_over_short_reads() {
    let wire = Wire::default();
    let frames = [1, 2].map(|sequence| Frame::plain(sequence, 60));
    wire.send(frames.iter().flat_map(Frame::bytes));
    let mut matcher = StreamMatcher::new(wire);
    let mut taken = Taken::default();
    for frame in &frames {
        assert_eq!(matcher.poll_until(&mut taken, || false), Ok(frame.whole()));
        assert_eq!(taken.matches, frame.matches);
    }
    assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Idle));
}

#[test]
fn a_blocking_read_returns_the_bytes_available() {
    let wire = Wire::default();
    let frame = Frame::plain(3, 2);
    wire.send(frame.bytes());
    let mut matcher = StreamMatcher::new(wire);
    let mut taken = Taken::default();
    assert_eq!(matcher.read(&mut taken), Ok(ReadStatus::Partial));
    assert_eq!(matcher.read(&mut taken), Ok(ReadStatus::Frame(frame.whole())));
    assert_eq!(matcher.read(&mut taken), Err(ReceiveError::Ended));
}

#[test]
fn a_failing_stream_costs_a_frame_and_the_next_one() {
    let wire = Wire::default();
    let frames = [1, 2, 3].map(|sequence| Frame::plain(sequence, 40));
    wire.send(frames.iter().flat_map(Frame::bytes));
    let mut matcher = StreamMatcher::new(wire.clone());
    let mut taken = Taken::default();
    matcher.poll(&mut taken).unwrap();
    wire.fail_after(0);
    let failed = Err(ReceiveError::Bus(embedded_io::ErrorKind::Other));
    assert_eq!(matcher.poll(&mut taken), failed);
    matcher.note_overrun();
    assert_eq!(matcher.poll_until(&mut taken, || wire.waiting() == 0), Ok(frames[2].whole()));
    assert_eq!(matcher.counters().overruns, 1);
    assert_eq!(matcher.poll_until(&mut taken, || true), Err(ReceiveError::TimedOut));
    assert_eq!(matcher.release().waiting(), 0);
}

#[test]
fn the_stream_is_not_read_while_the_sink_is_busy() {
    let wire = Wire::default();
    wire.send(Frame::plain(1, 1).bytes());
    let mut matcher = StreamMatcher::new(wire.clone());
    let mut busy = Taken { busy: true, ..Taken::default() };
    assert_eq!(matcher.poll(&mut busy), Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert_eq!(matcher.read(&mut busy), Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert_eq!(wire.accesses(), []);
}
