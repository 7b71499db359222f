//! Driver on a byte stream.

use crate::link::bus::{Far, Taken, Uart};
use crate::link::stream::Frame;
use stereo_selfcal::link::{FrameRefusal, ReadStatus, ReceiveError, Received, StreamMatcher};

fn whole(frame: &Frame) -> Received {
    Received { header: frame.header, taken: frame.matches.len() }
}

#[test]
fn frames_are_received_over_short_reads() {
    let far = Far::default();
    let frames = [1, 2].map(|sequence| Frame::plain(sequence, 60));
    far.send(frames.iter().flat_map(Frame::bytes));
    let mut matcher = StreamMatcher::new(Uart(far));
    let mut taken = Taken::default();
    for frame in &frames {
        assert_eq!(matcher.poll_until(&mut taken, || false), Ok(whole(frame)));
        assert_eq!(taken.matches, frame.matches);
    }
    assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Idle));
}

#[test]
fn a_blocking_read_returns_the_bytes_available() {
    let far = Far::default();
    let frame = Frame::plain(3, 2);
    far.send(frame.bytes());
    let mut matcher = StreamMatcher::new(Uart(far));
    let mut taken = Taken::default();
    assert_eq!(matcher.read(&mut taken), Ok(ReadStatus::Partial));
    assert_eq!(matcher.read(&mut taken), Ok(ReadStatus::Frame(whole(&frame))));
    assert_eq!(matcher.read(&mut taken), Err(ReceiveError::Ended));
}

#[test]
fn a_failing_stream_costs_one_frame() {
    let far = Far::default();
    let frames = [1, 2].map(|sequence| Frame::plain(sequence, 40));
    far.send(frames.iter().flat_map(Frame::bytes));
    let mut matcher = StreamMatcher::new(Uart(far.clone()));
    let mut taken = Taken::default();
    matcher.poll(&mut taken).unwrap();
    far.fail(true);
    let failed = Err(ReceiveError::Bus(embedded_io::ErrorKind::Other));
    assert_eq!(matcher.poll(&mut taken), failed);
    far.fail(false);
    matcher.note_overrun();
    assert_eq!(matcher.poll_until(&mut taken, || !far.waits()), Ok(whole(&frames[1])));
    assert_eq!(matcher.counters().overruns, 1);
    assert_eq!(matcher.poll_until(&mut taken, || true), Err(ReceiveError::TimedOut));
    assert!(!matcher.release().0.waits());
}

#[test]
fn the_stream_is_not_read_while_the_sink_is_busy() {
    let far = Far::default();
    far.send(Frame::plain(1, 1).bytes());
    let mut matcher = StreamMatcher::new(Uart(far.clone()));
    let mut busy = Taken { busy: true, ..Taken::default() };
    assert_eq!(matcher.poll(&mut busy), Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert_eq!(matcher.read(&mut busy), Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert!(far.reads().is_empty());
}
