//! Asynchronous driver over `embedded-hal-async`.

use core::future::{Future, poll_fn};
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use crate::link::sink::Taken;
use crate::link::stream::Frame;
use embedded_hal::digital;
use embedded_hal::spi::{ErrorKind, Operation, SpiDevice as _};
use stereo_selfcal::link::{FpgaMatcher, FrameRefusal, ReceiveError};
use test_support::wire::{Access, Wire};

/// [`Wire`] as an asynchronous bus and pin. A transaction is ready at the second poll, the pin once data is waiting.
#[derive(Debug, Clone)]
struct Late(Wire);

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

impl digital::ErrorType for Late {
    type Error = digital::ErrorKind;
}

impl embedded_hal_async::digital::Wait for Late {
    async fn wait_for_high(&mut self) -> Result<(), digital::ErrorKind> {
        poll_fn(|_| if self.0.waiting() > 0 { Poll::Ready(Ok(())) } else { Poll::Pending }).await
    }

    async fn wait_for_low(&mut self) -> Result<(), digital::ErrorKind> {
        panic!("the driver waits for a high level only")
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), digital::ErrorKind> {
        panic!("the driver waits for a high level only")
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), digital::ErrorKind> {
        panic!("the driver waits for a high level only")
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), digital::ErrorKind> {
        panic!("the driver waits for a high level only")
    }
}

/// Polls a future at most `polls` times, then drops it; `None` if it was not ready.
fn within<F: Future>(polls: usize, future: F) -> Option<F::Output> {
    let mut future = pin!(future);
    (0..polls).find_map(|_| match future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => Some(output),
        Poll::Pending => None,
    })
}

fn driver(wire: &Wire) -> FpgaMatcher<Late, Late> {
    FpgaMatcher::new(Late(wire.clone()), Late(wire.clone()))
}

#[test]
fn a_frame_is_awaited_without_bus_access_until_data_ready_is_high() {
    let wire = Wire::default();
    let mut matcher = driver(&wire);
    let mut taken = Taken::default();
    assert_eq!(within(10, matcher.receive(&mut taken)), None);
    assert_eq!(wire.accesses(), []);
    let frame = Frame::plain(1, 40);
    wire.send(frame.bytes());
    assert_eq!(within(10, matcher.receive(&mut taken)), Some(Ok(frame.whole())));
    assert_eq!(wire.accesses(), [32, 256, 256, 132].map(Access::Read));
    assert_eq!(taken.matches, frame.matches);
}

#[test]
fn a_future_dropped_between_transactions_loses_nothing() {
    let wire = Wire::default();
    let frame = Frame::plain(1, 40);
    let bytes = frame.bytes();
    wire.send(bytes[..288].iter().copied());
    let mut matcher = driver(&wire);
    let mut taken = Taken::default();
    assert_eq!(within(10, matcher.receive(&mut taken)), None);
    wire.send(bytes[288..].iter().copied());
    assert_eq!(within(10, matcher.receive(&mut taken)), Some(Ok(frame.whole())));
}

#[test]
fn errors_match_the_blocking_driver() {
    let wire = Wire::default();
    wire.send([0; 32]);
    let mut matcher = driver(&wire);
    let mut taken = Taken { busy: true, ..Taken::default() };
    let busy = Some(Err(ReceiveError::Refused(FrameRefusal::Busy)));
    assert_eq!(within(1, matcher.receive(&mut taken)), busy);
    taken.busy = false;
    wire.fail_after(0);
    let failed = Some(Err(ReceiveError::Bus(ErrorKind::Overrun)));
    assert_eq!(within(2, matcher.receive(&mut taken)), failed);
}
