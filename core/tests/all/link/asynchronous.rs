//! Asynchronous driver over `embedded-hal-async`.

use core::convert::Infallible;
use core::future::{Future, poll_fn};
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use crate::link::bus::{Far, Taken};
use crate::link::stream::Frame;
use embedded_hal::spi::{ErrorKind, Operation, SpiDevice as _};
use stereo_selfcal::link::{FpgaMatcher, FrameRefusal, ReceiveError, Received};

/// [`Far`] as an asynchronous bus and pin; each is ready at the second poll.
#[derive(Debug, Clone)]
struct Late(Far);

async fn once_more() {
    let mut late = false;
    poll_fn(|_| if core::mem::replace(&mut late, true) { Poll::Ready(()) } else { Poll::Pending })
        .await;
}

impl embedded_hal::spi::ErrorType for Late {
    type Error = ErrorKind;
}

impl embedded_hal_async::spi::SpiDevice for Late {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        once_more().await;
        self.0.transaction(operations)
    }
}

impl embedded_hal::digital::ErrorType for Late {
    type Error = Infallible;
}

impl embedded_hal_async::digital::Wait for Late {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        poll_fn(|_| if self.0.waits() { Poll::Ready(Ok(())) } else { Poll::Pending }).await
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        panic!("the driver waits for a high level only")
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        panic!("the driver waits for a high level only")
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        panic!("the driver waits for a high level only")
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        panic!("the driver waits for a high level only")
    }
}

/// Polls a future at most `polls` times, then drops it.
fn within<F: Future>(polls: usize, future: F) -> Option<F::Output> {
    let mut future = pin!(future);
    (0..polls).find_map(|_| match future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => Some(output),
        Poll::Pending => None,
    })
}

fn driver(far: &Far) -> FpgaMatcher<Late, Late> {
    FpgaMatcher::new(Late(far.clone()), Late(far.clone()))
}

#[test]
fn a_frame_is_awaited_without_bus_access_until_data_ready_is_high() {
    let far = Far::default();
    let mut matcher = driver(&far);
    let mut taken = Taken::default();
    assert_eq!(within(10, matcher.receive(&mut taken)), None);
    assert!(far.reads().is_empty());
    let frame = Frame::plain(1, 40);
    far.send(frame.bytes());
    let received = Received { header: frame.header, taken: 40 };
    assert_eq!(within(10, matcher.receive(&mut taken)), Some(Ok(received)));
    assert_eq!(far.reads(), [32, 256, 256, 132]);
    assert_eq!(taken.matches, frame.matches);
}

#[test]
fn a_future_dropped_between_transactions_loses_nothing() {
    let far = Far::default();
    let frame = Frame::plain(1, 40);
    let bytes = frame.bytes();
    far.send(bytes[..288].iter().copied());
    let mut matcher = driver(&far);
    let mut taken = Taken::default();
    assert_eq!(within(10, matcher.receive(&mut taken)), None);
    far.send(bytes[288..].iter().copied());
    let received = Received { header: frame.header, taken: 40 };
    assert_eq!(within(10, matcher.receive(&mut taken)), Some(Ok(received)));
}

#[test]
fn errors_are_those_of_the_blocking_driver() {
    let far = Far::default();
    far.send([0; 32]);
    let mut matcher = driver(&far);
    let mut taken = Taken { busy: true, ..Taken::default() };
    let busy = Some(Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert_eq!(within(1, matcher.receive(&mut taken)), busy);
    taken.busy = false;
    far.fail(true);
    let failed = Some(Err(ReceiveError::Bus(ErrorKind::Overrun)));
    assert_eq!(within(2, matcher.receive(&mut taken)), failed);
}
