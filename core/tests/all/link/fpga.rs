//! SPI driver: its transactions, errors and time-outs.

use crate::link::bus::{Far, Taken};
use crate::link::stream::Frame;
use embedded_hal::spi::ErrorKind;
use embedded_hal_mock::eh1::MockError;
use embedded_hal_mock::eh1::digital::{
    Mock as PinMock, State::High, State::Low, Transaction as PinTransaction,
};
use embedded_hal_mock::eh1::spi::{Mock as SpiMock, Transaction as SpiTransaction};
use stereo_selfcal::link::{FpgaMatcher, FrameRefusal, ReadStatus, ReceiveError, Received};

/// One transaction with one read.
fn read(bytes: &[u8]) -> [SpiTransaction<u8>; 3] {
    let [start, end] = [SpiTransaction::transaction_start(), SpiTransaction::transaction_end()];
    [start, SpiTransaction::read_vec(bytes.to_vec()), end]
}

fn driver(far: &Far) -> FpgaMatcher<Far, Far> {
    FpgaMatcher::new(far.clone(), far.clone())
}

fn whole(frame: &Frame) -> Received {
    Received { header: frame.header, taken: frame.matches.len() }
}

#[test]
fn a_frame_is_read_header_first_then_256_bytes_a_transaction_and_not_beyond_its_end() {
    let frame = Frame::plain(7, 37);
    let bytes = frame.bytes();
    let pieces = [&bytes[..32], &bytes[32..288], &bytes[288..544], &bytes[544..]];
    let mut spi = SpiMock::new(&pieces.map(read).concat());
    let mut ready = PinMock::new(&[0; 4].map(|_| PinTransaction::get(High)));
    let mut matcher = FpgaMatcher::new(spi.clone(), ready.clone());
    let mut taken = Taken::default();
    for _ in 0..3 {
        assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Partial));
    }
    assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Frame(whole(&frame))));
    assert_eq!(taken.matches, frame.matches);
    spi.done();
    ready.done();
}

#[test]
fn the_bus_is_not_accessed_while_data_ready_is_low() {
    let mut spi = SpiMock::<u8>::new(&[]);
    let mut ready = PinMock::new(&[PinTransaction::get(Low)]);
    let polled = FpgaMatcher::new(spi.clone(), ready.clone()).poll(&mut Taken::default());
    assert_eq!(polled, Ok(ReadStatus::Idle));
    spi.done();
    ready.done();
}

#[test]
fn read_does_not_sample_the_data_ready_pin() {
    let frame = Frame::plain(7, 1);
    let bytes = frame.bytes();
    let mut spi = SpiMock::new(&[&bytes[..32], &bytes[32..]].map(read).concat());
    let mut matcher = FpgaMatcher::new(spi.clone(), ());
    let mut taken = Taken::default();
    assert_eq!(matcher.read(&mut taken), Ok(ReadStatus::Partial));
    assert_eq!(matcher.read(&mut taken), Ok(ReadStatus::Frame(whole(&frame))));
    spi.done();
}

#[test]
fn neither_pin_nor_bus_is_accessed_while_the_sink_is_busy() {
    let mut spi = SpiMock::<u8>::new(&[]);
    let mut ready = PinMock::new(&[]);
    let mut matcher = FpgaMatcher::new(spi.clone(), ready.clone());
    let mut busy = Taken { busy: true, ..Taken::default() };
    assert_eq!(matcher.poll(&mut busy), Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert_eq!(matcher.read(&mut busy), Err(ReceiveError::Refused(FrameRefusal::Busy)));
    spi.done();
    ready.done();
}

#[test]
fn an_unreadable_data_ready_pin_is_reported() {
    let fault = MockError::Io(std::io::ErrorKind::NotConnected);
    let mut spi = SpiMock::<u8>::new(&[]);
    let mut ready = PinMock::new(&[PinTransaction::get(High).with_error(fault.clone())]);
    let polled = FpgaMatcher::new(spi.clone(), ready.clone()).poll(&mut Taken::default());
    assert_eq!(polled, Err(ReceiveError::Ready(fault)));
    spi.done();
    ready.done();
}

#[test]
fn waiting_frames_are_read_one_per_call() {
    let far = Far::default();
    let frames = [Frame::plain(1, 20), Frame::plain(2, 0), Frame::plain(3, 90)];
    far.send(frames.iter().flat_map(Frame::bytes));
    let mut matcher = driver(&far);
    let mut taken = Taken::default();
    for frame in &frames {
        assert_eq!(matcher.poll_until(&mut taken, || false), Ok(whole(frame)));
        assert_eq!(taken.matches, frame.matches);
    }
    assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Idle));
    assert_eq!(matcher.counters().skipped_bytes, 0);
}

