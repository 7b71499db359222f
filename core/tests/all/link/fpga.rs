//! SPI driver: its transactions, errors and time-outs.

use crate::link::sink::Taken;
use crate::link::stream::Frame;
use embedded_hal::{digital, spi};
use stereo_selfcal::link::{FpgaMatcher, FrameRefusal, ReadStatus, ReceiveError};
use test_support::wire::Access::{Pin, Read};
use test_support::wire::{DataReady, Wire};

fn driver(wire: &Wire) -> FpgaMatcher<Wire, Wire> {
    FpgaMatcher::new(wire.clone(), wire.clone())
}

#[test]
fn a_frame_is_read_header_first_then_256_bytes_a_transaction_and_not_beyond_its_end() {
    let wire = Wire::default();
    let frame = Frame::plain(7, 37);
    wire.send(frame.bytes());
    let mut matcher = driver(&wire);
    let mut taken = Taken::default();
    for _ in 0..3 {
        assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Partial));
    }
    assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Frame(frame.whole())));
    assert_eq!(taken.matches, frame.matches);
    let reads = [32, 256, 256, frame.bytes().len() - 544];
    assert_eq!(wire.accesses(), reads.map(|bytes| [Pin, Read(bytes)]).as_flattened());
}

#[test]
fn the_bus_is_not_accessed_while_data_ready_is_low() {
    let wire = Wire::default();
    wire.send(Frame::plain(7, 1).bytes());
    wire.set_ready(DataReady::StuckLow);
    assert_eq!(driver(&wire).poll(&mut Taken::default()), Ok(ReadStatus::Idle));
    assert_eq!(wire.accesses(), [Pin]);
}

#[test]
fn read_does_not_sample_the_data_ready_pin() {
    let wire = Wire::default();
    let frame = Frame::plain(7, 1);
    wire.send(frame.bytes());
    let mut matcher = FpgaMatcher::new(wire.clone(), ());
    let mut taken = Taken::default();
    assert_eq!(matcher.read(&mut taken), Ok(ReadStatus::Partial));
    assert_eq!(matcher.read(&mut taken), Ok(ReadStatus::Frame(frame.whole())));
    assert_eq!(wire.accesses(), [Read(32), Read(frame.bytes().len() - 32)]);
}

#[test]
fn pin_and_bus_are_not_accessed_while_the_sink_is_busy() {
    let wire = Wire::default();
    wire.send(Frame::plain(7, 1).bytes());
    let mut matcher = driver(&wire);
    let mut busy = Taken { busy: true, ..Taken::default() };
    assert_eq!(matcher.poll(&mut busy), Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert_eq!(matcher.read(&mut busy), Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert_eq!(wire.accesses(), []);
}

#[test]
fn an_unreadable_data_ready_pin_is_reported() {
    let wire = Wire::default();
    wire.set_ready(DataReady::Unreadable);
    let polled = driver(&wire).poll(&mut Taken::default());
    assert_eq!(polled, Err(ReceiveError::Ready(digital::ErrorKind::Other)));
    assert_eq!(wire.accesses(), [Pin]);
}

#[test]
fn waiting_frames_are_read_one_per_call() {
    let wire = Wire::default();
    let frames = [Frame::plain(1, 20), Frame::plain(2, 0), Frame::plain(3, 90)];
    wire.send(frames.iter().flat_map(Frame::bytes));
    let mut matcher = driver(&wire);
    let mut taken = Taken::default();
    for frame in &frames {
        assert_eq!(matcher.poll_until(&mut taken, || false), Ok(frame.whole()));
        assert_eq!(taken.matches, frame.matches);
    }
    assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Idle));
    assert_eq!(matcher.counters().skipped_bytes, 0);
}

#[test]
fn a_bus_error_costs_a_frame_and_the_next_one() {
    let wire = Wire::default();
    let frames = [1, 2, 3, 4].map(|sequence| Frame::plain(sequence, 40));
    wire.send(frames.iter().flat_map(Frame::bytes));
    let mut matcher = driver(&wire);
    let mut taken = Taken::default();
    assert_eq!(matcher.poll_until(&mut taken, || false), Ok(frames[0].whole()));
    matcher.poll(&mut taken).unwrap();
    wire.fail_after(0);
    assert_eq!(matcher.poll(&mut taken), Err(ReceiveError::Bus(spi::ErrorKind::Overrun)));
    assert_eq!(matcher.poll_until(&mut taken, || wire.waiting() == 0), Ok(frames[3].whole()));
    assert_eq!(matcher.counters().good, 2);
    assert_eq!(matcher.counters().gaps, 2);
}

#[test]
fn a_pin_that_stays_low_ends_in_a_time_out() {
    let wire = Wire::default();
    let mut asked = 0;
    let waited = driver(&wire).poll_until(&mut Taken::default(), || {
        asked += 1;
        asked == 10
    });
    assert_eq!(waited, Err(ReceiveError::TimedOut));
    assert_eq!((asked, wire.accesses()), (10, vec![Pin; 10]));
}

#[test]
fn idle_bytes_under_a_high_pin_end_in_a_time_out() {
    let wire = Wire::default();
    wire.set_ready(DataReady::StuckHigh);
    let mut matcher = driver(&wire);
    let mut asked = 0;
    let waited = matcher.poll_until(&mut Taken::default(), || {
        asked += 1;
        asked == 10
    });
    assert_eq!(waited, Err(ReceiveError::TimedOut));
    assert_eq!(wire.accesses(), [[Pin, Read(32)]; 10].as_flattened());
    assert_eq!(matcher.counters().skipped_bytes, 320);
}

#[test]
fn after_a_time_out_the_frame_continues() {
    let wire = Wire::default();
    let frame = Frame::plain(1, 40);
    let bytes = frame.bytes();
    wire.send(bytes[..288].iter().copied());
    let mut matcher = driver(&wire);
    let mut taken = Taken::default();
    assert_eq!(matcher.poll_until(&mut taken, || wire.waiting() == 0), Err(ReceiveError::TimedOut));
    wire.send(bytes[288..].iter().copied());
    assert_eq!(matcher.read_until(&mut taken, || false), Ok(frame.whole()));
    assert_eq!(matcher.read_until(&mut taken, || true), Err(ReceiveError::TimedOut));
}

#[test]
fn an_overrun_reported_by_the_caller_is_counted() {
    let mut matcher = FpgaMatcher::new((), ());
    matcher.note_overrun();
    assert_eq!(matcher.counters().overruns, 1);
    assert_eq!(matcher.release(), ((), ()));
}

#[test]
fn a_driver_takes_less_than_512_bytes() {
    let size = size_of::<FpgaMatcher<(), ()>>();
    assert!(size < 512, "{size}");
}