#[test]
fn a_bus_error_costs_one_frame() {
    let far = Far::default();
    let frames = [1, 2, 3].map(|sequence| Frame::plain(sequence, 40));
    far.send(frames.iter().flat_map(Frame::bytes));
    let mut matcher = driver(&far);
    let mut taken = Taken::default();
    assert_eq!(matcher.poll_until(&mut taken, || false), Ok(whole(&frames[0])));
    matcher.poll(&mut taken).unwrap();
    far.fail(true);
    assert_eq!(matcher.poll(&mut taken), Err(ReceiveError::Bus(ErrorKind::Overrun)));
    far.fail(false);
    assert_eq!(matcher.poll_until(&mut taken, || !far.waits()), Ok(whole(&frames[2])));
    assert_eq!(matcher.counters().good, 2);
    assert_eq!(matcher.counters().gaps, 1);
}

#[test]
fn two_frames_that_end_in_one_read_are_both_handed_out() {
    let far = Far::default();
    let mut short = Frame::plain(1, 200).bytes();
    short.truncate(100);
    let frames = [2, 3].map(|sequence| Frame::plain(sequence, 1));
    far.send(short.into_iter().chain(frames.iter().flat_map(Frame::bytes)));
    let mut matcher = driver(&far);
    let mut taken = Taken::default();
    assert_eq!(matcher.poll_until(&mut taken, || !far.waits()), Ok(whole(&frames[0])));
    assert_eq!(far.reads(), [32, 256], "the second read holds the end of both");
    // Data-ready is low; the frame is decoded without a read.
    assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Frame(whole(&frames[1]))));
    assert_eq!(matcher.poll(&mut taken), Ok(ReadStatus::Idle));
    assert_eq!(far.reads().len(), 2);
}

#[test]
fn a_pin_that_stays_low_ends_in_a_time_out() {
    let far = Far::default();
    let mut asked = 0;
    let waited = driver(&far).poll_until(&mut Taken::default(), || {
        asked += 1;
        asked == 10
    });
    assert_eq!(waited, Err(ReceiveError::TimedOut));
    assert_eq!((asked, far.reads().len()), (10, 0));
}

#[test]
fn idle_bytes_under_a_high_pin_end_in_a_time_out() {
    let far = Far::default();
    let mut ready = PinMock::new(&[0; 10].map(|_| PinTransaction::get(High)));
    let mut matcher = FpgaMatcher::new(far.clone(), ready.clone());
    let mut asked = 0;
    let waited = matcher.poll_until(&mut Taken::default(), || {
        asked += 1;
        asked == 10
    });
    assert_eq!(waited, Err(ReceiveError::TimedOut));
    assert_eq!(far.reads(), [32; 10]);
    assert_eq!(matcher.counters().skipped_bytes, 320);
    ready.done();
}

#[test]
fn after_a_time_out_the_frame_continues() {
    let far = Far::default();
    let frame = Frame::plain(1, 40);
    let bytes = frame.bytes();
    far.send(bytes[..288].iter().copied());
    let mut matcher = driver(&far);
    let mut taken = Taken::default();
    assert_eq!(matcher.poll_until(&mut taken, || !far.waits()), Err(ReceiveError::TimedOut));
    far.send(bytes[288..].iter().copied());
    assert_eq!(matcher.read_until(&mut taken, || false), Ok(whole(&frame)));
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
